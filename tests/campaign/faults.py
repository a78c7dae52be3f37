#!/usr/bin/env python3
"""Faults of the system, one at every call in turn, in every job that writes.

    faults.py MEANDER SHIM [--only JOB,...] [--every 1] [--every-read 10] [--part 0/1] [--keep FOLDER]

Each job runs on a tiny input, first undisturbed, then again and again with one call failing (fault_shim.cpp): every
open, read of an input, write, sync, truncation, reservation, mapping, lock, change of a name and close of a file of
its folder, and every tenth read of its own files, with ENOSPC, EIO, EINTR, EMFILE, ENOMEM, and with half of the
bytes; and with a disk that stays full or broken from that call on. Of every run is demanded:
  * it ends by itself: with the exit code of the undisturbed run and the same bytes, or with 2 or 75 and a message,
    or
    with 3 where an input could not be read;
  * a file under the name of a result is the old one or the whole new one;
  * the same command, undisturbed, then ends as the undisturbed run, with the same bytes, and nothing is left over.
"""
import collections
import json
import os
import re
import shutil
import tempfile
from pathlib import Path

import scene

# What fails how. A call that is interrupted or transfers a part of its bytes must be continued.
FAULTS = {
    "ENOSPC": {"create", "write", "truncate", "reserve", "rename", "mkdir", "sync", "close"},
    "EIO": {"open", "read", "write", "sync", "truncate", "close", "rename", "unlink", "map", "lock", "reserve"},
    "EINTR": {"open", "create", "read", "write", "sync", "truncate", "reserve", "close", "lock"},
    "EMFILE": {"open", "create"},
    "ENOMEM": {"map"},
    "short": {"read", "write"},
}
STAYING = {"ENOSPC": FAULTS["ENOSPC"], "EIO": {"write", "sync", "truncate", "close", "rename", "create"}}
TEMPORARY = re.compile(r"\.tmp\d+$")
# Of processes that died or could not remove them; a lock that nobody holds hinders nobody.
LEFTOVERS = re.compile(r"\.(tmp|part-|run\.removed-)\d+(/|$)|(^|/)remesh\.json\.lock$")

