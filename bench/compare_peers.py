#!/usr/bin/env python3
"""End-to-end bench: a folder of meshes to n samples each, Meander beside its peers, on the same files.

    compare_peers.py MEANDER FOLDER [-n 2048] [--rounds 5] [--vcg PROGRAM] [--igl PROGRAM] [--json result.json]

Every case runs once a round, in turn, so that a slow minute of the machine meets all of them; the table gives
the fastest and the median run and the spread, in wall and in processor seconds, models per second (of the
fastest run), the ratio to the fastest peer, and peak memory. Peers: Open3D where Python can import it, VCG and
libigl where their programs are given. Needs Debian's python3-h5py, for Open3D python3-open3d; see README.md for
what is and what is not counted. Exit status 1 when a run failed or a store is not what it must be.
"""
import argparse
import hashlib
import importlib.util
import json
import os
import platform
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

EXTENSIONS = {".off", ".obj", ".ply", ".stl"}
# The peers that are programs of their own: name of the case by option.
PROGRAMS = {"vcg": "vcg montecarlo", "igl": "igl random points"}


class Failure(Exception):
    """A run that cannot be compared."""


# ---- Open3D, run in a process of its own ---------------------------------------------------------------------

def run_open3d(method, list_file, samples):
    """Samples every file of the list; prints one JSON object. Times without interpreter and imports."""
    import numpy
    import open3d

    open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
    open3d.utility.random.seed(1)
    paths = Path(list_file).read_text().split("\n")
    usable, digest, points_seen = [], hashlib.sha256(), 0
    start, processor_start = time.perf_counter(), time.process_time()
    for path in filter(None, paths):
        mesh = open3d.io.read_triangle_mesh(path)
        if len(mesh.triangles) == 0 or not mesh.get_surface_area() > 0:
            continue
        usable.append(path)
        if method == "probe":
            continue
        if method == "uniform":
            cloud = mesh.sample_points_uniformly(samples)
        else:
            cloud = mesh.sample_points_poisson_disk(samples)
        points = numpy.asarray(cloud.points, dtype=numpy.float32)
        points_seen += len(points)
        digest.update(points.tobytes())
    seconds, processor = time.perf_counter() - start, time.process_time() - processor_start
    json.dump({"seconds": seconds, "processor_seconds": processor, "models": len(usable), "points": points_seen,
               "usable": usable, "checksum": digest.hexdigest()[:16], "version": open3d.__version__}, sys.stdout)


# ---- running and checking ------------------------------------------------------------------------------------

def run_process(commands, environment):
    """Runs the commands side by side: wall and processor seconds of all, outputs, and the sum of peak memory in MiB.

    Processor seconds are user and system time of the processes and of all that they waited for."""
    # Errors go to files: a pipe that nobody reads yet would stop a talkative child.
    errors = [tempfile.TemporaryFile() for _ in commands]
    start = time.perf_counter()
    children = [subprocess.Popen(c, env=environment, stdout=subprocess.PIPE, stderr=e)
                for c, e in zip(commands, errors)]
    outputs, peak_kib, processor = [], 0, 0.0
    for child, command, error in zip(children, commands, errors):
        outputs.append(child.stdout.read())
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        peak_kib += usage.ru_maxrss
        processor += usage.ru_utime + usage.ru_stime
        if child.returncode != 0:
            error.seek(0)
            text = error.read().decode(errors="replace")[-2000:]
            raise Failure(f"{' '.join(command)}: exit {child.returncode}\n{text}")
    return time.perf_counter() - start, processor, outputs, peak_kib / 1024


def check_store(store, models, samples):
    """All rows ok, all points finite; a checksum over ids and points."""
    import h5py
    import numpy

    with h5py.File(store, "r") as file:
        status = file["items/status"][:]
        points = file["points"]
        if len(status) != models or points.shape != (models, samples, 3):
            raise Failure(f"{store}: {len(status)} rows of {points.shape[1:]}, expected {models} of ({samples}, 3)")
        if status.any():
            raise Failure(f"{store}: {int((status != 0).sum())} rows are not ok")
        digest = hashlib.sha256()
        for row in range(0, models, 256):
            block = points[row:row + 256]
            if not numpy.isfinite(block).all():
                raise Failure(f"{store}: points that are not finite in an ok row")
            digest.update(numpy.ascontiguousarray(block).tobytes())
    return digest.hexdigest()[:16]


