#!/usr/bin/env python3
"""What `retrieve` finds without classes, over many seeds: nearest neighbor, first tier and DCG of descriptors and rankings.

    ranking_study.py MEANDER MODELS [-n 1024] [--seeds 20] [--sequences shifted] [--descriptors best] [--ranks scaled,diffusion]
    ranking_study.py MEANDER MODELS --local-points 20,40,80,160,320,640 --sequences shifted,random --descriptors local-pairs
    ranking_study.py MEANDER MODELS --per-class 2,6,30,0
    ranking_study.py MEANDER MODELS --turned

MODELS holds models in folders that name their classes. Every seed samples all of them with pairs and views, learns the
words of local pairs, and scores every model as a query; `best` are all three descriptors, what `retrieve` compares without
--descriptor. --per-class: up to so many models of each class, others for every seed (0: all). With --turned every other model
of a class is turned inside out first. Printed: mean +- standard deviation over the seeds, and the mean difference to the
first of --ranks. Python's standard library only. Exit status 1 when a run failed.
"""
import argparse
import json
import os
import random
import shutil
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

from retrieval_study import EXTENSIONS, Failure, spread, turned_inside_out, write_classification

SCORES = ["NN", "1st tier", "DCG"]
BEST = "pairs+views+local-pairs"


def run_process(command, allowed=(0,)):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode not in allowed:
        raise Failure(f"{' '.join(command)}: exit {done.returncode}\n{done.stderr[-2000:]}")
    return done.stdout


def classes_of(models):
    classes = {}
    for path in sorted(models.glob("*/*")):
        if path.suffix.lower() in EXTENSIONS:
            classes.setdefault(path.parent.name, []).append(path)
    if len(classes) < 2:
        raise Failure(f"{models}: fewer than two folders of models")
    names = [path.stem for files in classes.values() for path in files]
    if len(set(names)) != len(names):
        raise Failure("two models of one name: a .cla file could not tell them apart")
    return classes


def subset_of(classes, count, seed):
    """Up to `count` models of each class (0: all), and the classes that have two of them."""
    drawn = random.Random(seed)
    few = {name: sorted(drawn.sample(files, min(count, len(files)))) if count else files for name, files in classes.items()}
    return {name: files for name, files in few.items() if len(files) > 1} if count else few


def measure_seed(arguments, seed, classes, listing, scratch, values):
    store = scratch / "base.h5"
    for sequence in arguments.sequences:
        run_process([arguments.meander, "run", f"@{listing}", "-o", str(store), "--fresh", "-n", str(arguments.samples),
                     "--sequence", sequence, "--seed", str(seed), "--describe", "pairs,views", "--timeout", "0",
                     "--progress", "none"], allowed=(0, 3))
        for points in arguments.local_points:
            run_process([arguments.meander, "retrieve", "words", str(store), "--replace", "--local-points", str(points)])
            for count in arguments.per_class:
                classification = scratch / "classes.cla"
                write_classification(classification, subset_of(classes, count, seed))
                for descriptor in arguments.descriptors:
                    for rank in arguments.ranks:
                        answer = json.loads(run_process(
                            [arguments.meander, "retrieve", "evaluate", str(store), "--classes", str(classification),
                             "--descriptor", BEST if descriptor == "best" else descriptor, "--rank", rank, "--json"]))
                        values.setdefault((sequence, points, count, descriptor, rank), []).append(
                            [answer["results"][0][score] for score in SCORES])


def print_table(arguments, models, values):
    first = arguments.ranks[0]
    print(f"{models} models, n = {arguments.samples}, {arguments.seeds} seeds"
          f"{', every other model inside out' if arguments.turned else ''}; mean ± standard deviation over seeds\n")
    print("| samples | local points | models a class | descriptor | rank | " + " | ".join(SCORES) + " | NN less that of "
          + first + " |\n|---|---|---|---|---|" + "---|" * (len(SCORES) + 1))
    for (sequence, points, count, descriptor, rank), rows in values.items():
        cells = " | ".join(f"{statistics.mean(column):.3f} ± {spread(column):.3f}" for column in zip(*rows))
        less = [a[0] - b[0] for a, b in zip(rows, values[sequence, points, count, descriptor, first])]
        print(f"| {sequence} | {points} | {count or 'all'} | {descriptor} | {rank} | {cells} | "
              f"{statistics.mean(less):+.3f} |")


def study(arguments):
    classes = classes_of(Path(arguments.models).resolve())
    values = {}
    with tempfile.TemporaryDirectory(prefix="meander-study-", dir=arguments.scratch) as folder:
        scratch = Path(folder)
        files = [turned_inside_out(file, scratch / "turned") if arguments.turned and i % 2 == 1 else file
                 for group in classes.values() for i, file in enumerate(group)]
        listing = scratch / "models.txt"
        listing.write_text("".join(f"{file}\n" for file in files))
        for seed in range(1, arguments.seeds + 1):
            measure_seed(arguments, seed, classes, listing, scratch, values)
            print(f"seed {seed} of {arguments.seeds}", file=sys.stderr, flush=True)
    print_table(arguments, len(files), values)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meander", help="the program")
    parser.add_argument("models", help="models in folders of their classes")
    parser.add_argument("-n", "--samples", type=int, default=1024, help="samples per model (default 1024)")
    parser.add_argument("--seeds", type=int, default=20, help="seeds 1, 2, ... (default 20)")
    parser.add_argument("--sequences", default="shifted", help="as of `run --sequence` (default shifted)")
    parser.add_argument("--descriptors", default="best", help="combinations (default best)")
    parser.add_argument("--ranks", default="scaled,diffusion", help="as of --rank (default scaled,diffusion)")
    parser.add_argument("--local-points", default="320", help="of `retrieve words` (default 320)")
    parser.add_argument("--per-class", default="0", help="models of a class, 0 for all (default 0)")
    parser.add_argument("--turned", action="store_true", help="turn every other model of a class inside out")
    parser.add_argument("--scratch", default=None, help="folder for stores (default: the system's)")
    arguments = parser.parse_args()
    for name in ("sequences", "descriptors", "ranks"):
        setattr(arguments, name, getattr(arguments, name).split(","))
    for name in ("local_points", "per_class"):
        setattr(arguments, name, [int(text) for text in getattr(arguments, name).split(",")])
    arguments.meander = os.path.abspath(shutil.which(arguments.meander) or arguments.meander)
    try:
        study(arguments)
    except Failure as failure:
        print(f"ranking_study: {failure}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