# name: (commands that prepare, the command, exit code). All run in the folder of the scene and write to out/.
RUN = ["run", "in", "-o", "out/s.h5", "-n", "16", "-j", "1", "--progress", "none"]
STORE = [RUN + ["--describe", "d2", "--label-from-folder"]]
PLAN = ["plan", "in", "-o", "out/s.h5", "-n", "16", "--shards", "2"]
SHARDS = [["run", "out/s.h5.run", "--shard", f"{i}/2", "-j", "1", "--progress", "none"] for i in range(2)]
VECTORS = ["export", "out/s.h5", "--descriptors", "d2", "--fresh"]
QUIET = ["-j", "1", "--progress", "none"]
JOBS = {
    "run": ([], RUN),
    "run-packed": ([], RUN[:1] + ["in.tar.gz", "in.zip"] + RUN[2:]),
    "run-anisotropic": ([], RUN + ["--method", "anisotropic"]),
    "run-update": ([RUN[:1] + ["@first.txt", "--root", "in"] + RUN[2:]], 
                   RUN[:1] + ["@all.txt", "--root", "in"] + RUN[2:]),
    "run-fresh": ([RUN], RUN + ["--fresh", "--seed", "2"]),
    "run-reuse": ([RUN], RUN[:1] + ["in", "-o", "out/t.h5", "--reuse", "out/s.h5"] + RUN[4:]),
    "describe": (STORE, ["describe", "out/s.h5", "in", "--descriptors", "a3,basics"] + QUIET),
    "describe-output": (STORE, ["describe", "out/s.h5", "--descriptors", "a3", "-o", "out/t.h5"] + QUIET),
    "plan": ([], PLAN),
    "shard": ([PLAN], SHARDS[0]),
    "shard-scratch": ([PLAN], SHARDS[0] + ["--scratch", "out"]),
    "merge": ([PLAN] + SHARDS, ["merge", "out/s.h5.run"]),
    "merge-stores": ([["run", f"in/{part}", "-o", f"out/{part}.h5"] + RUN[4:] for part in ("round", "square")],
                     ["merge", "out/round.h5", "out/square.h5", "-o", "out/t.h5"]),
    "surface": ([], ["surface", "torus", "sphere", "-n", "16", "-o", "out/s.h5"]),
    "remesh": ([], ["remesh", "in", "-o", "out/meshes", "-n", "40"] + QUIET),
    "remesh-again": ([["remesh", "@first.txt", "-o", "out/meshes", "--root", "in", "-n", "40"] + QUIET],
                     ["remesh", "@all.txt", "-o", "out/meshes", "--root", "in", "-n", "40"] + QUIET),
    "export-ply": (STORE, ["export", "out/s.h5", "-o", "out/points", "--fresh"]),
    "export-pointnet": (STORE, ["export", "out/s.h5", "--pointnet", "-o", "out/points", "--fresh"]),
    "export-html": (STORE, ["export", "out/s.h5", "--html", "out/page.html", "--fresh"]),
    "export-csv": (STORE, VECTORS + ["--format", "csv", "-o", "out/d.csv"]),
    "export-npy": (STORE, VECTORS + ["--format", "npy", "-o", "out/d.npy"]),
    "export-ann": (STORE, ["export", "out/s.h5", "--descriptors", "d2", "--format", "ann-hdf5", "-o", "out/d.h5",
                           "--queries", "1", "--neighbours", "1", "--fresh"]),
    "evaluate": (STORE, ["retrieve", "evaluate", "out/s.h5", "--csv", "out/e.csv", "--matrix", "out/e.bin",
                         "--picture", "out/e.svg", "--confusion", "out/c.png", "--html", "out/e.html"]),
    "query": (STORE, ["retrieve", "query", "out/s.h5", "0", "-k", "2", "--csv", "out/q.csv", "--picture", "out/q.png",
                      "--size", "64"]),
    "words": (STORE, ["retrieve", "words", "out/s.h5"]),
    "words-again": (STORE + [["retrieve", "words", "out/s.h5"]], ["retrieve", "words", "out/s.h5", "--replace"]),
    "graph": (STORE, ["retrieve", "graph", "out/s.h5", "--descriptor", "d2"]),
    "measure": (STORE, ["measure", "spacing", "out/s.h5", "--surface", "in", "--csv", "out/m.csv"]),
    "sheet": (STORE, ["render", "sheet", "out/s.h5", "-o", "out/p.png", "--size", "64"]),
    "splats": (STORE, ["render", "splats", "out/s.h5", "-o", "out/p.png", "--size", "64"]),
    "turntable": (STORE, ["render", "turntable", "out/s.h5", "--item", "0", "-o", "out/frames", "--frames", "2"]),
    "strokes": ([], ["render", "strokes", "in/square/000.off", "-o", "out/p.png", "--strokes", "40", "--size", "64"]),
    "section": ([], ["render", "section", "in/square/000.off", "-o", "out/p.png", "--size", "64"]),
}


def comparable(files):
    """Reports hold times, hosts and process numbers: of them it counts that they are whole."""
    result = {}
    for name, data in files.items():
        if name.endswith(".json"):
            data = b"whole JSON" if is_json(data) else b"damaged"
        elif name.endswith("remesh.csv"):  # `seconds` is the last column
            data = b"\n".join(line[:line.rfind(b",")] for line in data.split(b"\n"))
        elif name.endswith("/lock"):
            data = b"a lock"
        result[name] = data
    return result


def is_json(data):
    try:
        json.loads(data)
    except ValueError:
        return False
    return True


def next_command(name, command, out):
    """What continues a job that was stopped."""
    if name == "run-fresh" and (out / "s.h5.run" / "run.json").exists():
        return [word for word in command if word != "--fresh"]
    return command


REFUSALS = ("planned already", "exists (--fresh", "(--replace computes")  # of jobs that are done once


def what_is_wrong(ended, files, after):
    """With a job that was started again: empty when it is done, and its files are those of an undisturbed one."""
    refused = ended.code == 2 and any(text in ended.err for text in REFUSALS)
    if ended.code != 0 and not refused:
        return f"ended with {scene.signal_name(ended.code)}: " + " ".join((ended.err + ended.out).split())[:400]
    # A file NAME.tmp and a process number, which nothing reads, may stay; what a refused job left, too.
    expected = {name: data for name, data in files.items()
                if name in after or not (LEFTOVERS.search(name) if refused else TEMPORARY.search(name))}
    names = [f"{n} ({'missing' if n not in expected else 'extra' if n not in after else 'differs'})"
             for n in sorted(set(expected) | set(after)) if expected.get(n) != after.get(n)]
    return "other files at the end: " + ", ".join(names[:8]) if names else ""


