#!/usr/bin/env python3
"""Damaged files by the thousand, run as whole collections.

    mutations.py MEANDER [--files 10000] [--seed 1] [--models FOLDER]... [--memory 512M] [--keep FOLDER]

Every file is a mesh with one to three mutations: flipped bits, cut, huge counts, nan and infinity, parts of two files,
lines in another order, other ends of lines, doubled and missing parts. They are run in batches with other options each.
Of every batch is demanded: the program ends by itself with 0 or 3, every file is a row with a status that is neither
crashed nor internal nor timeout, the store verifies, and the process stays within --memory (a program built with
AddressSanitizer instead refuses any single allocation beyond it: its own bookkeeping is in the size of the process).
"""
import json
import os
import random
import shutil
import struct
import subprocess
import tempfile
from pathlib import Path

import scene

SMALLEST, LARGEST = 1, 200 * 1024  # bytes of a file that is mutated

OPTIONS = [[], ["--method", "direct", "--describe", "d2,a3,d1,pairs"], ["--method", "conformal"],
           ["--sequence", "spaced", "--certify"], ["--method", "anisotropic"], ["--density", "mean"],
           ["--curved", "--describe", "basics,harmonics"], ["--method", "conformal", "--locate", "first-hit"],
           ["--density", "attribute:quality"], ["--normalize", "unit-sphere", "--describe", "geodesic"]]

WORDS = [b"nan", b"-inf", b"inf", b"1e999", b"-0", b"1e-320", b"4294967295", b"4294967296", b"-1", b"2147483648",
         b"18446744073709551615", b"99999999999999999999999", b"0", b"1e38", b"0x10", b"1.5", b"", b"#", b"/", b"\xff"]
NUMBERS = [struct.pack("<I", v) for v in (0xFFFFFFFF, 0x7FFFFFFF, 0x80000000, 0x10000000, 0)] + [
    struct.pack("<f", v) for v in (float("nan"), float("inf"), -float("inf"), 3e38, 1e-45)] + [
    struct.pack(">f", float("nan")), struct.pack(">I", 0x7FFFFFFF), struct.pack("<d", float("nan"))]


def flip_bits(rng, data, _):
    data = bytearray(data)
    for _ in range(rng.choice([1, 1, 2, 8, 64])):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def cut(rng, data, _):
    return data[:rng.randrange(len(data))]


def cut_front(rng, data, _):
    return data[rng.randrange(len(data)):]


def replace_word(rng, data, _):
    """A number, or a word, becomes another: in the first 200 bytes often, where counts are."""
    end = min(len(data), 200) if rng.random() < 0.5 else len(data)
    words = data[:end].split(b" ")
    words[rng.randrange(len(words))] = rng.choice(WORDS)
    return b" ".join(words) + data[end:]


def replace_number(rng, data, _):
    number = rng.choice(NUMBERS)
    at = rng.randrange(min(len(data), 120)) if rng.random() < 0.4 else rng.randrange(len(data))
    return data[:at] + number + data[at + len(number):]


def splice(rng, data, other):
    return data[:rng.randrange(len(data))] + other[rng.randrange(len(other)):]


def shuffle_lines(rng, data, _):
    lines = data.split(b"\n")
    first = rng.randrange(len(lines))
    some = lines[first:first + rng.choice([2, 5, 50, len(lines)])]
    rng.shuffle(some)
    return b"\n".join(lines[:first] + some + lines[first + len(some):])


def other_line_ends(rng, data, _):
    return data.replace(b"\n", rng.choice([b"\r\n", b"\r", b"\n\n", b"\\\n", b" \t\n", b"\0\n"]))


def double_part(rng, data, _):
    begin = rng.randrange(len(data))
    end = min(len(data), begin + rng.choice([1, 4, 12, 50, 1000]))
    return data[:end] + data[begin:end] * rng.choice([1, 1, 2, 100]) + data[end:]


def drop_part(rng, data, _):
    begin = rng.randrange(len(data))
    return data[:begin] + data[begin + rng.choice([1, 4, 12, 50, 1000]):]


def insert_noise(rng, data, _):
    at = rng.randrange(len(data))
    return data[:at] + rng.randbytes(rng.choice([1, 4, 16, 256])) + data[at:]


def long_line(rng, data, _):
    at = rng.randrange(len(data))
    return data[:at] + rng.choice([b"9", b" ", b"f 1 ", b"(", b"a", b"0 "]) * rng.choice([300, 70000]) + data[at:]


MUTATIONS = [flip_bits, flip_bits, cut, cut_front, replace_word, replace_word, replace_number, replace_number, splice,
             shuffle_lines, other_line_ends, double_part, drop_part, insert_noise, long_line]


def mutate(rng, data, other):
    names = []
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        if len(data) < SMALLEST:
            break
        mutation = rng.choice(MUTATIONS)
        names.append(mutation.__name__)
        data = mutation(rng, data, other)
    return data, names


