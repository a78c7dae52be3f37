"""Functions of the laboratory over numpy arrays: laboratory.NAME(..., array=..., option=...).

What each takes and returns stands before it in jobs/laboratory/functions. Arrays are arguments of the type numpy.ndarray,
all else are options. `staged=` takes the result of an earlier call, as `stage` makes it.

    >>> from meander import laboratory
    >>> square = laboratory.points_in_square(method="sobol", n=64)
    >>> laboratory.square_discrepancy(points=square.points).boxes < 0.1
    True
"""
import functools

from ._core import call_laboratory


def __getattr__(name):
    if name.startswith("_"):
        raise AttributeError(name)
    return functools.partial(call_laboratory, name)


def require():
    """Ends the program where this build has no laboratory."""
    try:
        call_laboratory("points_in_square", method="random", n=1)
    except RuntimeError as error:
        raise SystemExit(str(error)) from None
