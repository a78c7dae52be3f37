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

from . import _core
from ._core import SamplingError, __version__
from .store import Store, StoreDataset, open_store

__all__ = ["Mesh", "Samples", "SamplingError", "Store", "StoreDataset", "content_of", "describe", "descriptor_names",
           "measure_boxes", "open_store", "read_mesh", "sample", "sample_many", "surface", "surface_names"]

Mesh = _core.Mesh
Mesh.__module__ = SamplingError.__module__ = "meander"


def _with_columns(cls):
    """The class with a field, and a line of the docstring, for each column of samples."""
    rows = [row for row in _core.columns() if row["in_python"]]
    cls.__annotations__ = {**{row["array"]: numpy.ndarray for row in rows}, **cls.__annotations__}
    lines = ["%s: (n%s) %s, %s%s" % (row["array"], ", %d" % row["width"] if row["width"] else ",", numpy.dtype(row["type"]),
                                     row["doc"], "" if row["always"] else "; None of other samples") for row in rows]
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
        at = numpy.asarray(values, dtype=numpy.float64)[self.corners]
        b = self.barycentric.astype(numpy.float64)
        share = numpy.stack([1 - b[:, 0] - b[:, 1], b[:, 0], b[:, 1]], axis=1)
        return numpy.einsum("nc,nc...->n...", share, at)


def _samples(members):
    """Samples of the members that the core gives, all that there are; the constructor would copy them one by one."""
    made = Samples.__new__(Samples)
    made.__dict__ = members
    return made


@functools.lru_cache(maxsize=32)
def _sampler_of(options):
    return _core.Sampler(**dict(options))


_WHOLE = {row["keyword"] for row in _core.settings("mesh") if row["type"] == "int"}


def _sampler(options):
    """The one with these options: those that cast rays take a moment to make."""
    for name in _WHOLE.intersection(options):
        options[name] = operator.index(options[name])
    return _sampler_of(tuple(options.items()))


def _names(describe):
    return tuple(describe.split(",")) if isinstance(describe, str) else tuple(describe)


def _density_is_of_faces(values, vertices, faces, at):
    if values.ndim != 1:
        raise ValueError("density must be a word or have the shape (V,) or (F,), not %s" % (values.shape,))
    if at not in (None, "vertices", "faces"):
        raise ValueError("density_at is %r: \"vertices\" or \"faces\"" % (at,))
    if at is not None:
        return at == "faces"
    if len(vertices) == len(faces) == len(values):
        raise ValueError("there are as many vertices as faces: say density_at=\"vertices\" or \"faces\"")
    if len(values) == len(vertices):
        return False
    if len(values) == len(faces):
        return True
    raise ValueError("density has %d values: there are %d vertices and %d faces"
                     % (len(values), len(vertices), len(faces)))


def _content(content):
    if content is None:
        return None
    if isinstance(content, str):
        content = bytes.fromhex(content)
    return bytes(content)


def _arrays(vertices, faces):
    """Two arrays, or one object that has both (trimesh, Open3D-like)."""
    if faces is None:
        mesh = vertices
        if not hasattr(mesh, "vertices") or not hasattr(mesh, "faces"):
            raise TypeError("faces are missing (or an object with `vertices` and `faces`)")
        vertices, faces = mesh.vertices, mesh.faces
    return vertices, faces


def _with_settings(kind):
    """Gives a function with **settings those of the library: in its signature, and in its docstring at {settings}."""
    def decorate(function):
        signature = inspect.signature(function)
        own = [p for p in signature.parameters.values() if p.kind is not p.VAR_KEYWORD]
        rows = [row for row in _core.settings(kind) if row["keyword"] not in signature.parameters]
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
            inspect.Parameter(row["keyword"], inspect.Parameter.KEYWORD_ONLY, 
                              default=float(row["default"]) if row["type"] == "float" else row["default"])
            for row in rows])
        checked.__doc__ = function.__doc__.replace("{settings}", "\n    ".join(
            textwrap.fill("%s: %s%s." % (row["keyword"], "/".join(row["words"]) + "; " if row["words"] else "", row["help"]),
                          116, subsequent_indent=8 * " ") for row in rows).lstrip())
        return checked
    return decorate


