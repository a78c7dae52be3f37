"""Evenly spread samples of surfaces: what `meander run` makes of files, of numpy arrays.

    >>> import numpy, meander
    >>> vertices = [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]
    >>> faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]]
    >>> samples = meander.sample(vertices, faces, n=1000)
    >>> samples.points.shape, samples.points.dtype.name
    ((1000, 3), 'float32')
    >>> bool(numpy.isclose(samples.area, 8 * numpy.sqrt(3)))
    True

Every function releases the interpreter's lock while it works, and results do not depend on the number of threads. Long
calls end at Ctrl-C. A process that was forked after a call should keep to threads=1 (or be spawned instead).
"""
import dataclasses
import difflib
import functools
import inspect
import operator
import os
import textwrap

import numpy

from . import _core, _program
from ._core import SamplingError, __version__
from ._program import RunResult, RunStopped
from .neighbors import Neighbors, knn
from .store import Store, StoreDataset, open_store

__all__ = ["BoxError", "Mesh", "Neighbors", "RemeshedMesh", "RunResult", "RunStopped", "Samples", "SamplingError",
           "SignedDistances", "Store", "StoreDataset", "content_of", "describe", "descriptor_names", "knn", "measure", "measure_boxes", "open_store",
           "read_mesh", "remesh", "run", "sample", "sample_file", "sample_many", "signed_distance", "surface", "surface_names",
           "winding_number", "write_points"]

BoxError, Mesh = _core.BoxError, _core.Mesh
for _class in (BoxError, Mesh, Neighbors, SamplingError, RunResult, RunStopped):
    _class.__module__ = "meander"


_NUMBER_OF = {"samples": "n", "sharp": "sharp", "queries": "q"}  # what docstrings call the number of points of a set


def _with_columns(cls):
    """The class with a field, and a line of the docstring, for each column of samples."""
    rows = _core.columns()
    cls.__annotations__ = {**{row["array"]: numpy.ndarray for row in rows}, **cls.__annotations__}
    lines = ["%s: (%s%s) %s, %s%s" % (row["array"], _NUMBER_OF[row["set"]], ", %d" % row["width"] if row["width"] else ",", numpy.dtype(row["type"]),
                                     row["doc"], "" if row["always"] else "; None without `%s`" % row["option"]
                                     if row["option"] else "; None of other samples") for row in rows]
    cls.__doc__ += "\n    %s\n    " % "\n    ".join(lines)
    return dataclasses.dataclass(eq=False, repr=False)(cls)


@_with_columns
class Samples:
    """n samples of one surface, in an order in which every prefix is a good sample (`order="progressive"`).

    The arrays are those of a row of a store (numpy views of the memory that they were computed in, no copies), and stay
    valid as long as any of them is used. Coordinates of the mesh are loc + scale * points; loc is 0 and scale 1 unless
    `normalize` is given or float32 could not tell the points apart.
    """
    weights: numpy.ndarray      # (n,) float64, area that each stands for: sum(weights * g(points)) integrates g
    attributes: dict            # name: (n,) or (n, k) float32, int32 of classes (-1: none), as asked for with `attributes`
    names: dict                 # attribute: list of the names of its classes 0, 1, ..., of files that have names
    color_source: str           # where rgb is from: texture, vertex, face, material, or none (no colors at all)
    color_fills: int            # samples without a color, whose rgb is 204, 204, 204
    notes: dict                 # what a file asks for and did not get, counted by name; note_text says it in words
    note_text: str
    descriptors: dict           # name: float32 values, as asked for with `describe`
    area: float                 # of the surface, in squared units of the mesh
    measure: float              # area x density
    bbox: numpy.ndarray         # (2, 3) float64, least and largest coordinates of the mesh
    loc: numpy.ndarray          # (3,) float64
    scale: float
    method: str                 # the weakest that any component needed: balanced, direct, conformal, mean-value ...
    components: int             # connected ones; 0 without topology, as the next two
    genus: int                  # sum over the components
    boundaries: int             # loops
    repairs: dict               # what was dropped or mended, counted by name; empty for a clean mesh
    sharp_edges: int            # how many edges are sharp, as asked for with `sharp`; 0 where there is none
    sharp_length: float         # their length, in units of the mesh
    sign_rule: str              # how the sides of points of `queries` were decided: closed, winding, shell, none
    uncertain: int              # how many of them have no certain side
    content: bytes              # the 32 bytes that the random numbers are keyed by

    def __len__(self):
        return len(self.points)

    def __repr__(self):
        return "<meander.Samples: %d points, area %.6g, method %s>" % (len(self), self.area, self.method)

    def coordinates(self):
        """(n, 3) float64: the points in the coordinates of the mesh."""
        return self.loc + self.scale * self.points.astype(numpy.float64)

    def interpolate(self, values):
        """Values at the vertices, (V,) or (V, k), at the samples: (n,) or (n, k) float64.

        >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        >>> samples = meander.sample(square, [[0, 1, 2], [0, 2, 3]], n=64)
        >>> bool(numpy.allclose(samples.interpolate(square), samples.points, atol=1e-6))
        True
        """
        if self.corners is None:
            raise ValueError("samples of a parametric surface have no vertices to interpolate between")
        return _between(values, self.corners, self.barycentric)


def _between(values, corners, barycentric):
    """Values of the vertices, weighted in triangles."""
    at = numpy.asarray(values, dtype=numpy.float64)[corners]
    b = barycentric.astype(numpy.float64)
    share = numpy.stack([1 - b[:, 0] - b[:, 1], b[:, 0], b[:, 1]], axis=1)
    return numpy.einsum("nc,nc...->n...", share, at)


