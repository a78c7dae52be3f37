#!/usr/bin/env python3
"""Power cuts: what a disk may hold when the machine stops.

    power_cuts.py MEANDER SHIM [--states 1000] [--seed 1] [--only JOB,...] [--keep FOLDER]

A job runs once while fault_shim.cpp records every call that changes its folder. From the record states of the disk
are made as a power cut could leave them, at random calls. What was synced is there; of what was not:
  strict   nothing: files as at their last sync, folders with the names of their last sync
  ordered  names as a journalling file system keeps them, in order up to some call; of data not synced none, all, the
           first writes, or any of them, with zeros between
  any      the same, and folders forget names independently of each other
In every state a file under the name of a result must be the old or the whole new one, and the same command must end
with the bytes of an undisturbed one.
"""
import collections
import os
import random
import shutil
import tempfile
from pathlib import Path

import scene
from faults import JOBS, Scene, comparable, next_command, what_is_wrong
from kills import KILLED

MODES = ["strict", "ordered", "any"]
PAGE = 4096


class File:
    def __init__(self, data=b""):
        self.synced, self.changes = data, []  # since the last sync: (offset, data), or (length, None)

    def sync(self):
        self.synced, self.changes = self.content(self.changes), []

    def content(self, changes):
        data = bytearray(self.synced)
        for at, what in changes:
            end = at if what is None else at + len(what)
            if len(data) < end:
                data.extend(bytes(end - len(data)))
            if what is None:
                del data[at:]
            else:
                data[at:end] = what
        return bytes(data)

    def after_cut(self, rng, mode):
        if mode == "strict" or not self.changes:
            return self.synced
        kind = rng.choice(["none", "all", "first", "some"])
        if kind == "none":
            return self.synced
        if kind == "all":
            return self.content(self.changes)
        if kind == "first":
            changes = self.changes[:rng.randint(0, len(self.changes))]
            if changes and changes[-1][1]:  # the last one is torn between two pages
                at, what = changes[-1]
                changes[-1] = (at, what[:max(0, PAGE * rng.randint(0, len(what) // PAGE + 1) - at % PAGE)])
            return self.content(changes)
        return self.content([change for change in self.changes if change[1] is None or rng.random() < 0.5])


class Folder:
    def __init__(self):
        self.synced, self.names, self.changes = {}, {}, []  # since the last sync: (call, names after it)

    def sync(self):
        self.synced, self.changes = dict(self.names), []

    def change(self, call, remove=None, add=None, node=None):
        if remove is not None:
            self.names.pop(remove, None)
        if add is not None:
            self.names[add] = node
        self.changes.append((call, dict(self.names)))

    def after_cut(self, rng, mode, last_call):
        if mode == "strict":
            return self.synced
        if mode == "any":
            return ([self.synced] + [names for _, names in self.changes])[rng.randint(0, len(self.changes))]
        kept = [names for call, names in self.changes if call <= last_call]
        return kept[-1] if kept else self.synced


class Disk:
    """The folder of a job, as the calls of the record change it."""

    def __init__(self, root, on_disk):
        self.root, self.top, self.descriptors, self.call, self.synced_call = str(root), Folder(), {}, 0, 0
        for path in sorted(Path(on_disk).rglob("*")):
            parent, name = self.parent_of(os.path.join(self.root, path.relative_to(on_disk)))
            parent.names[name] = Folder() if path.is_dir() else File(path.read_bytes())
            parent.sync()

    def node(self, path):
        node = self.top
        for name in os.path.relpath(path, self.root).split("/"):
            if name != ".":
                node = node.names[name]
        return node

    def parent_of(self, path):
        return self.node(os.path.dirname(path)), os.path.basename(path)

    def play(self, name, first, second, text, data):
        self.call += 1
        if name == "open":
            if second & 1:
                parent, own = self.parent_of(text)
                parent.change(self.call, add=own, node=File())
            self.descriptors[first] = self.node(text)
            if second & 2:
                self.descriptors[first].changes.append((0, None))
        elif name == "write":
            self.descriptors[first].changes.append((second, data))
        elif name == "truncate":
            (self.descriptors[first] if first >= 0 else self.node(text)).changes.append((second, None))
        elif name == "sync":
            self.descriptors[first].sync()
            self.synced_call = self.call
        elif name == "close":
            self.descriptors.pop(first, None)
        elif name == "mkdir":
            parent, own = self.parent_of(text)
            parent.change(self.call, add=own, node=Folder())
        elif name == "unlink":
            parent, own = self.parent_of(text)
            parent.change(self.call, remove=own)
        elif name == "rename":
            (source, old), (target, new) = self.parent_of(text[:first]), self.parent_of(text[first:])
            node = source.names[old]
            if source is not target:
                target.change(self.call, add=new, node=node)
                source.change(self.call, remove=old)
            else:
                target.change(self.call, remove=old, add=new, node=node)

    def write(self, folder, rng, mode):
        # A journal is written as a whole by every sync, whatever is synced.
        last_call = rng.randint(self.synced_call, self.call)
        shutil.rmtree(folder, ignore_errors=True)
        Path(folder).mkdir(parents=True)
        self._write(self.top, Path(folder), rng, mode, last_call)

    def _write(self, node, folder, rng, mode, last_call):
        for name, child in node.after_cut(rng, mode, last_call).items():
            if isinstance(child, File):
                (folder / name).write_bytes(child.after_cut(rng, mode))
            else:
                (folder / name).mkdir()
                self._write(child, folder / name, rng, mode, last_call)


def records(path):
    data, at, result = Path(path).read_bytes(), 0, []
    while at < len(data):
        end = data.index(b"\n", at)
        name, first, second, of_path, of_data = data[at:end].split()
        begin = end + 1 + int(of_path)
        result.append((name.decode(), int(first), int(second), data[end + 1:begin].decode(),
                       data[begin:begin + int(of_data)]))
        at = begin + int(of_data) + 1
    return result


class CutJob:
    def __init__(self, where, name, findings):
        self.where, self.name, self.findings = where, name, findings
        commands, self.command = JOBS[name]
        self.before = where.prepare(commands)
        record = where.folder.parent / "record"
        record.unlink(missing_ok=True)
        first, _, _ = where.disturbed(self.command, record=record, folder=where.out)
        if first.code != 0:
            raise SystemExit(f"power_cuts: {name} ended with {first.code}: {first.err}")
        self.after, self.records = comparable(scene.content(where.out)), records(record)
        disk = Disk(where.out, where.prepared)
        for entry in self.records:
            disk.play(*entry)
        self.check_model(disk.top, "")

    def check_model(self, node, path):
        """The record must lead to what is on the disk."""
        for name, child in node.names.items():
            if isinstance(child, Folder):
                self.check_model(child, path + name + "/")
            elif child.content(child.changes) != (self.where.out / (path + name)).read_bytes():
                raise SystemExit(f"power_cuts: {self.name}: the record does not lead to {path + name}")

    def cut(self, rng, counts):
        at, mode = rng.randint(1, len(self.records)), rng.choice(MODES)
        disk = Disk(self.where.out, self.where.prepared)
        for entry in self.records[:at]:
            disk.play(*entry)
        disk.write(self.where.out, rng, mode)
        counts[mode] += 1
        last = self.records[at - 1]
        label = f"{self.name}: cut after call {at} ({last[0]} {last[3]}), {mode}"
        cut = self.where.folder.parent / "cut"
        scene.copy_folder(self.where.out, cut)
        for file, data in comparable(scene.content(self.where.out)).items():
            if file in self.after and data not in (self.before.get(file), self.after[file]) \
                    and ".run/" not in file and not file.endswith("remesh.csv"):
                self.findings.add(f"{label}: {file} is neither the old nor the new file", cut)
        command = next_command(self.name, self.command, self.where.out)
        ended = self.where.run(command)
        if wrong := what_is_wrong(ended, comparable(scene.content(self.where.out)), self.after):
            self.findings.add(f"{label}: then {wrong}", cut)


def main():
    parser = scene.arguments(__doc__, states=(1000, "of disks"), only=("", "jobs, separated by commas"))
    parser.add_argument("shim", help="the library made of fault_shim.cpp")
    given = parser.parse_args()
    names = given.only.split(",") if given.only else KILLED
    findings, counts = scene.Findings("power_cuts", given.keep), collections.Counter()
    rng = random.Random(given.seed)
    with tempfile.TemporaryDirectory() as folder:
        where = Scene(Path(folder) / "scene", os.path.abspath(given.meander), os.path.abspath(given.shim))
        for name in names:
            job = CutJob(where, name, findings)
            share = -(-given.states // len(names))
            for _ in range(share):
                job.cut(rng, counts)
            print(f"power_cuts: {name}: {len(job.records)} calls, {share} states", flush=True)
    findings.end(f"seed {given.seed}, {sum(counts.values())} states: " + ", ".join(
        f"{number} {mode}" for mode, number in sorted(counts.items())))


if __name__ == "__main__":
    main()