class Scene:
    def __init__(self, folder, meander, shim):
        self.folder, self.meander, self.shim = folder, meander, shim
        self.out, self.prepared, self.log = folder / "out", folder.parent / "prepared", folder.parent / "calls"
        scene.write_models(folder / "in", 3)
        paths = sorted(str(path.relative_to(folder)) for path in (folder / "in").rglob("*.*"))
        (folder / "all.txt").write_text("\n".join(paths) + "\n")
        (folder / "first.txt").write_text("\n".join(paths[1:]) + "\n")
        shutil.make_archive(str(folder / "in"), "zip", folder / "in", "round")
        shutil.make_archive(str(folder / "in"), "gztar", folder / "in", "square")

    def run(self, command, environment=None):
        return scene.run([self.meander] + command, cwd=self.folder, environment=environment, seconds=60)

    def prepare(self, commands):
        shutil.rmtree(self.out, ignore_errors=True)
        self.out.mkdir()
        for command in commands:
            ended = self.run(command)
            if ended.code != 0:
                raise SystemExit(f"faults: {' '.join(command)} ended with {ended.code}: {ended.err}")
        scene.copy_folder(self.out, self.prepared)
        return comparable(scene.content(self.out))

    def begin_again(self):
        scene.copy_folder(self.prepared, self.out)

    def disturbed(self, command, **fault):
        """Runs the command with a fault; also the call that was changed, None where it was not made."""
        self.log.unlink(missing_ok=True)
        environment = {"LD_PRELOAD": str(self.shim), "MEANDER_FAULT_FOLDER": str(self.folder),
                       "MEANDER_FAULT_LOG": str(self.log)}
        environment.update({f"MEANDER_FAULT_{name.upper()}": str(value) for name, value in fault.items()})
        ended = self.run(command, environment)
        calls = self.log.read_text(errors="replace").splitlines() if self.log.exists() else []
        changed = [line[:-2] for line in calls if line.endswith(" *")]
        return ended, calls, changed[0].split(" ", 2)[1:] if changed else None


