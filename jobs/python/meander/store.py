"""Stores (docs/STORE.md) as numpy arrays and as data sets. Needs h5py."""
import json
import operator
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
        raise ImportError("stores are read with h5py, which is not installed: `pip install h5py`, or python3-h5py of Debian") from None
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


def _words(column):
    """The numbers of an enum dataset, and its words by number."""
    return column[:], {number: word for word, number in _h5py().check_enum_dtype(column.dtype).items()}


def _datasets(file):
    """The datasets of samples in a store, by every name that a column goes by: "face" and "face_index", for example;
    attributes as "attributes/NAME", descriptors as "descriptors/NAME"."""
    found = {}
    for column in _core.columns():
        stored = next((name for name in (column["dataset"], column["former"]) if name in file), None)
        if stored is not None:
            for name in (column["dataset"], column["former"], column["array"], column["dataset"].replace("/", "_")):
                found[name] = stored
    for group in ("attributes", "descriptors"):
        found.update({"%s/%s" % (group, name): "%s/%s" % (group, name) for name in file.get(group, ())})
    return found


def _set_of(dataset):
    """Which points of a row a dataset has values of: "samples", "sharp" or "queries"; None for descriptors."""
    if dataset.startswith("descriptors/"):
        return None
    return next((column["set"] for column in _core.columns() if dataset in (column["dataset"], column["former"])), "samples")


