"""Which figures there are, in the order of the page."""
import importlib
from typing import Callable, NamedTuple


class Figure(NamedTuple):
    name: str
    draw: Callable
    has_models: bool


# Module, then the names of its figures; those that show models, which --view and --size apply to, end with *.
_MODULES = [("plane", "1 point-sets 2 3 4-plane 4-placement 4-sphere"), ("meshes", "4-mesh"), ("plane", "5"),
            ("surfaces", "6* 7* 8*"), ("splats", "9* 10* 11*"), ("tensors", "12* 13* 14* 15"),
            ("spectra", "16*"), ("tensors", "16-tensor"), ("splats", "17*"), ("strokes", "18* 19* 20*"),
            ("meshes", "21* metro*"), ("histograms", "22 23 24 25 26 table-1 histogram-floors"),
            ("spaced", "spaced spaced-sets*"), ("limit", "limit")]


def _function(module, name):
    """The function of a figure: draw_4_plane of the module `plane`."""
    return getattr(importlib.import_module("." + module, __package__), "draw_" + name.replace("-", "_"))


def names():
    return [name.rstrip("*") for _, figures in _MODULES for name in figures.split()]


def drawn_with(wanted):
    """The names of the figures that a name or a number stands for: 4 for 4-plane, 4-sphere ..."""
    return [name for name in names() if name == wanted or (wanted.isdigit() and name.split("-")[0] == wanted)]


def chosen(only):
    """All where `only` is empty."""
    wanted = {name for word in only for name in drawn_with(word)}
    return [Figure(name.rstrip("*"), _function(module, name.rstrip("*")), name.endswith("*"))
            for module, figures in _MODULES for name in figures.split() if not only or name.rstrip("*") in wanted]
