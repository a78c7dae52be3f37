#!/usr/bin/env python3
"""Training sets of Hunyuan3D-2.1's size, model by model: processor seconds, and shares by stage.

    training_sets.py MEANDER FOLDER... [--every 1] [--further 0] [--repeats 1] [--json FILE]

Every --every-th model below each FOLDER, in order of the names, is made into a store of its own by one process with
`-j 1`: 124,928 samples, as many points on sharp edges, and 624,640 signed distances as float16. The seconds are those
of user and system of the whole process, the store included. The table has median, ninth decile and largest, the share
of each stage of the busy seconds of all, and the same of runs with `--sign none`, whose difference is what sides cost.
With --further the seconds are those of one more model in a run, whose process has started and whose memory has been
used: the difference between a run of the model with that many copies, without the files beside it, and a run of the
model alone, for each copy.
With --repeats every set is made so many times, and the seconds are the least: what else the machine does only adds to
them.
Models that have no row are counted. Python's standard library only. Exit status 1 when none has a row.
"""
import argparse
import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

QUERIES = "near=249856@.0025,.025 near-sharp=124928@.0005,.0015,.03,.005,.01,.02 volume=249856@.525"  # in the unit box
SETS = ["-n", "124928", "--sharp", "124928", "--sharp-angle", "20", "--normalize", "unit-box",
        "--queries-type", "float16", "--queries", QUERIES]
FORMATS = {".off", ".obj", ".ply", ".stl", ".glb", ".gltf"}


def models_below(folder, every):
    return sorted(path for path in folder.rglob("*") if path.suffix.lower() in FORMATS)[::every]


def run_copies(meander, model, copies, scratch, options):
    """Processor seconds of the process and busy seconds by stage, or None where the model has no row."""
    store = Path(scratch) / "store.h5"
    files = [str(model)]
    for copy in range(1, copies):
        files.append(str(Path(scratch) / ("copy%d%s" % (copy, model.suffix))))
        shutil.copyfile(model, files[-1])
    command = [meander, "run", *files, "-o", str(store), "--fresh", "-j", "1", "--progress", "none", *SETS, *options]
    child = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    error = child.stderr.read()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode == 3:
        return None
    if child.returncode != 0:
        sys.exit("%s: exit %d\n%s" % (" ".join(command), child.returncode, error.decode(errors="replace")))
    nodes = json.loads(Path("%s.run.json" % store).read_text(encoding="utf-8"))["nodes"]
    return usage.ru_utime + usage.ru_stime, {node["name"]: node["busy_seconds"] for node in nodes}


def least_of(repeats, *run):
    """The run that took the least seconds of so many."""
    runs = [run_copies(*run) for _ in range(repeats)]
    return None if None in runs else min(runs, key=lambda made: made[0])


def run_one(meander, model, further, repeats, scratch, options):
    """The same of a process for the model alone, or, if `further` is not 0, of each of so many further copies."""
    alone = least_of(repeats, meander, model, 1, scratch, options)
    if alone is None or further == 0:
        return alone
    seconds, stages = least_of(repeats, meander, model, 1 + further, scratch, options)
    return (seconds - alone[0]) / further, {
        name: (busy - alone[1].get(name, 0)) / further for name, busy in stages.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("meander")
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--further", type=int, default=0)
    parser.add_argument("--repeats", type=int, default=1)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    results = []
    with tempfile.TemporaryDirectory() as scratch:
        for sign in ("auto", "none"):
            seconds, stages, without = {}, Counter(), 0
            for folder in given.folders:
                for model in models_below(folder, given.every):
                    made = run_one(given.meander, model, given.further, given.repeats, scratch, ["--sign", sign])
                    if made is None:
                        without += 1
                        continue
                    seconds[str(model)], of_stages = made
                    stages.update(of_stages)
            if not seconds:
                return 1
            ordered = sorted(seconds.values())
            print("--sign %s: %d models, %d without a row: median %.2f s, ninth decile %.2f, largest %.2f (%s)" % (
                sign, len(ordered), without, statistics.median(ordered), ordered[9 * len(ordered) // 10], ordered[-1],
                max(seconds, key=seconds.get)))
            total = sum(stages.values())
            for name, busy in stages.most_common():
                if busy >= 0.005 * total:
                    print("  %-18s %5.1f %%" % (name, 100 * busy / total))
            results.append({"sign": sign, "seconds": seconds, "stages": stages, "without_row": without})
    if given.json:
        given.json.write_text(json.dumps(results, indent=1), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
