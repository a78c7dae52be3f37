#!/usr/bin/env python3
"""Nearest vectors of a file that `meander export --descriptors` wrote, exactly, with numpy alone.

    search_vectors.py FILE.fbin|FILE.npy ID...     the 10 nearest of each, as `meander retrieve query` finds them
"""
import csv
import sys

import numpy


def read_vectors(path):
    """(rows x values of float32, mapped and not read; ids in the same order)."""
    if path.endswith(".npy"):
        vectors = numpy.load(path, mmap_mode="r")
    else:
        rows, width = numpy.fromfile(path, "<u4", 2)
        vectors = numpy.memmap(path, "<f4", "r", offset=8, shape=(int(rows), int(width)))
    with open(path + ".ids.csv", encoding="utf-8", newline="") as lines:
        ids = [line["id"] for line in csv.DictReader(lines)]
    return vectors, ids


def nearest(vectors, query, count=10, block=65536):
    """(positions, distances l1), ascending; of equal distances the lower position first. Memory: a block."""
    distances = numpy.concatenate([numpy.abs(numpy.asarray(vectors[i:i + block]) - query).sum(axis=1)
                                   for i in range(0, len(vectors), block)])
    order = numpy.argsort(distances, kind="stable")[:count]
    return order, distances[order]


def main():
    vectors, ids = read_vectors(sys.argv[1])
    for wanted in sys.argv[2:]:
        at = ids.index(wanted)
        for position, distance in zip(*nearest(vectors, numpy.asarray(vectors[at]), 11)):
            if position != at:
                print(f"{wanted}\t{ids[position]}\t{distance:.6g}")


if __name__ == "__main__":
    main()