def failed_ids(store):
    """Input paths (as far as known) of the rows that are not ok."""
    import h5py

    with h5py.File(store, "r") as file:
        status = file["items/status"][:]
        names = file["items/id"][:]
    return {name.decode() if isinstance(name, bytes) else str(name) for name, s in zip(names, status) if s != 0}


def stage_times(store):
    """Busy seconds by node from STORE.run.json, or nothing."""
    path = Path(f"{store}.run.json")
    if not path.exists():
        return {}
    nodes = json.loads(path.read_text()).get("nodes", [])
    return {node["name"]: node["busy_seconds"] for node in nodes if node.get("busy_seconds", 0) > 0}


class Bench:
    def __init__(self, arguments, scratch):
        self.arguments = arguments
        self.scratch = Path(scratch)
        self.environment = dict(os.environ, OMP_NUM_THREADS="1")
        self.versions = {}
        self.has_open3d = importlib.util.find_spec("open3d") is not None
        self.programs = {option: program for option in PROGRAMS if (program := getattr(arguments, option))}

    def write_list(self, name, files):
        path = self.scratch / name
        path.write_text("".join(f"{file}\n" for file in files))
        return path

    def meander(self, lists, models, options, threads=1):
        """One run per list, side by side; stores are checked after the clock has stopped."""
        stores = [self.scratch / f"store{i}.h5" for i in range(len(lists))]
        for store in stores:
            for stale in (store, Path(f"{store}.run.json")):
                stale.unlink(missing_ok=True)
            shutil.rmtree(f"{store}.run", ignore_errors=True)
        commands = [[self.arguments.meander, "run", f"@{list_file}", "-o", str(store), "-n",
                     str(self.arguments.samples), "-j", str(threads), "--progress", "none", "--stats", *options]
                    for list_file, store in zip(lists, stores)]
        seconds, processor, _, peak = run_process(commands, self.environment)
        checksums = [check_store(s, m, self.arguments.samples) for s, m in zip(stores, models)]
        sizes = sum(s.stat().st_size for s in stores)
        return {"seconds": seconds, "processor_seconds": processor, "peak_mib": peak,
                "checksum": "+".join(checksums), "models": sum(models), "bytes": sizes,
                "stages": stage_times(stores[0]) if len(stores) == 1 else {}}

    def open3d(self, method, list_file):
        command = [sys.executable, os.path.abspath(__file__), "--open3d", method, str(list_file), "-n",
                   str(self.arguments.samples)]
        _, _, outputs, peak = run_process([command], self.environment)
        result = json.loads(outputs[0])
        self.versions["open3d"] = result["version"]
        return {"seconds": result["seconds"], "processor_seconds": result["processor_seconds"], "peak_mib": peak,
                "checksum": result["checksum"], "models": result["models"], "points": result["points"],
                "usable": result["usable"]}

    def program(self, option, list_file):
        """A peer's program over the list; its answer is one JSON object (README.md)."""
        command = [self.programs[option], str(self.arguments.samples), f"@{list_file}"]
        seconds, processor, outputs, peak = run_process([command], self.environment)
        try:
            answer = json.loads(outputs[0])
            result = {"models": answer["models"], "points": answer["points"], "checksum": answer["checksum"],
                      "failed": set(answer["failed"])}
            if not all(isinstance(i, int) and i >= 0 for i in result["failed"]):
                raise ValueError("failed")
        except (ValueError, KeyError, TypeError) as error:
            raise Failure(f"{' '.join(command)}: not the answer of a peer: {error!r}") from error
        if result["points"] != result["models"] * self.arguments.samples:
            raise Failure(f"{' '.join(command)}: {result['points']} points of {result['models']} models")
        return {"seconds": seconds, "processor_seconds": processor, "peak_mib": peak, **result}

    def peer(self, name, run, list_file, models):
        """One run of a peer, which must sample every file of the list."""
        result = run(name, list_file)
        if result["models"] != models:
            raise Failure(f"{name}: {result['models']} models sampled, expected {models}")
        return result

    def common_files(self):
        """The files of the folder, those that every program can sample, and how many each cannot, by name."""
        folder = Path(self.arguments.folder).resolve()
        files = sorted(str(p) for p in folder.rglob("*") if p.is_file() and p.suffix.lower() in EXTENSIONS)
        if not files:
            raise Failure(f"{folder}: no mesh files")
        everything = self.write_list("all.txt", files)
        unusable = {}
        if self.has_open3d:
            unusable["Open3D"] = set(files) - set(self.open3d("probe", everything)["usable"])
        for option in self.programs:
            unusable[PROGRAMS[option]] = {files[i] for i in self.program(option, everything)["failed"]}
        store = self.scratch / "probe.h5"
        command = [self.arguments.meander, "run", str(folder), "-o", str(store), "-n",
                   str(self.arguments.samples), "--progress", "none", "--method", "direct"]
        status = subprocess.run(command, env=self.environment, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, check=False)
        if status.returncode not in (0, 3):
            raise Failure(f"{' '.join(command)}: exit {status.returncode}\n{status.stderr.decode()[-2000:]}")
        unusable["Meander"] = {str(folder / name) for name in failed_ids(store)}
        left_out = set().union(*unusable.values())
        common = [f for f in files if f not in left_out]
        return files, common, {name: len(some) for name, some in unusable.items()}