def _samples(members):
    """Samples of the members that the core gives, all that there are; the constructor would copy them one by one."""
    made = Samples.__new__(Samples)
    made.__dict__ = members
    return made


@functools.lru_cache(maxsize=32)
def _sampler_of(options, of_files):
    return _core.Sampler(of_files, **dict(options))


_WHOLE = {row["keyword"] for row in _core.settings("mesh") if row["type"] == "int"}
_LISTS = {row["keyword"] for row in _core.settings("file") if row["list"]}
_OF_FILES = [row["keyword"] for row in _core.settings("file") if row not in _core.settings("mesh")]


def _sampler(options, of_files=False, path=None):
    """The one with these options: those that cast rays take a moment to make. With attributes of a file its own."""
    for name in _WHOLE.intersection(options):
        options[name] = operator.index(options[name])
    for name in _LISTS.intersection(options):
        options[name] = _names(options[name])
    if path is not None and options.get("attributes"):
        return _core.Sampler(of_files, path, **options)
    return _sampler_of(tuple(options.items()), of_files)


def _names(describe):
    return tuple(describe.split(",")) if isinstance(describe, str) else tuple(describe)


def _are_of_faces(values, name, vertices, faces, at):
    """Whether the values, one for each vertex or each face, are those of the faces."""
    if at not in (None, "vertices", "faces"):
        raise ValueError("%s_at is %r: \"vertices\" or \"faces\"" % (name, at))
    if at is not None:
        return at == "faces"
    if len(vertices) == len(faces) == len(values):
        raise ValueError("there are as many vertices as faces: say %s_at=\"vertices\" or \"faces\"" % name)
    if len(values) in (len(vertices), len(faces)):
        return len(values) == len(faces)
    raise ValueError("%s has %d values: there are %d vertices and %d faces" % (name, len(values), len(vertices), len(faces)))


def _called(function, vertices, faces, at):
    """What a density function gives at the vertices, or at the middles of the faces; 0 where these are no places."""
    if at not in (None, "vertices", "faces"):
        raise ValueError("density_at is %r: \"vertices\" or \"faces\"" % (at,))
    places = numpy.asarray(vertices, numpy.float64)
    if at == "faces":
        if faces is None:  # of a Mesh
            raise ValueError("the faces have different numbers of corners: density_at=\"vertices\" takes them")
        faces = numpy.asarray(faces)
        known = ((faces >= 0) & (faces < len(places))).all(axis=1)
        corners, places = places, numpy.full((len(faces), 3), numpy.nan)
        places[known] = corners[faces[known]].mean(axis=1)
    finite = numpy.isfinite(places).all(axis=1)
    values = numpy.zeros(len(places))
    if finite.any():
        answer = numpy.asarray(function(places[finite]), dtype=numpy.float64)
        if answer.shape != (numpy.count_nonzero(finite),):
            raise ValueError("the density function gave an array of the shape %s for %d positions: one number each, (%d,), is "
                             "needed" % (answer.shape, finite.sum(), finite.sum()))
        values[finite] = answer
    return values


def _density(density, at, vertices, faces):
    """The density as a word of the library, and its numbers and whether they are of faces; None where it has none."""
    if isinstance(density, str):
        if at is not None:
            raise ValueError("density_at applies to a density given as numbers or as a function")
        if density in ("vertices", "faces"):
            raise ValueError("density is %r: give the numbers themselves" % density)
        return density, None, False
    if callable(density):
        values, of_faces = _called(density, vertices, faces, at), at == "faces"
    else:
        values = numpy.asarray(density)
        if values.ndim != 1:
            raise ValueError("density must be a word, a function, or have the shape (V,) or (F,), not %s" % (values.shape,))
        of_faces = _are_of_faces(values, "density", vertices, faces, at)
    return "faces" if of_faces else "vertices", values, of_faces


def _colors(colors, vertices, faces, at):
    """(n, 3) float32 numbers in [0, 1], and whether they are of faces."""
    values = numpy.asarray(colors)
    if values.ndim != 2 or values.shape[1] not in (3, 4) or not (values.dtype == numpy.uint8 or values.dtype.kind == "f"):
        raise ValueError("colors must be uint8, or real numbers from 0 to 1, of the shape (V, 3) or (F, 3), or 4 with alpha, "
                         "which is left out; not %s %s" % (values.dtype, values.shape))
    of_faces = _are_of_faces(values, "colors", vertices, faces, at)
    count, things = (len(faces), "faces") if of_faces else (len(vertices), "vertices")
    if len(values) != count:
        raise ValueError("colors has %d rows for %d %s" % (len(values), count, things))
    return (values[:, :3] / 255 if values.dtype == numpy.uint8 else values[:, :3]).astype(numpy.float32), of_faces


def _attributes(attributes, vertices, faces, at):
    """Tuples of name, (n, k) values, whether they are of faces, and whether they are classes."""
    table = []
    for name, given in attributes.items():
        values = numpy.asarray(given)
        if not isinstance(name, str) or not name or "," in name:
            raise ValueError("attributes: %r is no name: a text without commas is needed" % (name,))
        if values.dtype.kind not in "fiub" or values.ndim not in (1, 2) or values.ndim == 2 and not 1 <= values.shape[1] <= 4:
            raise ValueError("attributes: %r must be numbers of the shape (V,), (V, k), (F,) or (F, k), k from 1 to 4, not "
                             "%s %s" % (name, values.dtype, values.shape))
        of_faces = _are_of_faces(values, "attributes", vertices, faces, at)
        count, things = (len(faces), "faces") if of_faces else (len(vertices), "vertices")
        if len(values) != count:
            raise ValueError("attributes: %r has %d values for %d %s" % (name, len(values), count, things))
        table.append((name, values.reshape(len(values), -1), of_faces, values.dtype.kind != "f"))
    return table


