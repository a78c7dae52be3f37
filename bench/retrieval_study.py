#!/usr/bin/env python3
"""How much low-discrepancy samples help retrieval: all scores over many seeds, beside random samples.

    retrieval_study.py MEANDER DATA [-n 1024] [--seeds 20] [--json result.json]
    retrieval_study.py MEANDER DATA --sequences spaced,shifted,random --descriptors d2,a3
    retrieval_study.py MEANDER DATA --descriptors d2,pairs,pairs-unsigned --turned

DATA holds retrieval/CLASS/MODEL and dirty/soup_CLASS_NAME.obj (a folder without soups is studied without
them), or CLASS/MODEL itself. With --turned every other model of a class is turned inside out first: its faces
run the other way round. Every seed samples all models with each of the sequences, and scores every combination
of the histogram descriptors with `retrieve select`, on retrieval/ alone and with the soups as further classes. Tables: mean +-
standard deviation over the seeds; the first sequence less each of the others, seed by seed; the choice leaving
one class out. Interrupted (SIGINT), it prints the tables of the seeds that are done.
Python's standard library only. Exit status 1 when a run failed.
"""
import argparse
import json
import math
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
SCORES = ["NN", "1st tier", "2nd tier", "E-measure", "DCG", "mAP"]
DESCRIPTORS = ["d2", "a3", "d1", "d3", "d4", "geodesic", "pairs", "pairs-unsigned", "harmonics", "views",
               "shapedna"]
COMBINATIONS = ["d2", "pairs", "pairs-unsigned", "d2+pairs", "geodesic", "d2+geodesic",
                "d2+a3+d1+d3", "d2+a3+d1+d3+d4", "d2+a3+d1+d3+d4+geodesic"]
CHOSEN = "chosen, one class left out"
SEQUENCES = ["shifted", "random", "stratified", "regular", "spaced"]


class Failure(Exception):
    """A run that cannot be used."""