@_with_settings("mesh")
def sample(vertices, faces=None, n=2048, *, density="uniform", density_at=None, normals=None, topology=True, describe=(),
           content=None, check=True, threads=0, timeout=None, **settings):
    """Samples a mesh: exactly n points, as `meander run` places them.

    vertices: (V, 3) real numbers, any units; faces: (F, k) numbers of vertices, k >= 3 (polygons are triangulated).
        Or one object with both as attributes, a `Mesh` for example.
    n: points, 1 to 2^31.
    density: "uniform", "mean", "gaussian", "max" (curvature), "formula:TEXT" in x, y, z, nx, ny, nz, mean and gaussian
        ("unit-formula:TEXT" in lengths of the unit box), or numbers >= 0 at the V vertices or F faces
        (`density_at` says which where V = F). Points are distributed by area x density.
    {settings}
    normals: (V, 3), interpolated at the samples; without them normals are those of the triangles.
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
        >>> meander.sample([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])
        Traceback (most recent call last):
            ...
        meander.SamplingError: zero_area: the 1 triangles have no area (at most 1e-14 of the diagonal squared)
    """
    options = dict(n=n, topology=topology, describe=_names(describe), **settings)
    values = None if isinstance(density, str) else numpy.asarray(density)
    if isinstance(vertices, Mesh) and faces is None:
        if normals is not None or content is not None or values is not None:
            raise ValueError("a Mesh has its normals and its content, and its density is a word")
        options["density"] = density
        return _samples(_sampler(options).sample_mesh(vertices, threads, timeout))
    vertices, faces = _arrays(vertices, faces)
    of_faces = False
    if values is not None:
        vertices, faces = numpy.asarray(vertices), numpy.asarray(faces)
        of_faces = _density_is_of_faces(values, vertices, faces, density_at)
        density = "faces" if of_faces else "vertices"
    elif density_at is not None:
        raise ValueError("density_at applies to a density given as numbers")
    elif density in ("vertices", "faces"):
        raise ValueError("density is %r: give the numbers themselves" % density)
    options["density"] = density
    return _samples(_sampler(options).sample_arrays(
        vertices, faces, normals, values, of_faces, _content(content), check, threads, timeout))


@_with_settings("mesh")
def sample_many(meshes, n=2048, *, threads=0, errors="raise", density="uniform", describe=(), check=True, timeout=None,
                **settings):
    """Samples many meshes at a time, one a thread; large ones use idle threads too.

    meshes: any iterable (a generator too: only a few meshes are in memory beside their arrays) of (vertices, faces),
        (vertices, faces, content), objects with both, or paths of files, which are read by Meander.
    threads: 0 for all of the machine. timeout: seconds a mesh.
    errors: "raise" the first one when all others are done (`index` says which mesh; `results` has the others), or
        "return": the list has the exception in the place of the samples.
    The others: see sample; the density is a word.

    Returns a list of Samples in the order of the meshes, the same as those of sample().

        >>> square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        >>> meshes = [(square, [[0, 1, 2, 3]]), (square, [[0, 0, 0]])]
        >>> [type(s).__name__ for s in meander.sample_many(meshes, n=64, errors="return")]
        ['Samples', 'SamplingError']
    """
    if errors not in ("raise", "return"):
        raise ValueError("errors is %r: \"raise\" or \"return\"" % (errors,))
    if not isinstance(density, str) or density in ("vertices", "faces"):
        raise TypeError("the density of sample_many is a word; give numbers to sample()")
    sampler = _sampler(dict(n=n, describe=_names(describe), density=density, **settings))

    def one(mesh):
        if isinstance(mesh, (str, os.PathLike)):
            return Mesh.read(os.fspath(mesh))
        if isinstance(mesh, Mesh):
            raise TypeError("a Mesh cannot be sampled by sample_many, which takes it apart: give its path")
        content = None
        if isinstance(mesh, (tuple, list)) and len(mesh) in (2, 3):
            content = mesh[2] if len(mesh) == 3 else None
            vertices, faces = mesh[0], mesh[1]
        else:
            vertices, faces = _arrays(mesh, None)
        return Mesh.of_arrays(vertices, faces, None, None, False, _content(content), check)

    def all_of_them():
        for mesh in meshes:
            try:
                yield one(mesh)
            except (SamplingError, OSError, ValueError, TypeError) as error:
                yield error

    results = sampler.sample_many(all_of_them(), threads, timeout)
    first = None
    for index, result in enumerate(results):
        if isinstance(result, dict):
            results[index] = _samples(result)
            continue
        if isinstance(result, SamplingError):
            results[index] = SamplingError(result.status, result.reason, index)
        else:
            results[index].index = index
        first = first or results[index]
    if first is not None and errors == "raise":
        first.results = results
        raise first
    return results


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


def measure_boxes(points, vertices, faces=None, *, boxes=1000, seed=1):
    """The error of any points on a mesh over random rotated boxes, relative to random points: smaller is better.

    points: (n, 3) in the coordinates of the mesh (Samples.coordinates()), of uniform density. As `meander measure boxes`.
    Raises SamplingError for a mesh without area, RuntimeError in a build without the laboratory.
    """
    if isinstance(vertices, Mesh) and faces is None:
        return _core.measure_boxes(points, vertices, boxes, seed)
    vertices, faces = _arrays(vertices, faces)
    return _core.measure_boxes(points, Mesh.of_arrays(vertices, faces, None, None, False, b"\0" * 32, True), boxes, seed)


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