def _content(content):
    if content is None:
        return None
    if isinstance(content, str):
        content = bytes.fromhex(content)
    return bytes(content)


def _arrays(vertices, faces):
    """Two arrays, or one object that has both (trimesh, Open3D-like)."""
    if isinstance(vertices, (str, bytes, os.PathLike)):
        raise TypeError("%r is a file: sample_file and read_mesh take files" % (vertices,))
    if faces is not None and (isinstance(vertices, Mesh) or hasattr(vertices, "vertices")):
        raise TypeError("a mesh stands by itself: name what follows it, as in n=%r" % (faces,))
    if faces is None:
        mesh = vertices
        if not hasattr(mesh, "vertices") or not hasattr(mesh, "faces"):
            raise TypeError("faces are missing (or an object with `vertices` and `faces`)")
        vertices, faces = mesh.vertices, mesh.faces
    return vertices, faces


def _default(row):
    if "option" in row:  # of the program, which has the defaults
        return False if row["type"] == "bool" and not row["truth"] else None
    return () if row["list"] else float(row["default"]) if row["type"] == "float" else row["default"]


def _shown_default(row):
    return " (default %s)" % row["default"] if "option" in row and row["default"] and "(default" not in row["help"] else ""


def _with_settings(*kinds, without=()):
    """Gives a function with **settings those of the library: in its signature, and in its docstring at {settings}."""
    def decorate(function):
        signature = inspect.signature(function)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        rows = [row for kind in kinds for row in _core.settings(kind)
                if row["keyword"] not in signature.parameters and row["keyword"] not in without]
        names = {row["keyword"] for row in rows}

        @functools.wraps(function)
        def checked(*arguments, **keywords):
            for name in keywords:
                if name not in names and name not in signature.parameters:
                    near = difflib.get_close_matches(name, [*names, *signature.parameters], 1)
                    raise TypeError("%s() got an unexpected keyword argument %r%s" % (
                        function.__name__, name, near and "; did you mean %r?" % near[0] or ""))
            return function(*arguments, **keywords)

        checked.__signature__ = signature.replace(parameters=own + [
            inspect.Parameter(row["keyword"], inspect.Parameter.KEYWORD_ONLY, default=_default(row)) for row in rows])
        checked.__doc__ = function.__doc__.replace("{settings}", "\n    ".join(
            textwrap.fill("%s: %s%s%s." % (row["keyword"], "/".join(row["words"]) + "; " if row["words"] else "", row["help"],
                                           _shown_default(row)), 116, subsequent_indent=8 * " ") for row in rows).lstrip())
        return checked
    return decorate


@_with_settings("mesh")
def sample(vertices, faces=None, n=2048, *, density="uniform", density_at=None, normals=None, colors=None, colors_at=None,
           attributes=None, attributes_at=None, topology=True, describe=(), content=None, check=True, threads=0, timeout=None,
           **settings):
    """Samples a mesh: exactly n points, as `meander run` places them.

    vertices: (V, 3) real numbers, any units; faces: (F, k) numbers of vertices, k >= 3 (polygons are triangulated).
        Or one object with both as attributes, a `Mesh` for example.
    n: points, 1 to 2^31.
    density: "uniform", "mean", "gaussian", "max" (curvature), "formula:TEXT" in x, y, z, nx, ny, nz, mean and gaussian
        ("unit-formula:TEXT" in lengths of the unit box), or numbers >= 0 at the V vertices or F faces
        (`density_at` says which where V = F), or a function from positions (k, 3) to k such numbers: it is called once,
        with all vertices, or with the middles of all faces for density_at="faces". Between vertices the density is linear,
        on a face it is constant. Points are distributed by area x density.
    {settings}
    normals: (V, 3), interpolated at the samples; without them normals are those of the triangles.
    colors: (V, 3) or (F, 3), uint8 or real numbers from 0 to 1, as displayed; NaN for none; a fourth column (alpha) is left
        out. `rgb` has them at the samples, between vertices interpolated. `colors_at` as density_at.
    attributes: a dict of numbers by name, (V,), (V, k), (F,) or (F, k), k from 1 to 4, NaN for none. `attributes` has them at
        the samples: real numbers of vertices interpolated, whole numbers as classes, those of the nearest corner of the
        triangle; of faces those of the face. `attributes_at` as density_at, for all of them.
    topology: with False triangles are taken as they are, which is faster: normals follow their winding, and components,
        genus and boundaries are 0 (methods "auto" and "direct" without curvature densities).
    describe: names of descriptors (see descriptor_names).
    content: 32 bytes (or 64 hexadecimal digits) that name the model. The points are a pure function of the mesh, the
        options and these. `content_of(file)` gives those of a file, and with them the points that `meander run` stores
        for it. By default a digest of vertices and faces, whatever the types of their arrays.
    check: ValueError for coordinates that are not finite and for vertices that are not there. With False such faces are
        dropped and counted in `repairs`, as those of files.
    threads: 0 for all of the machine; only large meshes use more than one. timeout: seconds, None for none.

    Returns Samples. Raises SamplingError when the mesh cannot be sampled (its `status` is that of stores), ValueError and
    TypeError for arguments that make no sense. Cost: 0.5 to 1 us a sample and a face; see the README.

        >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        >>> s = meander.sample(square, [[0, 1, 2, 3]], n=4096, density=[1, 4, 4, 1], density_at="vertices")
        >>> x = s.points[:, 0]
        >>> bool(abs(numpy.sum(s.weights * x * x) - 1 / 3) < 1e-3)    # the integral of x^2
        True
        >>> s = meander.sample(square, [[0, 1, 2, 3]], 64, density=lambda p: 1 + p[:, 0], attributes={"height": [0., 2, 2, 0]},
        ...                    colors=numpy.array([[0, 0, 0], [255, 0, 0], [255, 0, 0], [0, 0, 0]], "u1"))
        >>> bool(numpy.allclose(s.attributes["height"], 2 * s.points[:, 0], atol=1e-6))
        True
        >>> bool((s.rgb[:, 0] == numpy.round(255 * s.points[:, 0])).all())
        True
        >>> meander.sample([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
        Traceback (most recent call last):
            ...
        meander.SamplingError: zero_area: the 1 triangles have no area (at most 1e-14 of the diagonal squared)
    """
    options = dict(n=n, topology=topology, describe=_names(describe), **settings)
    if isinstance(vertices, Mesh) and faces is None:
        for name, value in (("normals", normals), ("content", content), ("colors", colors), ("attributes", attributes)):
            if value is not None:
                raise ValueError("%s are for arrays: a Mesh has its own%s" % (
                    name, "" if name in ("normals", "content") else ", which sample_file(path) takes over"))
        mesh, is_word = vertices, isinstance(density, str)
        options["density"], values, of_faces = _density(density, density_at, *(
            (None, None) if is_word else (mesh.vertices, mesh.faces)))
        if values is not None:
            mesh = mesh.with_density(values, of_faces)
        return _samples(_sampler(options).sample_mesh(mesh, threads, timeout, is_word))
    vertices, faces = _arrays(vertices, faces)
    if not isinstance(density, str) or colors is not None or attributes is not None:
        vertices, faces = numpy.asarray(vertices), numpy.asarray(faces)
    options["density"], values, of_faces = _density(density, density_at, vertices, faces)
    rgb, rgb_of_faces, table = None, False, ()
    if colors is not None:
        rgb, rgb_of_faces = _colors(colors, vertices, faces, colors_at)
        options["colors"] = True
    elif colors_at is not None:
        raise ValueError("colors_at applies to colors, which are not given")
    if attributes is not None:
        table = _attributes(attributes, vertices, faces, attributes_at)
        options["attributes"] = ["%s:%d%s" % (name, values.shape[1], ":class" if classes else "")
                                 for name, values, _, classes in table]
    elif attributes_at is not None:
        raise ValueError("attributes_at applies to attributes, which are not given")
    sampler = _sampler(options)
    _core._limits(threads, timeout)
    mesh = Mesh.of_arrays(vertices, faces, normals, values, of_faces, _content(content), check, rgb, rgb_of_faces, table)
    return _samples(sampler.sample_mesh(mesh, threads, timeout, False))


