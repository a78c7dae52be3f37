#!/usr/bin/env python3
"""The first samples of a row, read with h5py, from chunks of whole rows and from rows that are cut: microseconds a row.

    prefix_reads.py STORE [--samples 64] [--rounds 5] [--json FILE]

Every prefix of a row is a good sample of its own, but a reader has to decompress the chunks that it touches. The points
of STORE are written again with chunks of a whole row, a quarter, an eighth and a thirty-second of one; rows are read in
random order without a cache of chunks.
"""
import argparse
import json
import os
import random
import statistics
import tempfile
import time
import zlib

import h5py


def write_cut(folder, points, parts):
    """The points with `parts` chunks a row, filtered as a store is; the name of the file."""
    name = os.path.join(folder, f"{parts}.h5")
    with h5py.File(name, "w") as file:
        rows = points.chunks[0] if parts == 1 else 1
        cut = file.create_dataset("points", points.shape, "f4", chunks=(rows, -(-points.shape[1] // parts), 3),
                                  shuffle=True, compression="gzip", compression_opts=1, fletcher32=True)
        for row in range(0, len(points), 256):
            cut[row:row + 256] = points[row:row + 256]
    return name


def microseconds_a_row(points, rows, samples):
    start = time.process_time()
    for row in rows:
        points[row, :samples]
    return (time.process_time() - start) / len(rows) * 1e6


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("store")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--json")
    given = parser.parse_args()
    results = []
    with h5py.File(given.store) as store, tempfile.TemporaryDirectory() as folder:
        points = store["points"]
        rows = [row for row, status in enumerate(store["items/status"][:]) if status == 0]
        random.Random(1).shuffle(rows)
        names = {parts: write_cut(folder, points, parts) for parts in (1, 4, 8, 32)}
        times = {parts: ([], []) for parts in names}
        for _ in range(given.rounds):
            for parts, name in names.items():
                with h5py.File(name, rdcc_nbytes=0) as file:
                    times[parts][0].append(microseconds_a_row(file["points"], rows, given.samples))
                    times[parts][1].append(microseconds_a_row(file["points"], rows, None))
        print(f"{len(rows)} rows of {points.shape[1]} samples, one thread")
        print(f"chunks a row  bytes a row  first {given.samples}: min, median us  all: min, median us")
        for parts, (first, whole) in times.items():
            with h5py.File(names[parts]) as file:
                size = file["points"].id.get_storage_size() / len(rows)
                check = zlib.crc32(file["points"][rows[0]].tobytes())
            results.append({"chunks_a_row": parts, "bytes_a_row": size, "first_min": min(first),
                            "first_median": statistics.median(first), "all_min": min(whole),
                            "all_median": statistics.median(whole), "crc32_of_a_row": check})
            print(f"{parts:12} {size:12.0f} {min(first):12.0f} {statistics.median(first):8.0f} "
                  f"{min(whole):16.0f} {statistics.median(whole):8.0f}")
    if given.json:
        with open(given.json, "w") as file:
            json.dump({"store": given.store, "samples": given.samples, "rounds": given.rounds, "results": results},
                      file, indent=1)


if __name__ == "__main__":
    main()
