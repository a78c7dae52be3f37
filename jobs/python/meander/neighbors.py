"""The nearest rows of descriptors and of any other vectors, exactly: every distance is computed."""
import operator
import os
from typing import NamedTuple

import numpy

from . import _core
from .store import Store, open_store


class Neighbors(NamedTuple):
    """Of Q queries, the nearest first; of equal distances the lower row first.

    rows: (Q, k) int64. distances: (Q, k) float32.
    """
    rows: numpy.ndarray
    distances: numpy.ndarray


def knn(base, queries=None, k=10, *, descriptor=None, distance="l1"):
    """The k nearest rows to each query.

    base: a Store or its path, with the name of a `descriptor` in it; or vectors: (M, B) real numbers, or the path of an .npy
        file of such, as networks leave them.
    queries: vectors (Q, B), of a descriptor as meander.describe gives it, or the path of an .npy file; or rows of the base, as
        numbers (Q,) or, of a store, ids, which are not among their own neighbors; None: all rows, of a store all that have the
        descriptor (`Store.described`).
    k: 1 or more. distance: "l1", "l2", "emd" (between running sums, for histograms), "chi2" or "cosine".

    Returns Neighbors: rows and distances, (Q, min(k, rows of the base)), without the query itself one less. The rows of a
    store are its own, which Store.ids and Store.labels are indexed by: those that `meander retrieve query` finds, with the
    same distances. (Descriptors of separate values, "basics" for example, are brought to mean 0 and deviation 1 over the
    rows.) Numbers are compared as float32. Raises ValueError for numbers that are not finite, rows without the descriptor
    and an unknown distance, KeyError for an unknown descriptor. Exact, parallel, and the same for every number of threads;
    O(Q M B) time, about 0.3 ns a number, and memory for two copies of the base.

        >>> found = meander.knn([[0, 0], [0, 1], [5, 5]], [[0, 0.9], [4, 4]], k=2)
        >>> found.rows.tolist(), found.distances[1].tolist()
        ([[1, 0], [2, 1]], [2.0, 7.0])
        >>> meander.knn([[0, 0], [0, 1], [5, 5]], k=1, distance="l2").rows.tolist()      # each but itself
        [[1], [0], [1]]
    """
    options = {"k": operator.index(k), "distance": distance}
    if options["k"] < 1:
        raise ValueError("k is %d: 1 or more" % options["k"])
    if isinstance(base, Store):
        return _in_store(base, queries, descriptor, options)
    if isinstance(base, (str, os.PathLike)) and not os.fspath(base).endswith(".npy"):
        with open_store(base) as store:
            return _in_store(store, queries, descriptor, options)
    if descriptor is not None:
        raise ValueError("descriptor is for stores: the base is an array")
    base = _vectors(base, "base")
    if queries is None:
        queries = numpy.arange(len(base))
    return _nearest(base, *_rows_or_vectors(queries), options)


def _in_store(store, queries, name, options):
    if name is None:
        raise ValueError("a store has descriptors by name: say descriptor=, one of %s"
                         % (", ".join(store.descriptors) or "none"))
    rows = store.described(name)
    if len(rows) == 0:
        raise ValueError("no row of `%s` has the descriptor %r" % (store.path, name))
    values = store.file["descriptors"][name][:][rows]
    scale = None
    if "columns" in store.file["descriptors"][name].attrs:  # separate values and no histogram
        # Added up one after the other, as by `retrieve`: to the same last bit.
        mean = numpy.cumsum(values, axis=0, dtype=numpy.float64)[-1] / len(values)
        deviation = numpy.sqrt(numpy.cumsum((values - mean) ** 2, axis=0)[-1] / len(values))
        deviation[~(deviation > 1e-6 * abs(mean))] = numpy.inf  # constant: 0
        scale = mean, deviation
        values = ((values - mean) / deviation).astype(numpy.float32)
    if queries is None:
        numbers, vectors = rows, None
    elif not isinstance(queries, (str, os.PathLike)) and len(queries) > 0 and all(isinstance(one, str) for one in queries):
        numbers, vectors = numpy.array([store.row(one) for one in queries]), None
    else:
        numbers, vectors = _rows_or_vectors(queries)
    if vectors is not None and scale is not None:
        vectors = ((vectors - scale[0]) / scale[1]).astype(numpy.float32)
    if numbers is not None:
        at = numpy.searchsorted(rows, numbers)
        lacking = (at == len(rows)) | (rows[numpy.minimum(at, len(rows) - 1)] != numbers)
        if lacking.any():
            number = int(numbers[lacking.argmax()])
            raise ValueError("row %d%s has no descriptor %r" % (
                number, " (`%s`)" % store.ids[number] if 0 <= number < len(store) else "", name))
        numbers = at
    found = _nearest(values, numbers, vectors, options)
    return Neighbors(rows[found.rows] if found.rows.size else found.rows, found.distances)


def _nearest(base, numbers, vectors, options):
    arrays = {"base": base}
    if vectors is not None:
        arrays["queries"] = vectors
        if vectors.shape[1] != base.shape[1]:
            raise ValueError("queries have %d numbers each where the base has %d" % (vectors.shape[1], base.shape[1]))
    else:
        if len(numbers) and not 0 <= numbers.min() <= numbers.max() < len(base):
            raise ValueError("queries: there is no row %d of %d" % (
                numbers.min() if numbers.min() < 0 else numbers.max(), len(base)))
        arrays["rows"] = numpy.ascontiguousarray(numbers, numpy.uint32)
    if len(vectors if vectors is not None else numbers) == 0:
        return Neighbors(numpy.zeros((0, 0), numpy.int64), numpy.zeros((0, 0), numpy.float32))
    found = _core.call_function("nearest_rows", arrays, options)
    return Neighbors(found.rows.astype(numpy.int64), found.distances)


def _rows_or_vectors(queries):
    """Numbers of rows, or vectors; None for the other."""
    array = queries if isinstance(queries, (str, os.PathLike)) else numpy.asarray(queries)
    if not isinstance(array, (str, os.PathLike)) and array.ndim == 1 and (array.dtype.kind in "iu" or array.size == 0):
        return array, None
    return None, _vectors(array, "queries")


def _vectors(values, name):
    """(n, B) float32."""
    if isinstance(values, (str, os.PathLike)):
        values = numpy.load(values, mmap_mode="r")
    array = numpy.asarray(values)
    if array.ndim != 2 or array.dtype.kind not in "fiu" or 0 in array.shape[1:]:
        raise ValueError("%s must be real numbers of the shape (n, B), not %s %s" % (name, array.dtype, array.shape))
    return numpy.ascontiguousarray(array, numpy.float32)