@_with_settings("file")
def sample_file(path, n=2048, *, density="uniform", density_at=None, describe=(), threads=0, timeout=None, **settings):
    """Samples one file: the row that `meander run path` stores, as Samples.

    path: a mesh of any format that `meander run` reads (docs/FORMATS.md), also MESH.gz and ARCHIVE/MEMBER. Of many members of
        one archive `run` is faster, which reads its list once.
    density: a word of `run --density`, with "attribute:NAME", "face-attribute:NAME", "texture" and formulas in u and v;
        numbers or a function as in sample.
    {settings}
    The others: see sample.

    Returns Samples with `rgb`, `texcoord` and `attributes` as asked for, and `notes` on what the file names and does not have.
    A model without any color has the fill 204 and the color_source "none"; one without an attribute has NaN there, or the
    class -1. Raises SamplingError with the status that a store would have, ValueError and TypeError for options that make no
    sense. A signal is looked for once the file is read.

        >>> with open("seat.ply", "w") as file:
        ...     _ = file.write("ply\\nformat ascii 1.0\\nelement vertex 3\\n"
        ...                    "property float x\\nproperty float y\\nproperty float z\\n"
        ...                    "property uchar red\\nproperty uchar green\\nproperty uchar blue\\n"
        ...                    "element face 1\\nproperty list uchar int vertex_indices\\nend_header\\n"
        ...                    "0 0 0 255 0 0\\n1 0 0 255 0 0\\n0 1 0 255 0 0\\n3 0 1 2\\n")
        >>> s = meander.sample_file("seat.ply", 64, colors=True)
        >>> s.rgb[0].tolist(), s.color_source
        ([255, 0, 0], 'vertex')
    """
    path, is_word = os.fspath(path), isinstance(density, str)
    options = dict(n=n, describe=_names(describe), **settings)
    options["density"] = _density(density, density_at, None, None)[0] if is_word else "vertices"
    sampler = _sampler(options, True, path)
    mesh = Mesh.read(path, sampler)
    if not is_word:
        options["density"], values, of_faces = _density(density, density_at, mesh.vertices, mesh.faces)
        mesh, sampler = mesh.with_density(values, of_faces), _sampler(options, True, path)
    return _samples(sampler.sample_mesh(mesh, threads, timeout, False))