def run_process(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise Failure(f"{' '.join(command)}: exit {done.returncode}\n{done.stderr[-2000:]}")
    return done.stdout


# ---- models and classes --------------------------------------------------------------------------------------

def classes_of(data):
    """{class: files} of retrieval/ and of the soups, whose class is the middle of their name."""
    clean, soups = {}, {}
    models = data / "retrieval" if (data / "retrieval").is_dir() else data
    for path in sorted(models.glob("*/*")):
        if path.suffix.lower() in EXTENSIONS:
            clean.setdefault(path.parent.name, []).append(path)
    for path in sorted((data / "dirty").glob("soup_*_*.obj")):
        soups.setdefault("soup-" + path.name.split("_")[1], []).append(path)
    if len(clean) < 2:
        raise Failure(f"{models}: fewer than two folders of models")
    names = [path.stem for files in [*clean.values(), *soups.values()] for path in files]
    if len(set(names)) != len(names):
        raise Failure("two models of one name: a .cla file could not tell them apart")
    return clean, soups


def write_classification(path, classes):
    models = sum(len(files) for files in classes.values())
    lines = ["PSB 1", f"{len(classes)} {models}"]
    for name, files in classes.items():
        lines += ["", f"{name} 0 {len(files)}", *(file.stem for file in files)]
    path.write_text("\n".join(lines) + "\n")


# ---- models turned inside out ---------------------------------------------------------------------------------

def turned_off(lines):
    vertices, faces = (int(n) for n in lines[1].split()[:2])
    for i in range(2 + vertices, 2 + vertices + faces):
        count, *rest = lines[i].split()
        corners = rest[:int(count)]
        lines[i] = " ".join([count, *reversed(corners), *rest[int(count):]])
    return lines


def turned_obj(lines):
    return [" ".join(["f", *reversed(line.split()[1:])]) if line.startswith("f ") else line for line in lines]


def turned_ply(content):
    """Of binary little-endian files whose vertices are three floats and whose faces are lists uchar int."""
    end = content.index(b"end_header\n") + len(b"end_header\n")
    header = content[:end].decode("ascii").split("\n")
    properties = [line for line in header if line.startswith("property")]
    if header[1] != "format binary_little_endian 1.0" or [p.split()[1] for p in properties] != ["float"] * 3 + ["list"]:
        raise Failure("a PLY file of another layout cannot be turned inside out")
    vertices, faces = (int(line.split()[2]) for line in header if line.startswith("element"))
    at = end + 12 * vertices
    parts = [content[:at]]
    for _ in range(faces):
        count = content[at]
        corners = [content[k:k + 4] for k in range(at + 1, at + 1 + 4 * count, 4)]
        parts += [content[at:at + 1], *reversed(corners)]
        at += 1 + 4 * count
    return b"".join([*parts, content[at:]])


def turned_inside_out(path, folder):
    """A copy of the model in the folder, of the same name, whose faces run the other way round."""
    copy = folder / path.parent.name / path.name
    copy.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix.lower() == ".ply":
        copy.write_bytes(turned_ply(path.read_bytes()))
        return copy
    turn = {".off": turned_off, ".obj": turned_obj}.get(path.suffix.lower())
    if turn is None:
        raise Failure(f"{path}: only OFF, OBJ and PLY files are turned inside out")
    lines = path.read_text(encoding="utf-8", errors="surrogateescape").splitlines()
    copy.write_text("\n".join(turn(lines)) + "\n", encoding="utf-8", errors="surrogateescape")
    return copy


# ---- the study -----------------------------------------------------------------------------------------------

def scores_of(arguments, store, classification, models):
    """{setting: scores} of the shown combinations and of the honest choice."""
    text = run_process([arguments.meander, "retrieve", "select", str(store), "--classes", str(classification),
                        "--criterion", arguments.criterion, "--weights", "given", "--json"])
    answer = json.loads(text)
    if answer["models"] + sum(answer["left_out"][k] for k in ("not_ok", "not_finite")) != models:
        raise Failure(f"{classification.name}: {answer['models']} of {models} models in the store")
    result = {row["descriptor"]: row for row in answer["settings"]
              if row["distance"] == arguments.distance and row["descriptor"] in arguments.shown}
    result[CHOSEN] = answer["leaving_one_class_out"][0]
    return {name: [result[name][score] for score in SCORES] for name in [*arguments.shown, CHOSEN]}, answer["models"]


def scores_of_seed(arguments, seed, bases, listing, store, scored):
    """{(base, sequence): {setting: scores}} of one seed."""
    result = {}
    for sequence in arguments.sequences:
        run_process([arguments.meander, "run", f"@{listing}", "-o", str(store), "--fresh", "-n",
                     str(arguments.samples), "--sequence", sequence, "--seed", str(seed), "--describe",
                     ",".join(arguments.descriptors), "--bins", str(arguments.bins), "--timeout", "0", "--progress", "none"])
        for base, (classification, models) in bases.items():
            result[base, sequence], scored[base] = scores_of(arguments, store, classification, models)
    return result


def measure(arguments, bases, files, scratch):
    """values[base][sequence][setting]: one list of scores per seed; and how many seeds there are."""
    listing = scratch / "models.txt"
    listing.write_text("".join(f"{file}\n" for file in files))
    values = {base: {s: {name: [] for name in [*arguments.shown, CHOSEN]} for s in arguments.sequences}
              for base in bases}
    scored, done = {}, 0
    try:
        while done < arguments.seeds:
            of_seed = scores_of_seed(arguments, done + 1, bases, listing, scratch / "base.h5", scored)
            for (base, sequence), settings in of_seed.items():
                for name, row in settings.items():
                    values[base][sequence][name].append(row)
            done += 1
            print(f"seed {done} of {arguments.seeds}", file=sys.stderr, flush=True)
    except KeyboardInterrupt:  # what is finished counts, and the tables say how much it is
        if done == 0:
            raise Failure("interrupted before the first seed was done") from None
    return values, scored, done


def spread(numbers):
    return statistics.stdev(numbers) if len(numbers) > 1 else 0.0


def summary_of(values, arguments):
    """Mean and standard deviation of every score, and of its differences first sequence - other by seed."""
    result = {}
    first, *others = arguments.sequences
    for name in [*arguments.shown, CHOSEN]:
        columns = {s: list(zip(*values[s][name])) for s in arguments.sequences}
        entry = {s: [[statistics.mean(c), spread(c)] for c in columns[s]] for s in arguments.sequences}
        entry["difference"] = {}
        for other in others:
            differences = [[a - b for a, b in zip(x, y)] for x, y in zip(columns[first], columns[other])]
            entry["difference"][other] = [[statistics.mean(d), spread(d) / math.sqrt(len(d))] for d in differences]
        result[name] = entry
    return result


def print_tables(base, models, summary, arguments):
    print(f"\n{base}: {models} models, n = {arguments.samples}, {arguments.bins} bins, {arguments.distance}, "
          f"{arguments.seeds} seeds{', every other model inside out' if arguments.turned else ''}; "
          "mean ± standard deviation over seeds\n")
    print("| descriptor | samples | " + " | ".join(SCORES) + " |\n|---|---|" + "---|" * len(SCORES))
    for name, entry in summary.items():
        for sequence in arguments.sequences:
            cells = " | ".join(f"{mean:.3f} ± {sd:.3f}" for mean, sd in entry[sequence])
            print(f"| {name} | {sequence} | {cells} |")
        for other, differences in entry["difference"].items():
            cells = " | ".join(f"{mean:+.3f} ± {error:.3f}" for mean, error in differences)
            print(f"| | {arguments.sequences[0]} - {other}, ± standard error | {cells} |")


def study(arguments):
    clean, soups = classes_of(Path(arguments.data).resolve())
    with tempfile.TemporaryDirectory(prefix="meander-study-", dir=arguments.scratch) as folder:
        scratch = Path(folder)
        bases = {}
        groups = [*clean.values(), *soups.values()]
        name = groups[0][0].parent.parent.name
        for base, classes in {name: clean, f"{name} and soups": {**clean, **soups}}.items():
            if base != name and not soups:
                continue
            classification = scratch / f"{base.replace(' ', '_')}.cla"
            write_classification(classification, classes)
            bases[base] = (classification, sum(len(files) for files in classes.values()))
        files = [turned_inside_out(file, scratch / "turned") if arguments.turned and i % 2 == 1 else file
                 for group in groups for i, file in enumerate(group)]
        start = time.perf_counter()
        values, scored, arguments.seeds = measure(arguments, bases, files, scratch)
        seconds = time.perf_counter() - start
    context = {"meander": run_process([arguments.meander, "--version"]).strip(), "cores": os.cpu_count(),
               "system": platform.platform(), "samples": arguments.samples, "bins": arguments.bins,
               "distance": arguments.distance, "turned": arguments.turned,
               "criterion": arguments.criterion, "seeds": arguments.seeds,
               "seconds": seconds}
    print(f"{context['meander']}; {len(files)} files, "
          f"{len(arguments.sequences) * arguments.seeds} runs and their scores in {seconds:.0f} s")
    summaries = {base: summary_of(v, arguments) for base, v in values.items()}
    for base, summary in summaries.items():
        print_tables(base, scored[base], summary, arguments)
    if arguments.json:
        Path(arguments.json).write_text(json.dumps({"context": context, "scores": SCORES, "models": scored,
                                                    "summaries": summaries, "values": values}, indent=1) + "\n")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meander", help="the program")
    parser.add_argument("data", help="folder with retrieval/ and dirty/")
    parser.add_argument("-n", "--samples", type=int, default=1024, help="samples per model (default 1024)")
    parser.add_argument("--bins", type=int, default=64, help="bins of every histogram (default 64)")
    parser.add_argument("--seeds", type=int, default=20, help="seeds 1, 2, ... (default 20)")
    parser.add_argument("--sequences", default="shifted,random",
                        help=f"the first is compared with the others (default shifted,random), of {', '.join(SEQUENCES)}")
    parser.add_argument("--descriptors", default=",".join(DESCRIPTORS[:6]),
                        help=f"histograms that are made and combined, of {', '.join(DESCRIPTORS)} (default the first six)")
    parser.add_argument("--turned", action="store_true", help="turn every other model of a class inside out")
    parser.add_argument("--distance", default="l1", help="of the fixed combinations (default l1)")
    parser.add_argument("--criterion", default="nn+ft", help="of the choice (default nn+ft)")
    parser.add_argument("--json", metavar="FILE", help="all scores of all seeds as JSON")
    parser.add_argument("--scratch", default=None, help="folder for stores (default: the system's)")
    arguments = parser.parse_args()
    if arguments.seeds < 1:
        parser.error("--seeds: at least 1")
    arguments.sequences, arguments.descriptors = arguments.sequences.split(","), arguments.descriptors.split(",")
    for name, known in (("sequences", SEQUENCES), ("descriptors", DESCRIPTORS)):
        chosen = getattr(arguments, name)
        if not set(chosen) <= set(known) or len(set(chosen)) != len(chosen):
            parser.error(f"--{name}: of {', '.join(known)}, each once")
    arguments.shown = [c for c in COMBINATIONS if set(c.split("+")) <= set(arguments.descriptors)]
    arguments.shown += [d for d in arguments.descriptors if d not in arguments.shown]
    arguments.meander = os.path.abspath(shutil.which(arguments.meander) or arguments.meander)
    try:
        return study(arguments)
    except Failure as failure:
        print(f"retrieval_study: {failure}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
