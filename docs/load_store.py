#!/usr/bin/env python3
"""Loading a store: into numpy arrays, and as a data set for PyTorch's DataLoader. Needs h5py alone.

    load_store.py STORE       prints what it loaded
"""
import json
import os
import sys

import h5py
import numpy


def open_store(path):
    """The file of a store. The packs of one that is divided must be there: HDF5 gives empty rows for a file it misses."""
    store = h5py.File(path)
    if "packs" in store:
        folder = os.path.dirname(path)
        for name, size in zip(store["packs/file"].asstr()[:], store["packs/bytes"][:]):
            pack = os.path.join(folder, name)
            if not os.path.exists(pack) or os.path.getsize(pack) != size:
                store.close()
                raise FileNotFoundError(f"{path}: its pack {pack} is missing or another file")
    return store


def rows_of(store, split=None):
    """The numbers of all ok rows, or of those in one split ("train", "test", "validation")."""
    chosen = store["items/status"][:] == 0
    if split:
        column = store["items/split"]
        chosen &= column[:] == h5py.check_enum_dtype(column.dtype)[split]
    return numpy.flatnonzero(chosen)


def load_store(path, descriptor=None, split=None):
    """All ok rows: points (rows, n, 3), labels (rows,), ids, and a descriptor (rows, values) if one is named.

    With a split only the rows of it. Rows whose descriptor could not be made (NaN) are left out with it.
    """
    with open_store(path) as store:
        rows = rows_of(store, split)
        values = None
        if descriptor:
            values = store["descriptors"][descriptor][:][rows]
            described = numpy.isfinite(values).all(axis=1)
            rows, values = rows[described], values[described]
        points = store["points"][:][rows]
        labels = store["label"][:, 0][rows]
        ids = store["items/id"].asstr()[:][rows]
    return points, labels, ids, values


def names_of(store, row):
    """What the classes of a row are called: {"object": ["seat", "leg"]}, class i being entry i; {} where nothing is."""
    if "names" not in store:
        return {}
    ends = numpy.cumsum(store["items/names_bytes"][: row + 1], dtype=numpy.uint64)
    begin, end = int(ends[-2]) if row > 0 else 0, int(ends[-1])
    return json.loads(store["names"][begin:end].tobytes()) if end > begin else {}


class StoreDataset:
    """One item per ok row (of a split): (points, normals, label), the first `samples` of each (every prefix is a good sample).

    For torch.utils.data.DataLoader, which asks for __len__ and __getitem__ and turns the arrays into tensors.
    HDF5 files do not survive a fork: each process opens the store at its first item, so workers may be forked
    or spawned, and the object can be pickled.
    """

    def __init__(self, path, samples=None, split=None):
        self.path = path
        self.samples = samples
        self.store = None
        self.owner = None  # the process that opened it
        with open_store(path) as store:
            if "normals" not in store:
                raise ValueError(f"`{path}` has no normals: it was made with a --store that leaves them out")
            self.rows = rows_of(store, split)

    def __len__(self):
        return len(self.rows)

    def __getitem__(self, index):
        store = self._open()
        row = self.rows[index]
        return store["points"][row, : self.samples], store["normals"][row, : self.samples], int(store["label"][row, 0])

    def __getstate__(self):
        return {**self.__dict__, "store": None, "owner": None}

    def _open(self):
        if self.owner != os.getpid():
            self.store = open_store(self.path)
            self.owner = os.getpid()
        return self.store


if __name__ == "__main__":
    all_points, all_labels, all_ids, _ = load_store(sys.argv[1])
    print(f"{len(all_ids)} models x {all_points.shape[1]} points, {len(set(all_labels.tolist()))} labels")
    dataset = StoreDataset(sys.argv[1], samples=64)
    print(f"data set of {len(dataset)}" + (
        f", the first item {dataset[0][0].shape} of label {dataset[0][2]}" if len(dataset) else ""))