@_with_settings("file")
def sample_many(meshes, n=2048, *, threads=0, errors="raise", density="uniform", density_at=None, describe=(), check=True,
                timeout=None, **settings):
    """Samples many meshes at a time, one a thread; large ones use idle threads too.

    meshes: any iterable (a generator too: only a few meshes for each thread are in memory) of (vertices, faces),
        (vertices, faces, content), objects with both, or paths of files, which are read by Meander.
    threads: 0 for all of the machine. timeout: seconds a mesh.
    errors: "raise" the error of a mesh in its place, which ends the iterator (`index` says which mesh), or "return": the
        iterator gives the exception in the place of the samples.
    density: a word, or a function as in sample, which is called from this thread for each mesh (`density_at` too).
    {settings}
    What is taken over from files (colors, attributes ...) is for paths alone; of attributes, NAME:class holds classes.
    The others: see sample.

    Returns an iterator of Samples in the order of the meshes, the same as those of sample() and sample_file(). It takes
    meshes, and samples some ahead, as its results are asked for: list(...) has all.

        >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        >>> meshes = [(square, [[0, 1, 2, 3]]), (square, [[0, 0, 0]])]
        >>> [type(s).__name__ for s in meander.sample_many(meshes, n=64, errors="return")]
        ['Samples', 'SamplingError']
    """
    if errors not in ("raise", "return"):
        raise ValueError("errors is %r: \"raise\" or \"return\"" % (errors,))
    function = None
    if callable(density):
        function, density = density, "faces" if density_at == "faces" else "vertices"
        _called(function, numpy.zeros((0, 3)), numpy.zeros((0, 3), int), density_at)  # checks density_at
    elif not isinstance(density, str) or density in ("vertices", "faces"):
        raise TypeError("the density of sample_many is a word or a function; give numbers to sample()")
    elif density_at is not None:
        raise ValueError("density_at applies to a density given as a function")
    _core._limits(threads, timeout)
    sampler = _sampler(dict(n=n, describe=_names(describe), density=density, **settings), True)
    taken = [name for name in _OF_FILES if settings.get(name)]

    def one(mesh):
        if isinstance(mesh, (str, os.PathLike)):
            mesh = Mesh.read(os.fspath(mesh), sampler)
            if function is None:
                return mesh
            return mesh.with_density(_called(function, mesh.vertices, mesh.faces, density_at), density == "faces")
        if isinstance(mesh, Mesh):
            raise TypeError("a Mesh cannot be sampled by sample_many, which takes it apart: give its path")
        if taken:
            raise TypeError("%s: taken over from files, not from arrays; sample() takes arrays of them" % ", ".join(taken))
        content = None
        if isinstance(mesh, (tuple, list)) and len(mesh) in (2, 3):
            content = mesh[2] if len(mesh) == 3 else None
            vertices, faces = mesh[0], mesh[1]
        else:
            vertices, faces = _arrays(mesh, None)
        values = None if function is None else _called(function, vertices, faces, density_at)
        return Mesh.of_arrays(vertices, faces, None, values, density == "faces", _content(content), check)

    def all_of_them():
        for mesh in meshes:
            try:
                yield one(mesh)
            except (SamplingError, OSError, ValueError, TypeError) as error:
                yield error

    def results():
        for index, result in enumerate(sampler.sample_many(all_of_them(), threads, timeout)):
            if isinstance(result, dict):
                yield _samples(result)
                continue
            if isinstance(result, SamplingError):
                result = SamplingError(result.status, result.reason, index)
            else:
                result.index = index
            if errors == "raise":
                raise result
            yield result

    return results()


@_with_settings("run")
def run(inputs, store, *, progress=None, **options):
    """Samples files, folders and archives into a store: `meander run`, with the same store, to the byte, and the same resume.

    inputs: a path or a list of paths: mesh files, folders, archives, "@list.txt". store: the path of the store (HDF5).
    progress: a function, called as progress(done, total, item) from this thread after each model. done, total: models of this
        call. item: a dict with id, status, reason, vertices, faces, seconds and more, as `run --progress json` prints it.
    The options are those of the program, by its names with _ for -: numbers, texts ("4G", "90s"; numbers alone are bytes and
    seconds), lists of them, True for options without a value. What is left out has the program's default:

    {settings}

    The work is done by the program beside this package, in a process of its own: it may be killed at any time, and the same
    call continues. An exception, of `progress` or Ctrl-C, stops it first; what is finished is kept.

    Returns RunResult. Models that fail do not raise: `failed` lists them. Raises ValueError where the options or the inputs
    make no sense, or the store is another run's; RunStopped where the run stopped early; RuntimeError for a bug in Meander,
    and where the program is missing. Cost: as `meander run`, and some 20 ms.

        >>> import os
        >>> os.makedirs("shapes", exist_ok=True)
        >>> with open("shapes/square.off", "w") as file:
        ...     _ = file.write("OFF\\n4 1 0\\n0 0 0\\n1 0 0\\n1 1 0\\n0 1 0\\n4 0 1 2 3\\n")
        >>> def show(done, total, item):
        ...     print("%d of %d: %s is %s" % (done, total, item["id"], item["status"]))
        >>> meander.run("shapes", "shapes.h5", n=256, progress=show)
        1 of 1: square.off is ok
        <meander.RunResult shapes.h5: 1 rows, 1 ok, 0 failed>
        >>> meander.run("shapes", "shapes.h5", n=256).done_now
        0
        >>> meander.run("shapes", "shapes.h5", n=128)
        Traceback (most recent call last):
            ...
        ValueError: `shapes.h5` was made with other parameters: parameter "samples" was 256, now it is 128 (--fresh replaces \
it, or choose another name)
    """
    paths = [os.fspath(path) for path in ([inputs] if isinstance(inputs, (str, os.PathLike)) else inputs)]
    for path in paths:
        if path.startswith("-"):
            raise ValueError("the input %r begins with a minus: give it as ./%s" % (path, path))
    words = [word for row in _core.settings("run") if row["keyword"] in options
             for word in _program.arguments_of(row, options[row["keyword"]])]
    return _program.run([*words, "--output=" + os.fspath(store), *paths], progress)


def describe(vertices, faces=None, descriptors="pairs", *, n=1024, seed=1, bins=32, content=None, check=True, threads=0,
             timeout=None):
    """Shape descriptors of a mesh: a dict from name to float32 values, as `meander run --describe` stores them.

    descriptors: a list or "d2,pairs"; see descriptor_names. n: samples that they are made from. bins: of histograms.
    The others, and the errors: see sample.

        >>> cube = numpy.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        >>> quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        >>> d = meander.describe(cube, quads, "d2,basics")
        >>> d["d2"].shape, bool(numpy.isclose(d["d2"].sum(), 1, atol=1e-5))
        ((32,), True)
    """
    return sample(vertices, faces, n, seed=seed, describe=descriptors, bins=bins, content=content, check=check,
                  threads=threads, timeout=timeout).descriptors


