#!/usr/bin/env python3
"""Large runs within their memory.

    load.py MEANDER [--models 100000] [--charted 4000] [--rows 2000000] [--faces 10000000] [--memory 1G]
            [--only PART,...]

Parts: `direct`, `auto`: generated models, 64 points on each, -j 2; `conformal`: fewer, as charts take longer;
`rows`: a store of so many rows of 16 points from one archive of tiny models, verified and read; `faces`: one model
of so many faces beside 2,000 small ones, where --memory is what such a model needs. The size of the process must
stay within --memory.
"""
import io
import json
import math
import os
import random
import struct
import tarfile
import tempfile
import time
from pathlib import Path

import scene


def size_of(text):
    return int(text[:-1]) << {"M": 20, "G": 30}[text[-1]]


def model(rng):
    """A small box, torus or terrain of some size, as OFF."""
    kind = rng.random()
    if kind < 0.5:
        return scene.off_bytes(scene.box(rng.random() + 0.1, rng.random() + 0.1, rng.random() + 0.1))
    if kind < 0.9:
        return scene.off_bytes(scene.torus(rng.randint(4, 12), rng.randint(3, 8), 0.1 + 0.5 * rng.random()))
    return scene.off_bytes(scene.terrain(rng.randint(2, 30), rng.randint(2, 30)))


def write_collection(path, count, seed, small=False):
    """A tar archive of so many models: of the same bytes as a folder, and quicker to write and to remove."""
    rng = random.Random(seed)
    with tarfile.open(path, "w") as archive:
        for i in range(count):
            data = scene.off_bytes(scene.box(1 + i % 97, 1 + i % 89, 1 + i % 83)) if small else model(rng)
            member = tarfile.TarInfo(f"{i // 1000:04d}/{i % 1000:03d}.off")
            member.size = len(data)
            archive.addfile(member, io.BytesIO(data))


def write_large(path, faces):
    """A sphere of about so many triangles as binary PLY."""
    rows = max(3, int((faces / 2) ** 0.5))
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {rows * rows}\nproperty float x\nproperty float y\n"
    head += f"property float z\nelement face {2 * rows * (rows - 1)}\n"
    head += "property list uchar int vertex_indices\nend_header\n"
    with open(path, "wb") as file:
        file.write(head.encode())
        circle = [(math.cos(2 * math.pi * j / rows), math.sin(2 * math.pi * j / rows)) for j in range(rows)]
        for i in range(rows):
            z = 0.99 * (2 * i / (rows - 1) - 1)
            r = math.sqrt(1 - z * z)
            file.write(b"".join(struct.pack("<3f", r * x, r * y, z) for x, y in circle))
        for i in range(rows - 1):
            low = i * rows
            file.write(b"".join(struct.pack("<B3iB3i", 3, low + j, low + (j + 1) % rows, low + rows + j, 3,
                                            low + (j + 1) % rows, low + rows + (j + 1) % rows, low + rows + j)
                                for j in range(rows)))
    return 2 * rows * (rows - 1)


class Load:
    def __init__(self, given, findings, folder):
        self.given, self.findings, self.folder = given, findings, Path(folder)

    def run(self, name, inputs, memory, expected, options):
        store = self.folder / f"{name}.h5"
        start = time.monotonic()
        ended = scene.run([self.given.meander, "run", *inputs, "-o", store, "-j", "2", "--memory", memory, "--progress",
                           "none", "--json"] + options, seconds=3600)
        seconds = time.monotonic() - start
        if ended.code not in (0, 3):
            self.findings.add(f"{name}: {scene.signal_name(ended.code)}: {ended.err[-500:]}")
            return
        summary = json.loads(ended.out)
        if summary["items"] != expected or summary["status"].get("ok", 0) != expected:
            self.findings.add(f"{name}: {expected} models, {summary['items']} rows, {summary['status']}")
        self.check_memory(name, ended, memory)
        print(f"load: {name}: {expected} models, {seconds:.0f} s, peak {ended.peak_bytes >> 20} MiB of {memory}, store "
              f"{store.stat().st_size >> 20} MiB", flush=True)
        start = time.monotonic()
        verified = scene.run([self.given.meander, "verify", store], seconds=3600)
        if verified.code != 0:
            self.findings.add(f"{name}: verify: {verified.code}: {verified.out} {verified.err}")
        print(f"load: {name}: verified in {time.monotonic() - start:.0f} s", flush=True)
        again = scene.run([self.given.meander, "run", *inputs, "-o", store, "-j", "2", "--memory", memory, "--progress",
                           "none", "--json"] + options, seconds=3600)
        if again.code != ended.code or json.loads(again.out)["done_now"] != 0:
            self.findings.add(f"{name}: the same command again: {again.code}: {again.out[-300:]} {again.err[-300:]}")
        self.check_memory(name + ", the same command again", again, memory)
        store.unlink()

    def check_memory(self, name, ended, memory):
        if ended.peak_bytes > size_of(memory):
            self.findings.add(f"{name}: {ended.peak_bytes >> 20} MiB of --memory {memory}")


def main():
    parser = scene.arguments(__doc__, models=(100000, "of the collection"), charted=(4000, "of it, for conformal"),
                             rows=(2000000, "of 16 points"), faces=(10000000, "of the large model"), memory=("1G", ""),
                             large_memory=("8G", "for the large model"), rows_memory=("2G", "for the many rows"),
                             only=("", "parts, separated by commas"))
    given = parser.parse_args()
    parts = given.only.split(",") if given.only else ["direct", "auto", "conformal", "rows", "faces"]
    findings = scene.Findings("load", given.keep)
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as folder:
        load, folder = Load(given, findings, folder), Path(folder)
        if {"direct", "auto"} & set(parts):
            write_collection(folder / "models.tar", given.models, given.seed)
        for method in ("direct", "auto"):
            if method in parts:
                load.run(method, [folder / "models.tar"], given.memory, given.models, ["-n", "64", "--method", method])
        (folder / "models.tar").unlink(missing_ok=True)
        if "conformal" in parts:
            write_collection(folder / "charted.tar", given.charted, given.seed)
            load.run("conformal", [folder / "charted.tar"], given.memory, given.charted,
                     ["-n", "64", "--method", "conformal"])
        if "rows" in parts:
            write_collection(folder / "rows.tar", given.rows, given.seed, small=True)
            load.run("rows", [folder / "rows.tar"], given.rows_memory, given.rows, ["-n", "16"])
            (folder / "rows.tar").unlink()
        if "faces" in parts:
            (folder / "in").mkdir()
            faces = write_large(folder / "in" / "large.ply", given.faces)
            write_collection(folder / "in" / "small.tar", 2000, given.seed)
            print(f"load: faces: {faces} faces", flush=True)
            load.run("faces", [folder / "in"], given.large_memory, 2001, ["-n", "2048"])
    findings.end(", ".join(parts))


if __name__ == "__main__":
    main()
