"""What differs between two stores: each dataset, in how many rows, and the largest difference.

    differences.py A.h5 B.h5
"""
import sys

import h5py
import numpy


def datasets(file):
    found = {}
    file.visititems(lambda name, node: found.update({name: node}) if isinstance(node, h5py.Dataset) else None)
    return found


def main():
    a, b = (datasets(h5py.File(path, "r")) for path in sys.argv[1:3])
    for name in sorted(set(a) | set(b)):
        if name not in a or name not in b or a[name].shape != b[name].shape:
            print("%s: not in both, or of another shape" % name)
            continue
        x, y = a[name][()], b[name][()]
        if x.dtype == object or x.dtype.fields:
            if not numpy.array_equal(x, y):
                print("%s: differs" % name)
            continue
        if x.tobytes() == y.tobytes():
            continue
        rows = numpy.flatnonzero((x != y).reshape(len(x), -1).any(1)) if x.ndim else [0]
        largest = numpy.nanmax(numpy.abs(x.astype(float) - y.astype(float)))
        print("%s: %d of %d rows, by %.3g at most" % (name, len(rows), len(x) if x.ndim else 1, largest))


main()