def measure(points, vertices, faces=None, *, boxes=1000, seed=1, modes=0):
    """How evenly any points lie on a mesh: those of Meander, or of any other sampler.

    points: (n, 3) real numbers, n >= 2, in the coordinates of the mesh (Samples.coordinates()), of uniform density.
    vertices, faces: as in sample, or a Mesh. boxes: 1 to 200,000; seed: of the boxes and of the reference points.
    modes: 0 to 1,000; where it is not 0, "modes" is the error of the integrals of as many lowest eigenfunctions of the
        Laplacian, relative to random points; 30 take a second on 17,000 vertices.

    Returns a dict of numbers: "boxes", the error of the share of points in random rotated boxes, relative to random points
    (1: as random ones; smaller is better); "limit", the least such error that is known to be possible for as many points on
    this surface, and "over_limit", the error over it (1 at best); "rho", the least distance of two points over that of a
    hexagonal lattice of as many (0: random, 0.65 to 0.85: Poisson disk; larger is better); in units of the mesh "least" and
    "mean", distances to the nearest other point, straight through space, and "coverage", the largest distance from the surface
    to a point (smaller is better); "hole" and "chamfer", the largest and the mean distance from the surface to the points over
    those of the plane to a hexagonal lattice (1 is its optimum). The same as `meander measure boxes`, `spacing` and
    `modes`. Raises SamplingError for a mesh without area, ValueError for points that are not finite, RuntimeError in a build
    without the laboratory. Cost: half a second for 1,000 boxes on 100,000 triangles; the other measures 10 to 30 us a point.

        >>> cube = numpy.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        >>> quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        >>> spaced = meander.measure(meander.sample(cube, quads, 1000, sequence="spaced").points, cube, quads)
        >>> random = meander.measure(meander.sample(cube, quads, 1000, sequence="random").points, cube, quads)
        >>> spaced["boxes"] < 0.5 < random["boxes"], spaced["rho"] > 0.5 > random["rho"]
        (True, True)
    """
    if isinstance(vertices, Mesh) and faces is None:
        return _core.measure(points, vertices, boxes, seed, modes)
    vertices, faces = _arrays(vertices, faces)
    return _core.measure(points, Mesh.of_arrays(vertices, faces, content=b"\0" * 32), boxes, seed, modes)


class RemeshedMesh:
    """A mesh whose first vertices are samples of a surface.

    vertices: (V, 3) float64: the n samples in their order, then others on boundaries, on creases, and where the topology needs
    them. faces: (F, 3) uint32 triangles, oriented as the surface. samples: n. report: a dict of numbers (docs/REMESH.md):
    vertices, faces, components, boundary_loops, euler, line_vertices, kept_vertices, dropped_components, crossings ...
    """

    def __init__(self, vertices, faces, samples, report):
        self.vertices, self.faces, self.samples, self.report = vertices, faces, samples, report

    def __repr__(self):
        return "<meander.RemeshedMesh of %d vertices and %d faces>" % (len(self.vertices), len(self.faces))


@_with_settings("remesh", "mesh", without=("normalize", "curved", "topology", "describe", "bins",
                                          *(row["keyword"] for row in _core.settings("training"))))
def remesh(vertices, faces=None, n=2048, *, sequence="spaced", density="uniform", density_at=None, content=None, check=True,
           threads=0, timeout=None, **settings):
    """A mesh of n vertices that are samples of a surface, with its topology: `meander remesh` over arrays.

    vertices, faces: as in sample, or a Mesh. n: samples, 1 to 2^31; the mesh has a few more vertices. sequence: as in sample;
        samples that keep their distance make better triangles. density: a word, numbers or a function, as in sample.
    {settings}
    The others: see sample.

    Returns RemeshedMesh, in the coordinates of the mesh. Colors and attributes of the samples are those of sample(...) with
    the same options: the first n vertices. Raises SamplingError when the mesh cannot be sampled, ValueError and TypeError for
    arguments that make no sense. A signal is looked for at the end. Cost: that of sampling, and about 2 us a vertex of the
    surface and 1 us a sample.

        >>> t, p = numpy.meshgrid(numpy.arange(48), numpy.arange(24), indexing="ij")
        >>> a, b = 2 * numpy.pi * t / 48, 2 * numpy.pi * p / 24
        >>> torus = numpy.stack([(2 + numpy.cos(b)) * numpy.cos(a), (2 + numpy.cos(b)) * numpy.sin(a), numpy.sin(b)], -1)
        >>> at = lambda i, j: 24 * (i % 48) + j % 24
        >>> quads = numpy.stack([at(t, p), at(t + 1, p), at(t + 1, p + 1), at(t, p + 1)], -1).reshape(-1, 4)
        >>> coarse = meander.remesh(torus.reshape(-1, 3), quads, 500)
        >>> coarse.report["euler"], len(coarse.vertices), len(coarse.faces)
        (0, 500, 1000)
    """
    lines = {row["keyword"] for row in _core.settings("remesh")}
    given = {name: settings.pop(name) for name in lines.intersection(settings)}
    options = dict(n=operator.index(n), sequence=sequence, **settings)
    for name in _WHOLE.intersection(options):
        options[name] = operator.index(options[name])
    if isinstance(vertices, Mesh) and faces is None:
        if content is not None:
            raise ValueError("content is for arrays: a Mesh has its own")
        mesh, places = vertices, (None, None) if isinstance(density, str) else (vertices.vertices, vertices.faces)
        options["density"], values, of_faces = _density(density, density_at, *places)
        if values is not None:
            mesh = mesh.with_density(values, of_faces)
    else:
        vertices, faces = (numpy.asarray(array) for array in _arrays(vertices, faces))
        options["density"], values, of_faces = _density(density, density_at, vertices, faces)
        mesh = Mesh.of_arrays(vertices, faces, None, values, of_faces, _content(content), check)
    made = _core.remesh(mesh, mesh.content, options, given, threads, timeout)
    report = {name[7:]: value if name in ("report_dropped_share", "report_largest_shift") else int(value)
              for name, value in vars(made).items() if name.startswith("report_")}
    return RemeshedMesh(made.vertices, made.faces, options["n"], report)