# ---- cases ---------------------------------------------------------------------------------------------------

def cases_of(bench, files, poisson_every):
    """(name, function) pairs; each function runs the case once."""
    everything = bench.write_list("files.txt", files)
    count = len(files)
    cases = []
    if bench.has_open3d:
        cases.append(("open3d uniform", lambda: bench.peer("uniform", bench.open3d, everything, count)))
    for option in bench.programs:
        cases.append((PROGRAMS[option],
                      lambda option=option: bench.peer(option, bench.program, everything, count)))
    cases += [
        ("meander auto, no compression", lambda: bench.meander([everything], [count], ["--compress", "none"])),
        ("meander auto", lambda: bench.meander([everything], [count], [])),
        ("meander direct, no compression",
         lambda: bench.meander([everything], [count], ["--method", "direct", "--compress", "none"])),
        ("meander direct", lambda: bench.meander([everything], [count], ["--method", "direct"])),
        ("meander direct, no topology, no compression",
         lambda: bench.meander([everything], [count],
                               ["--method", "direct", "--topology", "none", "--compress", "none"])),
        ("meander direct, balanced, no compression",
         lambda: bench.meander([everything], [count],
                               ["--method", "direct", "--curve", "balanced", "--compress", "none"])),
        ("meander direct, balanced",
         lambda: bench.meander([everything], [count], ["--method", "direct", "--curve", "balanced"])),
        ("meander conformal, elements",
         lambda: bench.meander([everything], [count], ["--method", "conformal", "--locate", "elements"])),
        ("meander conformal", lambda: bench.meander([everything], [count], ["--method", "conformal"])),
    ]
    if poisson_every > 0 and bench.has_open3d:
        some = files[::poisson_every]
        poisson = bench.write_list("poisson.txt", some)
        cases.append((f"open3d poisson disk (every {poisson_every}. file)" if poisson_every > 1
                      else "open3d poisson disk", lambda: bench.peer("poisson", bench.open3d, poisson, len(some))))
    if (os.cpu_count() or 1) >= 2 and count >= 2:
        # Halves of every second file: as equal as a folder's order allows.
        halves = [files[0::2], files[1::2]]
        lists = [bench.write_list(f"half{i}.txt", half) for i, half in enumerate(halves)]
        sizes = [len(half) for half in halves]
        cases += [
            ("meander conformal -j 2", lambda: bench.meander([everything], [count], ["--method", "conformal"], threads=2)),
            ("meander conformal, two processes", lambda: bench.meander(lists, sizes, ["--method", "conformal"])),
        ]
    return cases