class Store:
    """A store: its rows as numpy arrays. Use it in a `with` statement, or close it.

    A store has M rows, one for each model of the input, each with a status. Arrays below that are of "the ok rows" leave
    out those without points.

    ids: M names, paths below the input folder, ascending. status: M words, "ok" for rows with points.
    ok: the numbers of the rows with points, ascending. samples: points a row.
    sizes: a dict by set of points, "samples" and, as far as there are such, "sharp" and "queries": points a row.
    labels: (M,) int32 numbers of classes, -1 where unknown; class_names: the name of class 0, 1, ...
    splits: M words, "train", "test", "validation" or "none".
    columns: the names of the columns of samples that are stored, for `column` and StoreDataset.
    attributes: the names of those that `run --attribute` stored. descriptors: names, of `run --describe`.
    color_sources: M words, where the colors of a row come from ("texture", "vertex", "face", "material", "none"); None for a
        store without colors.
    file: the h5py.File, for everything else (docs/STORE.md lists the datasets).
    """

    def __init__(self, path):
        self.path = os.fspath(path)
        self.file = _open(self.path)
        kind = self.file.attrs.get("format", "")
        if (kind.decode() if isinstance(kind, bytes) else kind) != "meander":
            self.file.close()
            raise ValueError("`%s` is no store of Meander" % self.path)
        numbers, words = _words(self.file["items/status"])
        self.status = [words[number] for number in numbers]
        self.ok = numpy.flatnonzero(numbers == 0)
        self.ids = self.file["items/id"].asstr()[:].tolist()
        self.labels = self.file["label"][:, 0]
        self.class_names = [str(name) for name in self.file["label"].attrs.get("names", ())]
        self.samples = int(self.file.attrs["samples"])
        self.sizes = {name: int(self.file.attrs[name]) for name in ("samples", "sharp", "queries") if name in self.file.attrs}
        self._datasets = _datasets(self.file)
        self.columns = [name for name, dataset in self._datasets.items() if name == dataset]
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
        stored = _datasets(self.file)
        arrays = {name: self.file[stored[name]][row]
                  for name in (column["dataset"].replace("/", "_") for column in _core.columns()) if name in stored}
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

    @property
    def splits(self):
        numbers, words = _words(self.file["items/split"])
        return [words[number] for number in numbers]

    @property
    def color_sources(self):
        if "items/color_source" not in self.file:
            return None
        numbers, words = _words(self.file["items/color_source"])
        return [words[number] for number in numbers]

    @property
    def rgb(self):
        """(rows, n, 3) uint8: the colors of all ok rows as displayed (sRGB), of a run with `--colors`. Reads all of them;
        `column("rgb", split, points)` reads some. KeyError for a store without colors."""
        return self.column("rgb")

    @property
    def noted(self):
        """A dict from id to `notes(id)` of the rows whose file asks for something that it did not get."""
        if "items/notes" not in self.file:
            return {}
        rows = numpy.flatnonzero(self.file["items/notes"][:].any(axis=1))
        return {self.ids[row]: self.notes(int(row)) for row in rows}

    def dataset_of(self, column):
        """The path of the dataset of a column (of `columns`). KeyError that names those that there are."""
        if column not in self._datasets:
            raise KeyError("`%s` has no column %r: it has %s" % (self.path, column, ", ".join(self.columns)))
        return self._datasets[column]

    def column(self, name, split=None, points=None):
        """(rows, n, ...) of a column of samples, or (rows, values) of a descriptor, of the ok rows (of a split).

        name: one of `columns`, "points", "rgb", "attributes/NAME", "descriptors/NAME", "queries/distance" ... points: the
        first so many of each row, 1 to as many as a row has of that column: of "sharp/..." and "queries/..." `sizes`, of others
        n; None for all. Memory: the array.
        """
        path, rows = self.dataset_of(name), self.rows(split)
        dataset, whole = self.file[path], len(rows) == len(self)  # HDF5 is slow with lists of rows
        if points is None or _set_of(path) is None:
            return dataset[:] if whole else dataset[rows]
        points = self.check_points(points, _set_of(path))
        return dataset[:, :points] if whole else dataset[rows, :points]

    def check_points(self, points, of="samples"):
        """`points` as a number of points to take from the beginning of each row of a set of points (of `sizes`). ValueError for
        one that rows do not have, and for a store of `run --order curve`, where they are a part of the surface or of its edges."""
        points = operator.index(points)
        if of not in self.sizes:
            raise ValueError("`%s` has no points of %r: %s" % (self.path, of, ", ".join(self.sizes)))
        if not 1 <= points <= self.sizes[of]:
            raise ValueError("points is %d: 1 to the %d of a row of `%s`%s" % (
                points, self.sizes[of], self.path, "" if of == "samples" else " in /" + of))
        order = self.file["points"].attrs.get("order", "progressive") if of != "queries" else "progressive"
        if points < self.sizes[of] and (order.decode() if isinstance(order, bytes) else order) != "progressive":
            raise ValueError("the first %d points of a row of `%s` lie in one part of the surface, for it was made with "
                             "--order curve" % (points, self.path))
        return points

    def points(self, split=None):
        """(rows, n, 3) float32: the points of all ok rows, or of those in "train", "test" or "validation"."""
        return self.column("points", split)

    def descriptor(self, name, split=None):
        """(rows, values) float32 of the same rows; NaN where it could not be made."""
        return self.column("descriptors/" + name, split)

    @property
    def descriptors(self):
        return list(self.file.get("descriptors", ()))

    def described(self, name):
        """The numbers of the ok rows that have a descriptor, ascending. KeyError where there is none of that name."""
        values = self.file[self.dataset_of("descriptors/" + name)][:]
        return self.ok[numpy.isfinite(values[self.ok]).all(axis=1)]

    def rows(self, split=None):
        """The numbers of all ok rows, or of those in one split."""
        if split is None:
            return self.ok
        numbers, words = _words(self.file["items/split"])
        split = {"val": "validation"}.get(split, split)
        if split not in words.values():
            raise ValueError("no split %r: %s" % (split, ", ".join(words.values())))
        return self.ok[[words[number] == split for number in numbers[self.ok]]]

    def dataset(self, **options):
        """A data set for torch.utils.data.DataLoader, with the options of StoreDataset."""
        return StoreDataset(self.path, **options)


try:
    from torch.utils.data import Dataset as _Dataset
except ImportError:
    _Dataset = object


# Columns of StoreDataset that are one value an item.
_ITEM_COLUMNS = ("label", "class_name", "id", "split", "row")


