#!/usr/bin/env python3
"""Kills at any moment.

    kills.py MEANDER SHIM [--kills 1000] [--seed 1] [--only JOB,...] [--keep FOLDER]

A job is started and ended by SIGKILL, half of the times before a random call on a file (fault_shim.cpp), half of the
times after a random delay, and started again, up to five times; then it is left alone. What it ends with must be the
bytes of an undisturbed one, and nothing may be left over. What was killed is counted by what it was at.
"""
import collections
import os
import random
import re
import tempfile
import time
from pathlib import Path

import scene
from faults import JOBS, LEFTOVERS, Scene, comparable, next_command, what_is_wrong

KILLED = ["run", "run-packed", "run-update", "run-fresh", "run-reuse", "describe", "describe-output", "plan", "shard",
          "shard-scratch", "merge", "merge-stores", "surface", "remesh", "remesh-again", "words", "words-again", "graph"]

# What a call on a file is part of.
PHASES = [("/in", "reading inputs"), ("in.zip", "reading inputs"), ("in.tar.gz", "reading inputs"),
          (".removed-", "removing the run"), ("begun.log", "log of begun items"), ("/journal/", "journal"),
          ("plan.bin", "plan"), ("items.jsonl", "plan"), ("array.json", "plan"), (".part-", "writing a store"),
          ("run.json", "report"), (".failed.txt", "report"), ("/meshes/", "meshes"), ("lock", "lock")]


def phase_of(path):
    return next((phase for part, phase in PHASES if part in path), "other")


class KilledJob:
    def __init__(self, where, name, findings):
        self.where, self.name, self.findings, self.left_over = where, name, findings, 0
        commands, self.command = JOBS[name]
        where.prepare(commands)
        start = time.monotonic()
        first, self.calls, _ = where.disturbed(self.command)
        self.seconds = time.monotonic() - start
        if first.code != 0:
            raise SystemExit(f"kills: {name} ended with {first.code}: {first.err}")
        self.after = comparable(scene.content(where.out))

    def lap(self, rng, phases):
        """From the beginning to the end; how often it was killed."""
        self.where.begin_again()
        kills, command, deaths = 0, self.command, []
        for _ in range(rng.randint(1, 5)):
            log = Path(self.where.log)
            if rng.random() < 0.5:
                at = rng.randint(1, len(self.calls))
                ended, _, call = self.where.disturbed(command, at=at, do="kill")
                where = f"{call[0]} {call[1]}" if call else ""
            else:
                delay = rng.uniform(0, 1.2 * self.seconds)
                log.unlink(missing_ok=True)
                ended = scene.run([self.where.meander] + command, cwd=self.where.folder, kill_after=delay)
                where = f"after {delay * 1000:.0f} ms"
            if ended.code != -9:
                break  # it was done before that moment, or was refused: it is started once more below
            kills += 1
            deaths.append(where)
            phases["random moment" if where.startswith("after") else phase_of(where)] += 1
            command = next_command(self.name, self.command, self.where.out)
        ended = self.where.run(command)
        files = comparable(scene.content(self.where.out))
        if wrong := what_is_wrong(ended, files, self.after):
            self.findings.add(f"{self.name}: killed at {'; '.join(deaths)}: then {wrong}", self.where.out)
        self.left_over += sum(1 for name in files if LEFTOVERS.search(name))
        return kills


def main():
    parser = scene.arguments(__doc__, kills=(1000, "at least so many"), only=("", "jobs, separated by commas"))
    parser.add_argument("shim", help="the library made of fault_shim.cpp")
    given = parser.parse_args()
    names = given.only.split(",") if given.only else KILLED
    findings, phases, of_job = scene.Findings("kills", given.keep), collections.Counter(), collections.Counter()
    rng = random.Random(given.seed)
    kills = laps = left_over = 0
    with tempfile.TemporaryDirectory() as folder:
        where = Scene(Path(folder) / "scene", os.path.abspath(given.meander), os.path.abspath(given.shim))
        for index, name in enumerate(names):
            job = KilledJob(where, name, findings)
            while kills * len(names) < given.kills * (index + 1):
                killed = job.lap(rng, phases)
                kills, laps = kills + killed, laps + 1
                of_job[name] += killed
            left_over += job.left_over
            print(f"kills: {name}: {of_job[name]}", flush=True)
    findings.end(f"seed {given.seed}, {kills} kills in {laps} laps, {left_over} files left over: " + ", ".join(
        f"{number} {phase}" for phase, number in phases.most_common()))


if __name__ == "__main__":
    main()