def figures_of(values):
    return {"minimum": min(values), "median": statistics.median(values),
            "spread": (max(values) - min(values)) / min(values)}


def summary_of(runs):
    seconds = [run["seconds"] for run in runs]
    fastest = runs[seconds.index(min(seconds))]
    wall = figures_of(seconds)
    processor = figures_of([run["processor_seconds"] for run in runs])
    models = runs[0]["models"]
    return {"runs": [{k: v for k, v in run.items() if k not in ("usable", "failed")} for run in runs],
            **wall, "processor": processor, "models": models, "models_per_second": models / wall["minimum"],
            "models_per_processor_second": models / processor["minimum"],
            "peak_mib": max(run["peak_mib"] for run in runs), "checksums": sorted({r["checksum"] for r in runs}),
            "stages": fastest.get("stages", {})}


def add_ratios(results):
    """Ratios of models per second, wall and processor, to the fastest peer in each; the names of those peers.

    Peers that ran on some of the files only have a ratio but are none to others."""
    everything = max(r["models"] for r in results.values())
    peers = [n for n, r in results.items() if not n.startswith("meander") and r["models"] == everything]
    fastest = {}
    for speed, ratio in (("models_per_second", "ratio"), ("models_per_processor_second", "processor_ratio")):
        if peers:
            fastest[ratio] = max(peers, key=lambda name: results[name][speed])
        for r in results.values():
            r[ratio] = r[speed] / results[fastest[ratio]][speed] if peers else None
    return fastest


def print_table(results, fastest):
    def cell(ratio):
        return f"{ratio:7.3f}" if ratio is not None else f"{'-':>7}"

    print(f"{'':51} {'wall':-^43} {'processor':-^43}")
    figures = f"{'min s':>8} {'median':>8} {'spread':>7} {'models/s':>9} {'ratio':>7} "
    print(f"{'case':44} {'models':>6} {figures}{figures}{'peak MiB':>9}  checksum")
    for name, r in results.items():
        checksum = r["checksums"][0] if len(r["checksums"]) == 1 else f"{len(r['checksums'])} different"
        p = r["processor"]
        print(f"{name:44} {r['models']:6d} "
              f"{r['minimum']:8.3f} {r['median']:8.3f} {100 * r['spread']:6.1f}% {r['models_per_second']:9.2f} "
              f"{cell(r['ratio'])} {p['minimum']:8.3f} {p['median']:8.3f} {100 * p['spread']:6.1f}% "
              f"{r['models_per_processor_second']:9.2f} {cell(r['processor_ratio'])} {r['peak_mib']:9.0f}  "
              f"{str(checksum)[:33]}")
    if fastest:
        print(f"ratios to {fastest['ratio']} (wall) and {fastest['processor_ratio']} (processor)")
    for name, r in results.items():
        total = sum(r["stages"].values())
        if total > 0:
            shares = ", ".join(f"{stage} {100 * busy / total:.1f} %" for stage, busy in r["stages"].items())
            print(f"stages of {name}: {shares}; busy {total:.3f} s of {r['minimum']:.3f} s")


def problems_of(results):
    """Promises that the runs broke: equal bytes for equal parameters, whatever the threads."""
    problems = [f"{name}: the runs gave different points" for name, r in results.items()
                if name.startswith("meander") and len(r["checksums"]) > 1]
    same = [n for n in ("meander conformal", "meander conformal -j 2") if n in results]
    if len({tuple(results[n]["checksums"]) for n in same}) > 1:
        problems.append("-j 1 and -j 2 gave different points")
    for method in ("auto", "direct", "direct, balanced"):
        same = [n for n in (f"meander {method}", f"meander {method}, no compression") if n in results]
        if len({tuple(results[n]["checksums"]) for n in same}) > 1:
            problems.append("compression changed the points")
    return problems


