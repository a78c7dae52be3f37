"""Stores (docs/STORE.md) as numpy arrays and as data sets. Needs h5py."""
import json
import os

import numpy

from . import _core


def open_store(path):
    """Opens a store that `meander run`, `surface` or `describe` has written, for reading. See Store."""
    return Store(path)


def _h5py():
    try:
        import h5py
    except ImportError:
        raise ImportError("stores are read with h5py, which is not installed (Debian: python3-h5py)") from None
    return h5py


def _open(path):
    """The h5py.File of a store. FileNotFoundError where it is in packs and one is missing: HDF5 would read empty rows."""
    file = _h5py().File(path, "r")
    if "packs" in file:
        for name, size in zip(file["packs/file"].asstr()[:], file["packs/bytes"][:]):
            pack = os.path.join(os.path.dirname(path), name)
            if not os.path.exists(pack) or os.path.getsize(pack) != size:
                file.close()
                raise FileNotFoundError("`%s`: its pack `%s` is missing or another file" % (path, pack))
    return file


class Store:
    """A store: its rows as numpy arrays. Use it in a `with` statement, or close it.

    ids: of all M rows, in their order; status: words, "ok" for rows with points; labels: (M,) int32, -1 where unknown.
    ok: the numbers of the rows that have points. samples: points a row. attributes: the names of those that are stored.
    file: the h5py.File, for everything else (docs/STORE.md lists the datasets).
    """

    def __init__(self, path):
        h5py = _h5py()
        self.path = os.fspath(path)
        self.file = _open(self.path)
        kind = self.file.attrs.get("format", "")
        if (kind.decode() if isinstance(kind, bytes) else kind) != "meander":
            self.file.close()
            raise ValueError("`%s` is no store of Meander" % self.path)
        column = self.file["items/status"]
        words = {number: word for word, number in h5py.check_enum_dtype(column.dtype).items()}
        numbers = column[:]
        self.status = [words[number] for number in numbers]
        self.ok = numpy.flatnonzero(numbers == 0)
        self.ids = self.file["items/id"].asstr()[:].tolist()
        self.labels = self.file["label"][:, 0]
        self.samples = int(self.file.attrs["samples"])
        self.attributes = list(self.file["attributes"]) if "attributes" in self.file else []
        self._row_of = None
        self._name_ends = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self.file.close()

    def __len__(self):
        return len(self.ids)

    def __repr__(self):
        return "<meander.Store %s: %d rows, %d ok, %d points each>" % (self.path, len(self), len(self.ok), self.samples)

    def row(self, item):
        """The number of a row given by its id or its number. KeyError, IndexError."""
        if isinstance(item, str):
            if self._row_of is None:
                self._row_of = {name: row for row, name in enumerate(self.ids)}
            return self._row_of[item]
        if not -len(self) <= item < len(self):
            raise IndexError("row %d of %d" % (item, len(self)))
        return int(item) % len(self)

    def reason(self, item):
        """Why a row is not ok: one sentence."""
        return self.file["items/reason"].asstr()[self.row(item)]

    def __getitem__(self, item):
        """All samples of one row by name: points, normals, face_index, ..., as far as the store has them; with --attribute
        `attributes`, a dict by name. KeyError for an id that is not there, SamplingError with its status for a row
        without points."""
        from . import SamplingError
        row = self.row(item)
        if self.status[row] != "ok":
            raise SamplingError(self.status[row], self.reason(row), row)
        arrays = {}
        for column in _core.columns():
            for name in (column["dataset"], column["former"]):
                if name in self.file:
                    arrays[column["dataset"].replace("/", "_")] = self.file[name][row]
                    break
        if self.attributes:
            arrays["attributes"] = {name: self.file["attributes/" + name][row] for name in self.attributes}
        return arrays

    def lacks(self, item):
        """The names of the columns in which a row has NaN, or no class (-1), at one sample or more: "attributes/NAME",
        "texcoord"."""
        if "items/lacks" not in self.file:
            return []
        column = self.file["items/lacks"]
        bits = int(column[self.row(item)])
        return [name for bit, name in enumerate(column.attrs["names"]) if bits >> bit & 1]

    def notes(self, item):
        """What the file of a row asks for and did not get: a dict of counts by kind, and under "text" what they say;
        empty where there is nothing, and for stores that do not tell (format version 4 and before)."""
        if "items/notes" not in self.file:
            return {}
        row = self.row(item)
        counts = self.file["items/notes"]
        notes = {name: int(count) for name, count in zip(counts.attrs["names"], counts[row]) if count}
        if notes:
            notes["text"] = self.file["items/note_text"][row].decode()
        return notes

    def names(self, item):
        """What the classes of a row are called: a dict by attribute (group, material, object, part, as far as they are
        stored) of lists, class i being entry i. Of very many names the last are missing."""
        if "names" not in self.file:
            return {}
        if self._name_ends is None:
            self._name_ends = numpy.cumsum(self.file["items/names_bytes"][:], dtype=numpy.uint64)
        row = self.row(item)
        begin, end = int(self._name_ends[row - 1]) if row > 0 else 0, int(self._name_ends[row])
        return json.loads(self.file["names"][begin:end].tobytes().decode()) if end > begin else {}

    def points(self, split=None):
        """(rows, n, 3) float32: the points of all ok rows, or of those in "train", "test" or "validation"."""
        return self.file["points"][self.rows(split)]

    def descriptor(self, name, split=None):
        """(rows, values) float32 of the same rows; NaN where it could not be made."""
        return self.file["descriptors"][name][self.rows(split)]

    def rows(self, split=None):
        """The numbers of all ok rows, or of those in one split."""
        if split is None:
            return self.ok
        column = self.file["items/split"]
        numbers = _h5py().check_enum_dtype(column.dtype)
        if split not in numbers:
            raise ValueError("no split %r: %s" % (split, ", ".join(numbers)))
        return self.ok[column[:][self.ok] == numbers[split]]

    def dataset(self, samples=None, split=None):
        """A data set for torch.utils.data.DataLoader: see StoreDataset."""
        return StoreDataset(self.path, samples, split)


try:
    from torch.utils.data import Dataset as _Dataset
except ImportError:
    _Dataset = object


class StoreDataset(_Dataset):
    """(points, normals, label) of every ok row (of a split); a torch Dataset where PyTorch is installed.

    samples: the first so many of each row (every prefix is a good sample); None for all.
    HDF5 files do not survive a fork: each process opens the store at its first item, so workers may be forked or
    spawned, and the object can be pickled.
    """

    def __init__(self, path, samples=None, split=None):
        self.path = os.fspath(path)
        with Store(self.path) as store:
            if samples is not None and not 1 <= samples <= store.samples:
                raise ValueError("samples is %d: the store has %d a row" % (samples, store.samples))
            if "normals" not in store.file:
                raise ValueError("`%s` has no normals: it was made with a --store that leaves them out" % self.path)
            self.rows = store.rows(split)
            self.labels = store.labels[self.rows]
        self.samples = samples
        self._file = None
        self._owner = None  # the process that opened it

    def __len__(self):
        return len(self.rows)

    def __getitem__(self, index):
        file = self._open()
        row = self.rows[index]
        return file["points"][row, : self.samples], file["normals"][row, : self.samples], int(self.labels[index])

    def __getstate__(self):
        return {**self.__dict__, "_file": None, "_owner": None}

    def _open(self):
        if self._owner != os.getpid():
            self._file = _open(self.path)
            self._owner = os.getpid()
        return self._file