class StoreDataset(_Dataset):
    """The ok rows of a store (of a split) as a sequence of tuples, for torch.utils.data.DataLoader; a torch Dataset where
    PyTorch is installed, and a plain sequence where it is not.

    store: the path, or an open Store. columns: what an item has, in this order: names of Store.columns ("points", "normals",
        "rgb", "face", "attributes/NAME", "descriptors/NAME" ...), each an array with a row for each point, and "label" (int,
        -1 where unknown), "class_name", "id", "split" (texts), "row" (int, in the store). One name by itself, not in a list:
        items are that value and no tuples.
    transform: called with the values of an item as arguments, transform(points, normals, label); what it returns is the item.
    points: the first so many points of each row, 1 to n; None for all. Every prefix is a good sample, so that 256 of 4,096
        points take no farthest point sampling. A number holds for all columns, so that with columns of `queries` it is one of
        queries; a dict by set, {"samples": 256, "sharp": 128, "queries": 4096}, gives each its own, and all of those that it
        does not name.
    split: "train", "test" or "validation" ("val"); None for all.

    rows: the numbers of the rows. labels, class_names: as Store, `labels` of the rows of this data set.

    HDF5 files do not survive a fork: each process opens the store at its first item, so workers may be forked or spawned, and
    the object can be pickled (with its transform, which must then be a function of a module). ValueError for a store without
    a column, for more points than there are, and for a split that is unknown or has no rows.
    """

    def __init__(self, store, columns=("points", "normals", "label"), *, transform=None, points=None, split=None):
        self.path = store.path if isinstance(store, Store) else os.fspath(store)
        self.columns = columns if isinstance(columns, str) else tuple(columns)
        self.transform = transform
        with Store(self.path) as opened:
            self.points = points
            self.rows = opened.rows(split)
            if split is not None and len(self.rows) == 0:
                raise ValueError("`%s` has no ok row in the split %r: splits come from the folders (--layout) or from files "
                                 "(--labels)" % (self.path, split))
            self.labels = opened.labels[self.rows]
            self.class_names = opened.class_names
            self._plan = [self._source(opened, name) for name in self._names()]
            self._counts = self._checked_counts(opened)
        self._file = None
        self._owner = None  # the process that opened it

    def _names(self):
        return (self.columns,) if isinstance(self.columns, str) else self.columns

    def _source(self, store, name):
        """(dataset of samples, None), or (None, the values of the items)."""
        if name == "label":
            return None, self.labels.tolist()
        if name == "class_name":
            return None, [store.class_names[label] if label >= 0 else "" for label in self.labels]
        if name == "row":
            return None, self.rows.tolist()
        if name in ("id", "split"):
            values = store.ids if name == "id" else store.splits
            return None, [values[row] for row in self.rows]
        try:
            return store.dataset_of(name), None
        except KeyError as error:
            raise ValueError("%s, and %s" % (error.args[0], ", ".join(_ITEM_COLUMNS))) from None

    def _checked_counts(self, store):
        """For each column how many points of a row it takes; None: all, or not a column of points."""
        sets = [None if dataset is None else _set_of(dataset) for dataset, _ in self._plan]
        if self.points is None:
            return [None] * len(sets)
        if isinstance(self.points, dict):
            checked = {name: store.check_points(count, name) for name, count in self.points.items()}
        else:
            checked = {name: store.check_points(self.points, name) for name in set(filter(None, sets)) or {"samples"}}
        return [checked.get(name) for name in sets]

    def __len__(self):
        return len(self.rows)

    def __getitem__(self, index):
        file = self._open()
        row = self.rows[index]  # IndexError ends a loop over a sequence
        item = tuple(values[index] if dataset is None else
                     file[dataset][row] if count is None else file[dataset][row, :count]
                     for (dataset, values), count in zip(self._plan, self._counts))
        if self.transform is not None:
            return self.transform(*item)
        return item[0] if isinstance(self.columns, str) else item

    def __getstate__(self):
        return {**self.__dict__, "_file": None, "_owner": None}

    def _open(self):
        if self._owner != os.getpid():
            self._file = _open(self.path)
            self._owner = os.getpid()
        return self._file