def sources(rng, folders):
    """Files to mutate, by format."""
    meshes = [scene.box(), scene.torus(24, 12), scene.torus(6, 4), scene.terrain(12, 9), scene.soup(rng, 60),
              scene.together(scene.box(0.2), scene.torus(9, 7), scene.soup(rng, 5)), scene.terrain(40, 30)]
    by_format = {}
    for mesh in meshes:
        for extension, data in scene.mesh_files(mesh):
            by_format.setdefault(extension, []).append(data)
    for folder in folders:
        for path in sorted(Path(folder).rglob("*")):
            extension = path.suffix.lower()
            if extension in by_format and path.is_file() and SMALLEST <= path.stat().st_size <= LARGEST:
                by_format[extension].append(path.read_bytes())
    return by_format


def size_of(text):
    units = {"K": 10, "M": 20, "G": 30}
    return int(text[:-1]) << units[text[-1]]


class Batch:
    def __init__(self, number, options, names, work):
        self.number, self.options, self.names, self.work = number, options, names, work

    def run(self, given, sanitized, findings, counts):
        """Repeats a command that died: the program then finds out by itself which file it was."""
        store = self.work / "s.h5"
        command = [given.meander, "run", self.work / "in", "-o", store, "-n", "64", "-j", given.threads, "--memory",
                   given.memory, "--timeout", given.timeout, "--progress", "none", "--json"] + self.options
        limit = size_of(given.memory)
        # An allocation beyond the budget ends the process. What it freed is kept apart for long enough to find uses.
        environment = {"ASAN_OPTIONS": f"max_allocation_size_mb={limit >> 20}:quarantine_size_mb=32:detect_leaks=0",
                       "UBSAN_OPTIONS": "print_stacktrace=1"}
        where = f"batch {self.number} {' '.join(self.options)}"
        for _ in range(20):
            ended = scene.run(command, environment=environment, seconds=1800)
            if ended.hung:
                findings.add(f"{where}: not done after 1800 s", self.work / "in")
                return
            if ended.code in (0, 3):
                break
            last = [line for line in ended.err.splitlines() if line.strip()]
            findings.add(f"{where}: ended with {scene.signal_name(ended.code)}: " + " | ".join(last[:12]))
        else:
            findings.add(f"{where}: died 20 times", self.work / "in")
            return
        summary = json.loads(ended.out)
        if summary["items"] != len(self.names):
            findings.add(f"{where}: {len(self.names)} files, {summary['items']} rows", self.work / "in")
        for status, number in summary["status"].items():
            counts[status] = counts.get(status, 0) + number
        if (ended.code == 3) != (summary["status"].get("ok", 0) < summary["items"]):
            findings.add(f"{where}: exit code {ended.code} for {summary['status']}")
        for failed in summary["failed"]:
            if failed["status"] in ("crashed", "internal", "timeout", "out_of_memory"):
                findings.add(f"{where}: {failed['id']} ({'+'.join(self.names[failed['id']])}): {failed['status']}: "
                             f"{failed['reason']}", self.work / "in" / failed["id"])
        if not sanitized and ended.peak_bytes > limit:
            findings.add(f"{where}: {ended.peak_bytes >> 20} MiB of --memory {given.memory}", self.work / "in")
        counts["peak MiB"] = max(counts.get("peak MiB", 0), ended.peak_bytes >> 20)
        verified = scene.run([given.meander, "verify", store], environment=environment, seconds=300)
        if verified.code != 0:
            findings.add(f"{where}: verify ended with {verified.code}: {verified.out} {verified.err}", store)


def main():
    parser = scene.arguments(__doc__, files=(10000, "mutated files"), batch=(250, "files of a batch"),
                             memory=("512M", "of the program"), timeout=("300s", "of a model"), threads=(2, "-j"))
    parser.add_argument("--models", action="append", default=[], help="a folder with more meshes to mutate")
    given = parser.parse_args()
    sanitized = b"__asan_init" in Path(given.meander).read_bytes()
    # Certificates are of the laboratory, which a build of the product is without: there its commands are refused.
    has_laboratory = subprocess.run([given.meander, "measure", "--help"], capture_output=True).returncode == 0
    options = [[o for o in chosen if has_laboratory or o != "--certify"] for chosen in OPTIONS]
    findings, counts = scene.Findings("mutations", given.keep), {}
    rng = random.Random(given.seed)
    by_format = sources(rng, given.models)
    formats = sorted(by_format)
    print(f"mutations: seed {given.seed}, sources " + ", ".join(f"{len(by_format[f])} {f}" for f in formats))
    with tempfile.TemporaryDirectory() as folder:
        done = number = 0
        while done < given.files:
            work = Path(folder) / "batch"
            shutil.rmtree(work, ignore_errors=True)
            (work / "in").mkdir(parents=True)
            names = {}
            for i in range(min(given.batch, given.files - done)):
                extension = formats[(done + i) % len(formats)]
                data, other = rng.choice(by_format[extension]), rng.choice(by_format[extension])
                mutated, mutations = mutate(rng, data, other)
                name = f"{done + i:06d}{extension}"
                names[name] = mutations
                (work / "in" / name).write_bytes(mutated)
            Batch(number, options[number % len(options)], names, work).run(given, sanitized, findings, counts)
            done += len(names)
            number += 1
            if number % 10 == 0 or done == given.files:
                print(f"mutations: {done} files, {counts}", flush=True)
    findings.end(f"{done} files in {number} batches, {counts}")


if __name__ == "__main__":
    main()