def context_of(bench):
    cpu = next((line.split(":", 1)[1].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
                if line.startswith("model name")), platform.processor())
    version = subprocess.run([bench.arguments.meander, "--version"], capture_output=True, text=True, check=False)
    return {"cpu": cpu, "cores": os.cpu_count(), "system": platform.platform(), "python": platform.python_version(),
            "meander": version.stdout.strip(), "open3d": bench.versions.get("open3d", ""),
            "programs": {PROGRAMS[option]: os.path.basename(program) for option, program in bench.programs.items()},
            "load_average": os.getloadavg()[0], "samples": bench.arguments.samples}


def peers_of(bench):
    """What each peer is, or that it was skipped."""
    yield f"Open3D {bench.versions.get('open3d', '')}" if bench.has_open3d else "Open3D skipped (cannot be imported)"
    for option, name in PROGRAMS.items():
        yield name if option in bench.programs else f"{name} skipped (no --{option})"


def compare(arguments):
    with tempfile.TemporaryDirectory(prefix="meander-bench-", dir=arguments.scratch) as scratch:
        bench = Bench(arguments, scratch)
        files, common, left_out = bench.common_files()
        if not common:
            raise Failure("no file that all programs can sample")
        if arguments.limit:
            common = common[::max(1, len(common) // arguments.limit)]
        megabytes = sum(os.path.getsize(f) for f in common) / 1e6
        context = context_of(bench)
        print(f"{context['cpu']}, {context['cores']} cores, {context['system']}; {context['meander']}; "
              f"load {context['load_average']:.2f}")
        print("peers: " + "; ".join(peers_of(bench)))
        left_out_text = ", ".join(f"{number} by {name}" for name, number in left_out.items())
        print(f"{len(common)} of {len(files)} files ({megabytes:.1f} MB), {arguments.samples} samples each; "
              f"not sampled: {left_out_text}; {arguments.rounds} rounds")
        cases = cases_of(bench, common, arguments.poisson_every)
        runs = {name: [] for name, _ in cases}
        for _ in range(arguments.rounds):
            for name, run in cases:
                runs[name].append(run())
        results = {name: summary_of(r) for name, r in runs.items()}
    fastest = add_ratios(results)
    print_table(results, fastest)
    problems = problems_of(results)
    for problem in problems:
        print(f"PROBLEM: {problem}")
    if arguments.json:
        Path(arguments.json).write_text(json.dumps({"context": context, "files": len(common), "megabytes": megabytes,
                                                    "not_sampled": left_out, "fastest_peer": fastest,
                                                    "cases": results, "problems": problems}, indent=1) + "\n")
    return 1 if problems else 0


def main():
    if "--open3d" in sys.argv[1:2]:
        run_open3d(sys.argv[2], sys.argv[3], int(sys.argv[5]))
        return 0
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meander", help="the program")
    parser.add_argument("folder", help="folder of meshes (recursive)")
    parser.add_argument("-n", "--samples", type=int, default=2048, help="samples per model (default 2048)")
    parser.add_argument("--rounds", type=int, default=5, help="runs of every case (default 5)")
    parser.add_argument("--poisson-every", type=int, default=10, metavar="K",
                        help="Poisson disk sampling on every K-th file only, 0: not at all (default 10)")
    parser.add_argument("--vcg", metavar="PROGRAM", help="program of VCG's Montecarlo sampler")
    parser.add_argument("--igl", metavar="PROGRAM", help="program of libigl's random_points_on_mesh")
    parser.add_argument("--limit", type=int, default=0, help="use about this many of the files, evenly spread")
    parser.add_argument("--json", metavar="FILE", help="all times, checksums and the machine as JSON")
    parser.add_argument("--scratch", default=None, help="folder for stores (default: the system's)")
    arguments = parser.parse_args()
    for option in ("meander", *PROGRAMS):
        if program := getattr(arguments, option):
            setattr(arguments, option, os.path.abspath(shutil.which(program) or program))
    try:
        return compare(arguments)
    except Failure as failure:
        print(f"compare_peers: {failure}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