@dataclasses.dataclass(eq=False, repr=False)
class SignedDistances:
    """How far n points are from a surface, and on which side."""
    distance: numpy.ndarray     # (n,) float64, in units of the mesh: negative inside; not negative where sign is "none"
    face_index: numpy.ndarray   # (n,) uint32, the nearest face; the lowest number where several are equally near
    corners: numpy.ndarray      # (n, 3) uint32, vertices of the nearest triangle
    barycentric: numpy.ndarray  # (n, 2) float64, weights of the second and the third corner at the nearest point
    inside: numpy.ndarray       # (n,) bool
    certain: numpy.ndarray      # (n,) bool: False where the side may be the other one, everywhere where sign is "none"
    winding: numpy.ndarray      # (n,) float64, the winding number that tells the side; None of the other rules
    sign: str                   # the rule that sides are told by: "closed", "winding", "shell" or "none"
    open_edges: int             # edges that no other triangle closes; 0 of a closed surface

    def __len__(self):
        return len(self.distance)

    def __repr__(self):
        return "<meander.SignedDistances: %d points, sign %s, %d uncertain>" % (len(self), self.sign, (~self.certain).sum())

    def interpolate(self, values):
        """Values at the vertices, (V,) or (V, k), at the nearest points: those points themselves of the vertices."""
        return _between(values, self.corners, self.barycentric)


def _mesh(vertices, faces, check):
    if isinstance(vertices, Mesh) and faces is None:
        return vertices
    vertices, faces = _arrays(vertices, faces)
    return Mesh.of_arrays(vertices, faces, content=b"\0" * 32, check=check)


def signed_distance(vertices, faces=None, points=None, *, sign="auto", check=True, threads=0, timeout=None):
    """The exact distances of points from a mesh, negative inside, with the nearest faces and how certain each side is.

    vertices, faces: as in sample, or a Mesh. points: (n, 3) real numbers in the coordinates of the mesh.
    sign: the rule that sides are told by. "closed": every component is closed; inside is where the surface winds around the
        point. "winding": the surface is nearly closed; inside is where the generalized winding number (Jacobson et al. 2013) is
        at least one half, uncertain within 0.35 of that, and beside open edges. "shell": for any triangles; inside is what
        cannot be reached from outside but through gaps narrower than 1/124 of the longest side, cavities included; uncertain
        in walls and gaps thinner than that. "none": distances have no sign. "auto": the first of the others that suits the
        surface, `sign` of the result says which.
    check, threads, timeout: as in sample.

    For winding numbers components are turned first: outward, unless they lie inside another closed one that is wound the other way (cavities).
    Components that overlap are one solid; faces that are there twice count once, however they are wound. So the winding of
    the file need not be right.

    Returns SignedDistances. Raises SamplingError for a mesh without area, ValueError where sign="closed" and the surface is not,
    and for points that are not finite. A signal is looked for at the end. Cost: on 25,000 triangles, one core, 1 us a point near
    the surface and 2 us a point in its box; and 1.5 us a triangle.

        >>> cube = numpy.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        >>> quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        >>> found = meander.signed_distance(cube, quads, [[0.5, 0.5, 0.75], [2, 0.5, 0.5], [2, 2, 1]])
        >>> found, found.distance.round(6).tolist(), found.face_index.tolist()
        (<meander.SignedDistances: 3 points, sign closed, 0 uncertain>, [-0.25, 1.0, 1.414214], [5, 1, 1])
        >>> found.interpolate(cube).tolist()                                    # the nearest points
        [[0.5, 0.5, 1.0], [1.0, 0.5, 0.5], [1.0, 1.0, 1.0]]
        >>> sheets = meander.signed_distance(cube, quads[:2], [[0.5, 0.5, 0.75]])       # two of them are open to all sides
        >>> sheets, sheets.distance.tolist()
        (<meander.SignedDistances: 1 points, sign shell, 0 uncertain>, [0.5])
    """
    return SignedDistances(**_core.signed_distance(_mesh(vertices, faces, check), points, sign, threads, timeout))


def winding_number(vertices, faces=None, points=None, *, error=0.05, check=True, threads=0, timeout=None):
    """The generalized winding number of a mesh around points, (n,) float64: 1 inside of a closed surface that is wound outward.

    vertices, faces: as in sample, or a Mesh; as they are wound and with all copies, other than in signed_distance.
    points: (n, 3) real numbers in the coordinates of the mesh. error: the largest error, which is certain; the largest that was
        seen on real models is 400 times smaller. 0: the sum over all triangles. check, threads, timeout: as in sample.

    Jacobson et al. 2013 by the tree of Barill et al. 2018. Raises SamplingError for a mesh without area, ValueError for points
    that are not finite. A signal is looked for at the end. Cost: on 25,000 triangles, one core, 2 to 10 us a point, more near
    the surface and with smaller errors; 40 ns a point and triangle with error=0.

        >>> cube = numpy.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)])
        >>> quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
        >>> points = [[0.5, 0.5, 0.5], [0.5, 0.5, 0.75]]
        >>> meander.winding_number(cube, quads, points).round(2).tolist()
        [1.0, 1.0]
        >>> meander.winding_number(cube, quads[:5], points, error=0).round(6).tolist()   # one of six sides is missing
        [0.833333, 0.704833]
    """
    return _core.winding_number(_mesh(vertices, faces, check), points, error, threads, timeout)