class JobFaults:
    def __init__(self, where, name, findings, counts):
        self.where, self.name, self.findings, self.counts = where, name, findings, counts
        commands, self.command = JOBS[name]
        self.before = where.prepare(commands)
        first, self.calls, _ = where.disturbed(self.command)
        if first.code != 0:
            raise SystemExit(f"faults: {name} ended with {first.code}: {first.err}")
        self.after = comparable(scene.content(where.out))

    def found(self, fault, call, what):
        self.findings.add(f"{self.name}: {fault} at {' '.join(call)}: {what}")

    def try_fault(self, number, deed, calls, stays):
        self.where.begin_again()
        fault = {"at": number, "do": deed, "calls": ",".join(sorted(calls))}
        if stays:
            fault["stay"] = 1
        ended, _, call = self.where.disturbed(self.command, **fault)
        if call is None:
            return  # a later run makes fewer calls
        label = f"{deed}{' from then on' if stays else ''} ({number})"
        self.counts["faults"] += 1
        message = " ".join(ended.err.split())
        if ended.hung or ended.code < 0 or ended.code not in (0, 2, 3, 75):
            self.found(label, call, f"{'hung' if ended.hung else scene.signal_name(ended.code)}: {message[:400]}")
            return
        self.counts[f"exit {ended.code}"] += 1
        files = comparable(scene.content(self.where.out))
        # A task of an array ends with 0 when its rows are recorded, failed ones included.
        input_failed = call[0] in ("open", "read", "map", "close") and "/in" in call[1]
        if input_failed and "--shard" in self.command and " 0 failed" not in ended.out:
            self.counts["inputs recorded as unreadable by a task"] += 1
            return
        if call[1].endswith(".run.json") and call[0] in ("open", "read") and self.name == "evaluate":
            return  # the time that descriptors took is left out of its page
        if ended.code == 0 and not self.same(files):
            self.found(label, call, "exit code 0, other files: " + self.difference(files))
        if ended.code in (2, 75) and "meander: " not in ended.err:
            self.found(label, call, f"exit code {ended.code} without a message: {message[:200]}")
        if ended.code == 3 and not input_failed:
            self.found(label, call, f"an item failed: {message[:300]} {ended.out[:300]}")
        if deed in ("EINTR", "short") and not stays and ended.code != 0:
            self.counts[f"{deed} not continued"] += 1
            # HDF5 does not open or close its files again, nor does the standard library open folders again.
            by_others = call[0] in ("open", "create", "close") and (".h5" in call[1] or Path(call[1]).suffix == "")
            if not by_others:
                self.found(label, call, f"not continued: {message[:300]}")
        for file, data in files.items():
            # The table of remesh tells how far it came.
            if file in self.after and data not in (self.before.get(file), self.after[file]) and ".run/" not in file:
                if ended.code != 3 and not file.endswith("remesh.csv"):
                    self.found(label, call, f"exit code {ended.code}, and {file} is neither the old nor the new file")
        self.again(label, call, ended)

    def same(self, files):
        return {n: d for n, d in files.items() if not LEFTOVERS.search(n)} == self.after

    def difference(self, files):
        names = [f"{n} ({'missing' if n not in files else 'extra' if n not in self.after else 'differs'})"
                 for n in sorted(set(files) | set(self.after)) if files.get(n) != self.after.get(n)]
        return ", ".join(names[:8])

    def again(self, label, call, ended):
        """The same command, undisturbed."""
        command = self.command
        if ended.code == 3 and command[0] == "run":
            command = command + ["--retry", "unreadable,changed"] if "--fresh" not in command else command
        if ended.code == 3 and command[0] in ("describe", "plan"):
            # Rows whose meshes could not be read; a list of inputs without a folder that could not be searched.
            command = command + ["--replace" if command[0] == "describe" else "--fresh"]
        command = next_command(self.name, command, self.where.out)
        result = self.where.run(command)
        files = comparable(scene.content(self.where.out))
        if wrong := what_is_wrong(result, files, self.after):
            self.found(label, call, f"exit code {ended.code}, then, undisturbed: {wrong}")
        self.counts["files left over"] += sum(1 for name in files if LEFTOVERS.search(name))

    def all(self, every, every_read, part, parts):
        tasks = []
        for stays, faults in ((False, FAULTS), (True, STAYING)):
            for deed, calls in faults.items():
                reads = 0
                for k, line in enumerate([line for line in self.calls if line.split(" ", 2)[1] in calls], 1):
                    reads += " read " + str(self.where.out) in line
                    if " read " + str(self.where.out) not in line or reads % every_read == 0:
                        tasks.append((k, deed, calls, stays))
        for index, task in enumerate(tasks):
            if index % every == 0 and index // every % parts == part:
                self.try_fault(*task)


def main():
    parser = scene.arguments(__doc__, only=("", "jobs, separated by commas"), every=(1, "only every so many faults"),
                             every_read=(10, "only every so many reads of its own files"),
                             part=("0/1", "of several processes that share the faults"))
    parser.add_argument("shim", help="the library made of fault_shim.cpp")
    given = parser.parse_args()
    part, parts = (int(word) for word in given.part.split("/"))
    given.meander, given.shim = os.path.abspath(given.meander), os.path.abspath(given.shim)
    findings, counts = scene.Findings("faults", given.keep), collections.Counter()
    with tempfile.TemporaryDirectory() as folder:
        where = Scene(Path(folder) / "scene", given.meander, given.shim)
        inputs = scene.content(where.folder / "in")
        for name in given.only.split(",") if given.only else JOBS:
            before = counts["faults"]
            job = JobFaults(where, name, findings, counts)
            job.all(given.every, given.every_read, part, parts)
            print(f"faults: {name}: {len(job.calls)} calls, {counts['faults'] - before} faults", flush=True)
            if scene.content(where.folder / "in") != inputs:
                findings.add(f"{name}: the inputs were changed")
    findings.end(", ".join(f"{number} {what}" for what, number in sorted(counts.items())))


if __name__ == "__main__":
    main()
