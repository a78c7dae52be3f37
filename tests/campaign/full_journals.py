#!/usr/bin/env python3
"""Journals that are full are on the disk while the run goes on.

    full_journals.py MEANDER SHIM

A run of more rows than a journal has, whose calls fault_shim.cpp records: the first journal must be synced, with its
name, after the last row was written to it and before the store is begun.
"""
import os
import tempfile
from pathlib import Path

import scene

ROWS = 4096  # of a journal


def main():
    parser = scene.arguments(__doc__)
    parser.add_argument("shim", help="the library made of fault_shim.cpp")
    given = parser.parse_args()
    findings = scene.Findings("full_journals", given.keep)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "in").mkdir()
        for i in range(ROWS + 4):
            (folder / "in" / f"{i:04d}.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        log = folder / "calls"
        ended = scene.run([os.path.abspath(given.meander), "run", "in", "-o", "s.h5", "-n", "1", "--method", "direct",
                           "-j", "1", "--progress", "none"], cwd=folder, seconds=120,
                          environment={"LD_PRELOAD": os.path.abspath(given.shim), "MEANDER_FAULT_FOLDER": name,
                                       "MEANDER_FAULT_LOG": str(log)})
        if ended.code != 0:
            findings.add(f"ended with {ended.code}: {ended.err}")
        calls = log.read_text(errors="replace").splitlines()
        journal = [(i, line.split()[1]) for i, line in enumerate(calls) if "rows-000000.wal" in line]
        written = max((i for i, call in journal if call == "write"), default=None)
        synced = [i for i, call in journal if call == "sync"]
        named = [i for i, line in enumerate(calls) if line.split()[1] == "sync" and line.endswith("/journal")]
        store = next((i for i, line in enumerate(calls) if ".part-" in line), None)
        if written is None or store is None:
            findings.add("the record of calls has no journal or no store")
        elif not any(written < i < store for i in synced):
            findings.add(f"call {written} wrote the last row, {store} began the store, and no sync stands between")
        elif not any(synced[0] < i < store for i in named):
            findings.add("the folder of the journals was not synced")
    findings.end(f"{ROWS + 4} rows, {len(calls)} calls")


if __name__ == "__main__":
    main()