def measure_boxes(points, vertices, faces=None, *, boxes=1000, seed=1):
    """The error of any points on a mesh over random rotated boxes, relative to random points: smaller is better.

    points: (n, 3) in the coordinates of the mesh (Samples.coordinates()), of uniform density.

    Returns a BoxError, a float with two attributes: limit, the least error that is known to be possible for as many points on
    this surface, and over_limit, the error over it. As `meander measure boxes`. Raises SamplingError for a mesh without area,
    RuntimeError in a build without the laboratory.
    """
    if isinstance(vertices, Mesh) and faces is None:
        return _core.measure_boxes(points, vertices, boxes, seed)
    vertices, faces = _arrays(vertices, faces)
    return _core.measure_boxes(points, Mesh.of_arrays(vertices, faces, content=b"\0" * 32), boxes, seed)


@_with_settings("surface")
def surface(shape, n=2048, *, tolerance=1e-3, content=None, threads=0, timeout=None, **settings):
    """Samples a parametric surface over the unit square.

    shape: a name of surface_names(), three formulas for x, y and z in u and v as "u, v, sin(6*u)", a .nurbs or .png
        file (see `meander surface`), or a function of two arrays u, v of k
        numbers in [0, 1] that returns positions (k, 3), or a tuple of three arrays. A function is called again and again
        from this thread, with up to some 100,000 parameters; its derivatives are differences.
    tolerance: relative error of the measures. content: of a function; by default a digest of a grid of its values.
    {settings}

    Returns Samples with `uv` instead of faces, corners and weights of corners; errors as in sample.

        >>> def cylinder(u, v):
        ...     return numpy.cos(2 * numpy.pi * u), numpy.sin(2 * numpy.pi * u), 2 * v
        >>> bool(abs(meander.surface(cylinder, n=512).area - 4 * numpy.pi) < 1e-3)
        True
        >>> meander.surface("torus", n=512).uv.shape
        (512, 2)
    """
    options = dict(n=n, **settings)
    if callable(shape):
        return _samples(_core.sample_callable_surface(shape, tolerance, timeout, _content(content), **options))
    if content is not None:
        raise ValueError("content is for functions: a named surface has its own")
    return _samples(_core.sample_named_surface(os.fspath(shape), tolerance, threads, timeout, **options))


def write_points(path, points, *, normals=None, colors=None):
    """Writes points as a file that other programs show: .ply, .off or .xyz by its ending, as `meander export` writes it.

    points: Samples, with what PLY has a place for (normals, colors, face_index, density), in the coordinates of the mesh; or
        (n, 3) real numbers, which are kept to a float32 of their distance from the middle of their box.
    normals: (n, 3); colors: (n, 3) uint8, or real numbers from 0 to 1. Both in place of those of Samples.

    A file of this name is replaced, once the new one is whole. An .off file has the positions alone, an .xyz file normals too,
    which it needs. Raises ValueError for another ending and for arrays that do not fit, OSError where it cannot be written.

        >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        >>> samples = meander.sample(square, [[0, 1, 2, 3]], n=64)
        >>> meander.write_points("square.ply", samples, colors=numpy.abs(samples.points))
        >>> print(open("square.ply", "rb").read().split(b"end_header")[0].decode())
        ply
        format binary_little_endian 1.0
        comment frame file
        element vertex 64
        property double x
        property double y
        property double z
        property float nx
        property float ny
        property float nz
        property uint face
        property float density
        property uchar red
        property uchar green
        property uchar blue
        <BLANKLINE>
    """
    if isinstance(points, Samples):
        arrays = {row["array"]: getattr(points, row["array"]) for row in _core.columns()}
        arrays = {name: values for name, values in arrays.items() if values is not None}
        frame = [*points.loc, points.scale]
    else:
        places = _core._reals(points, "points", 3)
        if len(places) == 0 or not numpy.isfinite(places).all():
            raise ValueError("points must be one or more, and finite")
        middle = (places.min(axis=0) + places.max(axis=0)) / 2
        arrays, frame = {"points": places - middle}, [*middle, 1]
    if normals is not None:
        arrays["normals"] = _core._reals(normals, "normals", 3)
    if colors is not None:
        n = len(arrays["points"])
        rgb, _ = _colors(colors, range(n), (), "vertices")
        arrays["rgb"] = numpy.round(255 * rgb)
    _core.write_points(path, frame, arrays)


def surface_names():
    """Names of analytic surfaces.

        >>> "torus" in meander.surface_names()
        True
    """
    return _core.surface_names()


def descriptor_names():
    """Names of descriptors.

        >>> "pairs" in meander.descriptor_names()
        True
    """
    return _core.descriptor_names()


def read_mesh(path):
    """A file of any format that `meander run` reads (docs/FORMATS.md), also MESH.gz and ARCHIVE/MEMBER, as a Mesh.

    A Mesh has `vertices` (V, 3) float64, `faces` (F, k) uint32 (None for polygons of different sizes) and `content`. It has
    the file's normals and attributes too: sample(read_mesh(path)) gives the points that `meander run path` stores.
    Raises SamplingError with the status that a store would have.
    """
    return Mesh.read(os.fspath(path))


def content_of(path):
    """The content of a model's file, 32 bytes: what its random numbers are keyed by in a store (items/content_sha256)."""
    return Mesh.read(os.fspath(path)).content
