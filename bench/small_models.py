#!/usr/bin/env python3
"""Many small models: processor microseconds a model, of one program or of two in turn.

    small_models.py MEANDER [--against OTHER] [--models 5000] [--rows 10] [--samples 256,1024] [--rounds 5]
                    [--json FILE] [-- OPTIONS OF meander run]

Writes --models tori of 2 * --rows * --rows faces as text (OFF), each of other proportions, and samples them with `-j 1`
by the default method and by `--method direct`. The table gives processor time a model of the whole process, least,
median and spread of the rounds; the least without the seconds that the run reports for reading; peak memory, and a
checksum of ids and points, which is the same in all rounds. With --against, what MEANDER takes as a share of what OTHER
takes, least by least. Needs python3-h5py. Exit status 1 when a run failed or gave other points.
"""
import argparse
import json
import math
import os
import shutil
import sys
import tempfile
from pathlib import Path

from compare_peers import Failure, check_store, figures_of, run_process, stage_times

METHODS = {"default": [], "direct": ["--method", "direct"]}


def write_torus(path, rows, tube):
    """A torus of radius 1 of 2 * rows * rows triangles."""
    lines = ["OFF", f"{rows * rows} {2 * rows * rows} 0"]
    for i in range(rows):
        for j in range(rows):
            u, v = 2 * math.pi * i / rows, 2 * math.pi * j / rows
            ring = 1 + tube * math.cos(v)
            lines.append(f"{ring * math.cos(u):.6f} {ring * math.sin(u):.6f} {tube * math.sin(v):.6f}")
    for i in range(rows):
        for j in range(rows):
            a, b = i * rows, (i + 1) % rows * rows
            k = (j + 1) % rows
            lines += [f"3 {a + j} {b + j} {b + k}", f"3 {a + j} {b + k} {a + k}"]
    path.write_text("\n".join(lines) + "\n")


def run_once(program, folder, scratch, models, samples, options):
    shutil.rmtree(scratch, ignore_errors=True)
    scratch.mkdir()
    store = scratch / "store.h5"
    command = [program, "run", str(folder), "-o", str(store), "-n", str(samples), "-j", "1", "--progress", "none",
               *options]
    _, processor, _, peak = run_process([command], dict(os.environ))
    reading = stage_times(store).get("read_mesh", 0.0)
    per_model = 1e6 / models
    return {"microseconds": processor * per_model, "without_reading": (processor - reading) * per_model,
            "peak_mib": peak, "checksum": check_store(store, models, samples)}


def measure(given, programs, folder, scratch):
    results = []
    for samples in given.samples:
        for method, options in METHODS.items():
            runs = {name: [] for name in programs}
            for round_ in range(given.rounds):
                for name in list(programs)[::1 if round_ % 2 == 0 else -1]:
                    runs[name].append(run_once(programs[name], folder, scratch, given.models, samples,
                                               options + given.options))
            for name, some in runs.items():
                checksums = {run["checksum"] for run in some}
                if len(checksums) > 1:
                    raise Failure(f"{name}, {method}, n = {samples}: the rounds gave different points")
                results.append({"samples": samples, "method": method, "program": name,
                                **figures_of([run["microseconds"] for run in some]),
                                "without_reading": min(run["without_reading"] for run in some),
                                "peak_mib": max(run["peak_mib"] for run in some), "checksum": checksums.pop()})
    for result in results:
        other = [r for r in results if r["program"] != result["program"] and r["samples"] == result["samples"]
                 and r["method"] == result["method"]]
        if other and result["program"] == "meander":
            result["share"] = result["without_reading"] / other[0]["without_reading"]
    return results


def print_table(results):
    print(f"{'n':>6} {'method':8} {'program':8} {'min us':>8} {'median':>8} {'spread':>7} {'less reading':>12} "
          f"{'share':>6} {'peak MiB':>9}  checksum")
    for r in results:
        share = f"{r['share']:6.3f}" if "share" in r else f"{'-':>6}"
        print(f"{r['samples']:6d} {r['method']:8} {r['program']:8} {r['minimum']:8.0f} {r['median']:8.0f} "
              f"{100 * r['spread']:6.1f}% {r['without_reading']:12.0f} {share} {r['peak_mib']:9.0f}  {r['checksum']}")


def main():
    words, options = sys.argv[1:], []
    if "--" in words:
        words, options = words[:words.index("--")], words[words.index("--") + 1:]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meander", help="the program")
    parser.add_argument("--against", metavar="OTHER", help="another build of it")
    parser.add_argument("--models", type=int, default=5000)
    parser.add_argument("--rows", type=int, default=10, help="of the grid of a torus, both ways")
    parser.add_argument("--samples", default="256,1024", help="of a model, one number or more")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json", metavar="FILE", help="where the figures go, too")
    given = parser.parse_args(words)
    given.samples = [int(number) for number in given.samples.split(",")]
    given.options = options
    programs = {"meander": os.path.abspath(given.meander)}
    if given.against:
        programs["other"] = os.path.abspath(given.against)
    try:
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name) / "models"
            folder.mkdir()
            for i in range(given.models):
                # Golden-ratio steps: every model is another.
                write_torus(folder / f"{i:06d}.off", given.rows, 0.2 + 0.5 * math.fmod(0.6180339887498949 * i, 1.0))
            results = measure(given, programs, folder, Path(name) / "out")
    except Failure as failure:
        sys.exit(f"small_models: {failure}")
    print_table(results)
    if given.json:
        Path(given.json).write_text(json.dumps({"models": given.models, "faces": 2 * given.rows**2,
                                                "options": options, "results": results}, indent=1) + "\n")


if __name__ == "__main__":
    main()
