"""The library libmeander.so (jobs/python/interface.h), as the objects and functions that the package is made of.

ctypes releases the interpreter's lock for every call. Long work is looked at from time to time, so that handlers of signals
run meanwhile.
"""
import ctypes
import functools
import json
import math
import operator
import os
import sys

import numpy

_POINTER, _TEXT, _INT, _COUNT, _REAL = (ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_uint64,
                                        ctypes.c_double)
_FUNCTION = ctypes.CFUNCTYPE(_INT, _POINTER, _COUNT, _POINTER, _POINTER, _POINTER)
_PATIENCE = 50  # milliseconds until signals are looked for


class _Attribute(ctypes.Structure):
    _fields_ = [("name", _TEXT), ("values", _POINTER), ("width", _COUNT), ("of_faces", ctypes.c_int32),
                ("classes", ctypes.c_int32)]


class _Arrays(ctypes.Structure):
    _fields_ = [("vertices", _POINTER), ("vertex_count", _COUNT), ("faces", _POINTER), ("face_count", _COUNT),
                ("width", _COUNT), ("corner_bytes", ctypes.c_int32), ("corners_are_signed", ctypes.c_int32),
                ("normals", _POINTER), ("density", _POINTER), ("content", _TEXT),
                ("density_of_faces", ctypes.c_int32), ("check", ctypes.c_int32), ("colors", _POINTER),
                ("colors_of_faces", ctypes.c_int32), ("attributes", ctypes.POINTER(_Attribute)),
                ("attribute_count", _COUNT)]


class _Given(ctypes.Structure):
    _fields_ = [("name", _TEXT), ("values", _POINTER), ("type", ctypes.c_char), ("rows", _COUNT), ("columns", _COUNT)]


def _load(path):
    library = ctypes.CDLL(path)
    for name, result, *arguments in (
            ("about", _TEXT), ("error", _TEXT), ("release", None, _POINTER), ("sampler", _POINTER, _TEXT, _INT, _TEXT),
            ("mesh_of_file", _POINTER, _TEXT, _POINTER), ("mesh_of_arrays", _POINTER, ctypes.POINTER(_Arrays)),
            ("mesh_with_density", _POINTER, _POINTER, _POINTER, _COUNT, _INT),
            ("text", _TEXT, _POINTER), ("work", _POINTER),
            ("sample", _INT, _POINTER, _POINTER, _POINTER, _INT, _REAL, _INT),
            ("sample_surface", _INT, _POINTER, _TEXT, _TEXT, _REAL, _INT, _REAL),
            ("sample_function", _INT, _POINTER, _FUNCTION, _POINTER, _TEXT, _TEXT, _REAL, _REAL),
            ("sample_many", _INT, _POINTER, _POINTER, _INT, _REAL),
            ("offer", _INT, _POINTER, _COUNT, _POINTER, _INT), ("close", _INT, _POINTER), ("wait", _INT, _POINTER, _INT),
            ("row", _INT, _POINTER, ctypes.POINTER(_POINTER), ctypes.POINTER(_COUNT), _INT),
            ("call", _POINTER, _TEXT, _TEXT, ctypes.POINTER(_Given), _COUNT, _POINTER)):
        function = getattr(library, "meander_" + name)
        function.restype, function.argtypes = result, arguments
    return library


_library = _load(os.path.join(os.path.dirname(__file__), "libmeander.so"))


class SamplingError(RuntimeError):
    """A mesh or surface that cannot be sampled.

    status: the word that a store has for it (`empty`, `zero_area`, `non_finite`, `timeout` ...).
    reason: one sentence that says what is wrong and where.
    index: the number of the mesh in sample_many, None elsewhere.
    """

    def __init__(self, status, reason, index=None):
        super().__init__(status, reason, index)
        self.status, self.reason, self.index = status, reason, index

    def __str__(self):
        where = "" if self.index is None else "mesh %d: " % self.index
        return "%s%s: %s" % (where, self.status, self.reason)


class _OptionRefused(Exception):
    pass


def _raise_error():
    error = json.loads(_library.meander_error() or b'{"kind": "memory", "text": ""}')
    kind, text = error["kind"], error["text"]
    if kind == "sampling":
        raise SamplingError(error["status"], text)
    raise {"value": ValueError, "option": _OptionRefused, "system": OSError, "memory": MemoryError}.get(
        kind, RuntimeError)(text)


def _checked(result):
    """What a function of the library returned, or what went wrong in it."""
    if result is None or result < 0:
        _raise_error()
    return result


class _Object:
    """Owns an object of the library, which takes this one in its place."""
    __slots__ = ("_as_parameter_",)

    def _own(self, pointer):
        self._as_parameter_ = _POINTER(_checked(pointer))
        return self

    def __del__(self, release=_library.meander_release):
        pointer = getattr(self, "_as_parameter_", None)
        if pointer is not None:
            self._as_parameter_ = None
            release(pointer)

    def __reduce__(self):
        raise TypeError("cannot pickle %r object" % type(self).__name__)


class _Memory(ctypes.c_char * sys.maxsize):
    """From some address on, as what arrays are views of: keeps the owner of the arrays alive."""


def _memory(address, owner):
    memory = _Memory.from_address(address)
    memory.owner = owner
    return memory


def _arrays(places, owner):
    """The arrays that the library says are there, by name."""
    lowest = min((place[0] for place in places.values() if place and place[2]), default=0)
    memory = _memory(lowest, owner)
    return {name: place and numpy.ndarray(place[2:], place[1], memory, place[0] - lowest if place[2] else 0)
            for name, place in places.items()}


def _told(text):
    if text is None:
        _raise_error()
    return json.loads(text.decode())


def _about():
    return _told(_library.meander_about())


# ---- arguments

def _plain(value):
    """An option as JSON can have it; {}, which no option takes, for all else."""
    if isinstance(value, numpy.generic):
        value = value.item()
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, tuple) and all(isinstance(name, str) for name in value):
        return ",".join(value)
    if isinstance(value, int) and not -2 ** 63 <= value < 2 ** 64:
        return {}
    return value if isinstance(value, (str, int, float, type(None))) else {}


def _with_options(call, options):
    """What call(JSON) returns; names the option that it refuses."""
    try:
        return call(json.dumps({name: _plain(value) for name, value in options.items()}).encode())
    except _OptionRefused as refused:
        name, = refused.args
        value = options[name]
    if isinstance(value, (int, float)):
        raise ValueError("%s cannot be %s" % (name, value))
    raise TypeError("%s cannot be %r" % (name, value))


def _real(number, name):
    try:
        return float(number + 0.0)  # float alone would read texts
    except TypeError:
        raise TypeError("%s cannot be %r" % (name, number)) from None


def _limits(threads, timeout):
    threads = operator.index(threads)
    if not 0 <= threads <= 1024:
        raise ValueError("threads is %d: 0 (all of the machine) to 1024" % threads)
    if timeout is None:
        return threads, 0.0
    timeout = _real(timeout, "timeout")
    if not 0 < timeout <= 1e9:
        raise ValueError("timeout is %s: seconds above 0, to 1e9" % repr(timeout).removesuffix(".0"))
    return threads, timeout


def _any_array(values, name):
    if values is None:
        raise TypeError("%s is None: an array is needed" % name)
    try:
        return numpy.asarray(values)
    except Exception:
        raise TypeError("%s is no array of numbers" % name) from None


def _reals(values, name, columns):
    """(n, 3) real numbers as doubles where `columns` is 3, (n,) where it is 0."""
    array = _any_array(values, name)
    if array.dtype.kind not in "fiu":
        raise TypeError("%s must be real numbers, not %s" % (name, array.dtype))
    if not (array.ndim == 2 and array.shape[1] == columns if columns else array.ndim == 1):
        raise ValueError("%s must have the shape %s, not %s" % (name, "(n, 3)" if columns else "(n,)", array.shape))
    return numpy.ascontiguousarray(array, numpy.float64)


def _corners(faces):
    """(F, k) numbers of vertices, of one of the four types that the library takes."""
    array = _any_array(faces, "faces")
    kind = array.dtype.kind
    no_face = array.size == 0  # [] is an array of real numbers
    if kind not in "iu" and not (no_face and kind == "f"):
        raise TypeError("faces must be whole numbers (of vertices), not %s" % array.dtype)
    if no_face and array.ndim <= 2:
        return numpy.zeros((0, 3), numpy.int32)
    if array.ndim != 2 or array.shape[1] < 3:
        raise ValueError("faces must have the shape (F, k) with k >= 3, not %s" % (array.shape,))
    return numpy.ascontiguousarray(array, "%s%d" % (kind, 8 if array.itemsize == 8 else 4))


def _digest(content):
    if len(content) != 32:
        raise ValueError("content must have 32 bytes (a SHA-256), not %d" % len(content))
    return content


def _path(path):
    path = os.fsencode(path)
    if b"\0" in path:
        raise ValueError("embedded null byte in %r" % path)
    return path


# ---- meshes

class Mesh(_Object):
    """A mesh of the library: see meander.read_mesh."""
    __slots__ = ()

    def __init__(self):
        raise TypeError("a Mesh is made by meander.read_mesh")

    @staticmethod
    def read(path, sampler=None):
        return Mesh.__new__(Mesh)._own(_library.meander_mesh_of_file(_path(path), sampler))

    @staticmethod
    def of_arrays(vertices, faces, normals=None, density=None, density_of_faces=False, content=None, check=True, colors=None,
                  colors_of_faces=False, attributes=()):
        """colors: (n, 3) float32; attributes: of name, (n, k) values, whether they are of faces, and whether classes."""
        vertices, faces = _reals(vertices, "vertices", 3), _corners(faces)
        arrays = _Arrays(vertices.ctypes.data, len(vertices), faces.ctypes.data, *faces.shape, faces.itemsize,
                         faces.dtype.kind == "i", density_of_faces=density_of_faces, check=bool(check))
        if normals is not None:
            normals = _reals(normals, "normals", 3)
            if len(normals) != len(vertices):
                raise ValueError("there are %d normals of %d vertices" % (len(normals), len(vertices)))
            arrays.normals = normals.ctypes.data
        if density is not None:
            density = _reals(density, "density", 0)
            count, things = (len(faces), "faces") if density_of_faces else (len(vertices), "vertices")
            if len(density) != count:
                raise ValueError("density has %d values for %d %s" % (len(density), count, things))
            arrays.density = density.ctypes.data
        if content is not None:
            arrays.content = _digest(content)
        if colors is not None:
            colors = numpy.ascontiguousarray(colors, numpy.float32)
            arrays.colors, arrays.colors_of_faces = colors.ctypes.data, colors_of_faces
        held = [numpy.ascontiguousarray(values, numpy.float64) for _, values, _, _ in attributes]
        table = (_Attribute * len(held))(*(_Attribute(name.encode(), values.ctypes.data, values.shape[1], of_faces, classes)
                                           for values, (name, _, of_faces, classes) in zip(held, attributes)))
        arrays.attributes, arrays.attribute_count = table, len(table)
        return Mesh.__new__(Mesh)._own(_library.meander_mesh_of_arrays(arrays))

    def with_density(self, density, of_faces):
        density = _reals(density, "density", 0)
        return Mesh.__new__(Mesh)._own(_library.meander_mesh_with_density(self, density.ctypes.data, len(density), of_faces))

    def _members(self):
        return _told(_library.meander_text(self))

    @property
    def vertices(self):
        members = self._members()
        if members["vertex_count"] == 0:
            return numpy.zeros((0, 3))
        arrays = _arrays(members["arrays"], self)
        return numpy.stack([arrays[axis] for axis in "xyz"], axis=1)

    @property
    def faces(self):
        members = self._members()
        if members["face_count"] == 0:
            return numpy.zeros((0, 3), numpy.uint32)
        if members["width"] == 0:
            return None
        return _arrays(members["arrays"], self)["corners"].reshape(-1, members["width"]).copy()

    @property
    def content(self):
        return bytes.fromhex(self._members()["content"])

    def __repr__(self):
        members = self._members()
        return "<meander.Mesh of %d vertices and %d faces>" % (members["vertex_count"], members["face_count"])


# ---- sampling

def _members_of(row):
    """The members of meander.Samples, or the SamplingError of a row that could not be sampled."""
    members = _told(_library.meander_text(row))
    if "status" in members:
        return SamplingError(members["status"], members["reason"])
    members.update(_arrays(members.pop("arrays"), row))
    for name in ("attributes", "descriptors"):
        members[name] = _arrays(members[name], row)
    members["names"] = json.loads(members["names"] or "{}")
    for name in ("bbox", "loc"):
        members[name] = members[name].copy()
    for name in ("area", "measure", "scale", "sharp_length"):
        members[name] = float.fromhex(members[name])
    members["content"] = bytes.fromhex(members["content"])
    return members


class _Work(_Object):
    """Work that ends with its `with` statement: what is left of it is canceled."""
    __slots__ = ()

    def __init__(self):
        self._own(_library.meander_work())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.__del__()

    def wait(self):
        while not _checked(_library.meander_wait(self, _PATIENCE)):
            pass  # handlers of signals run here, and may raise

    def take(self, milliseconds=0):
        """(index, members or SamplingError) of a row that is done, each given once; None where there is none in time."""
        pointer, index = _POINTER(), _COUNT()
        if not _checked(_library.meander_row(self, ctypes.byref(pointer), ctypes.byref(index), milliseconds)):
            return None
        return index.value, _members_of(_Object()._own(pointer.value))

    def row(self):
        """The members of the one row, which is there. Raises its SamplingError."""
        _, members = self.take()
        if isinstance(members, SamplingError):
            try:
                raise members
            finally:
                del members  # which would hold this frame, and this frame it
        return members


class Sampler(_Object):
    """Samples meshes with one set of options. For any number of threads at a time."""
    __slots__ = ()

    def __init__(self, of_files=False, path=None, **options):
        """path: the file whose attributes decide which columns hold classes."""
        path = None if path is None else _path(path)
        _with_options(lambda text: self._own(_library.meander_sampler(text, of_files, path)), options)

    def sample_mesh(self, mesh, threads, timeout, keep_mesh=True):
        limits = _limits(threads, timeout)
        with _Work() as work:
            if not _checked(_library.meander_sample(work, self, mesh, *limits, keep_mesh)):
                work.wait()
            return work.row()

    def sample_many(self, meshes, threads, timeout):
        """meshes: an iterable of Mesh objects that nobody else uses, or of exceptions. Yields results in their order: members
        of Samples, the SamplingError of a mesh, or the exception. Takes a few meshes for each thread ahead of its results."""
        limits = _limits(threads, timeout)
        ahead = 4 * (limits[0] or os.cpu_count() or 1) + 4
        done, given, yielded, meshes = {}, 0, 0, iter(meshes)
        with _Work() as work:
            _checked(_library.meander_sample_many(work, self, *limits))
            while True:
                while meshes is not None and given - yielded < ahead and yielded not in done:
                    mesh = next(meshes, None)
                    if mesh is None:
                        meshes = _checked(_library.meander_close(work)) or None
                    elif isinstance(mesh, Mesh):
                        while not _checked(_library.meander_offer(work, given, mesh, _PATIENCE)):
                            pass  # handlers of signals run here, and may raise
                        given += 1
                    else:
                        done[given] = mesh
                        given += 1
                    done.update(iter(work.take, None))
                if yielded in done:
                    result = done.pop(yielded)
                    yielded += 1
                    yield result
                elif meshes is None and yielded == given:
                    return work.wait()
                else:
                    done.update(filter(None, [work.take(_PATIENCE)]))
                    if yielded not in done:
                        _checked(_library.meander_wait(work, 0))  # raises what ended the work


def sample_named_surface(name, tolerance, threads, timeout, **options):
    limits, tolerance = _limits(threads, timeout), _real(tolerance, "tolerance")
    with _Work() as work:
        _with_options(lambda text: _checked(_library.meander_sample_surface(work, _path(name), text, tolerance, *limits)),
                      options)
        work.wait()
        return work.row()


def sample_callable_surface(function, tolerance, timeout, content, **options):
    (_, timeout), tolerance = _limits(1, timeout), _real(tolerance, "tolerance")
    content = None if content is None else _digest(content)
    raised = []

    def numbers(address, *shape):
        return numpy.ndarray(shape, "<f8", _memory(address, None))

    def positions(_, count, u, v, result):
        try:
            answer = function(numbers(u, count).copy(), numbers(v, count).copy())
            if isinstance(answer, (tuple, list)):
                answer = numpy.stack(answer, axis=-1)
            answer = _reals(answer, "the surface's positions", 3)
            if len(answer) != count:
                raise ValueError("the surface gave %d positions for %d parameters" % (len(answer), count))
            numbers(result, count, 3)[:] = answer
            return 0
        except BaseException as error:  # passes through the library by itself, interruptions too
            raised.append(error)
            return 1

    with _Work() as work:
        try:
            _with_options(lambda text: _checked(_library.meander_sample_function(
                work, _FUNCTION(positions), None, content, text, tolerance, timeout)), options)
        except RuntimeError:
            if not raised:
                raise
        if raised:
            raise raised.pop()
        return work.row()


# ---- the rest

def measure(points, mesh, boxes, seed, modes):
    """A dict of the measures, boxes first."""
    modes = operator.index(modes)
    found_modes = {}
    if modes != 0:
        errors = call_laboratory("mode_errors", mesh, points=_reals(points, "points", 3), modes=modes)
        found_modes["modes"] = float(errors.ratio)
    error = measure_boxes(points, mesh, boxes, seed)
    points = _reals(points, "points", 3)
    if len(points) < 2:
        raise ValueError("points is one point, which has no neighbor")
    spread = call_laboratory("spacing_on_mesh", mesh, points=points, seed=operator.index(seed))
    found = dict(boxes=float(error), limit=error.limit, over_limit=error.over_limit,
                 **{name: spread.__dict__[name] for name in ("rho", "least", "mean", "coverage", "hole", "chamfer")},
                 **found_modes)
    return found


class BoxError(float):
    """The error over rotated boxes, relative to random points. limit: the least error that is known to be possible for as many
    points on this surface. over_limit: the error over it, 1 at best."""

    __slots__ = ("limit", "over_limit")

    def __new__(cls, error, limit):
        made = super().__new__(cls, error)
        made.limit, made.over_limit = limit, error / limit if limit > 0 else float("inf")
        return made

    def __reduce__(self):
        return BoxError, (float(self), self.limit)


def measure_boxes(points, mesh, boxes, seed):
    boxes, seed = operator.index(boxes), operator.index(seed)
    if not 1 <= boxes <= 200000:
        raise ValueError("boxes is %d: 1 to 200000" % boxes)
    if not 0 <= seed < 2 ** 64:
        raise ValueError("seed cannot be %d" % seed)
    points = _reals(points, "points", 3)
    if len(points) == 0:
        raise ValueError("points is empty")
    found = call_laboratory("box_errors", mesh, points=points, boxes=boxes, seed=seed)
    return BoxError(float(found.ratios[0]), float(found.limit))


__version__ = _about()["version"]


@functools.lru_cache(maxsize=8)
def settings(kind):
    """Rows of {keyword, type, default, words, list, help}. kind: "mesh", "file" (as "mesh", and what is taken over from files)
    or "surface"; "training": of further sets of points, which "mesh" has too; "remesh": of its mesh alone; "run": the options
    of `meander run`, with {option, truth} too."""
    return _about()[kind + ("_options" if kind == "run" else "_settings")]


@functools.lru_cache(maxsize=1)
def columns():
    """Of samples: rows of {dataset, array, type, width, doc, always, option}."""
    return _about()["columns"]


def surface_names():
    return _about()["surfaces"]


def descriptor_names():
    return _about()["descriptors"]


# ---- functions over arrays, of the product and of the laboratory

class LaboratoryResult(_Object):
    """What a function returned: its numbers and arrays as attributes."""

    def __init__(self, pointer):
        self._own(pointer)
        members = _told(_library.meander_text(self))
        self.__dict__.update({name: float.fromhex(number) for name, number in members["numbers"].items()})
        self.__dict__.update({name: array.copy() for name, array in _arrays(members["arrays"], self).items()})


def _given_array(name, values):
    array = _any_array(values, name)
    types = {"f": "d", "i": "I", "u": "B" if array.dtype == numpy.uint8 else "I", "b": "B"}
    if array.dtype.kind not in types or array.ndim not in (1, 2):
        raise TypeError("%s must be an array of numbers of one or two dimensions, not %s%s"
                        % (name, array.dtype, array.shape))
    return numpy.ascontiguousarray(array, types[array.dtype.kind])


def call_laboratory(function, staged=None, **given):
    """staged: what an earlier call returned, or a Mesh."""
    arrays = {name: _given_array(name, value) for name, value in given.items()
              if isinstance(value, numpy.ndarray)}
    options = {name: value for name, value in given.items() if name not in arrays and value is not None}
    return call_function(function, arrays, options, staged)


def call_function(function, arrays, options, subject=None):
    """arrays: contiguous, double, float32, uint32 or uint8. subject: a Mesh, or what an earlier call returned."""
    table = (_Given * len(arrays))(*(_Given(name.encode(), a.ctypes.data, a.dtype.char.encode(), len(a),
                                            a.shape[1] if a.ndim == 2 else 1) for name, a in arrays.items()))
    return LaboratoryResult(_library.meander_call(function.encode(), json.dumps(options).encode(), table, len(arrays),
                                                  subject))


def _with_points(function, mesh, points, threads, timeout, **options):
    points = _reals(points, "points", 3)
    threads, timeout = _limits(threads, timeout)
    return call_function(function, {"points": points}, {"threads": threads, "timeout": timeout, **options}, mesh)


def signed_distance(mesh, points, sign, threads, timeout):
    """The members of meander.SignedDistances."""
    if not isinstance(sign, str):
        raise TypeError("sign cannot be %r" % (sign,))
    found = vars(_with_points("signed_distance", mesh, points, threads, timeout, sign=sign))
    return dict(distance=found["distance"], face_index=found["face"], corners=found["corners"], barycentric=found["weights"],
                inside=found["inside"].astype(bool), certain=found["certain"].astype(bool), winding=found.get("winding"),
                sign=bytes(found["sign"]).decode(), open_edges=int(found["open_edges"]))


def winding_number(mesh, points, error, threads, timeout):
    error = _real(error, "error")
    if not 0 <= error <= 1000:
        raise ValueError("error is %s: 0 (exact) to 1000" % error)
    return _with_points("winding_number", mesh, points, threads, timeout, error=error).winding


def write_points(path, frame, samples):
    """samples: arrays by the names of their columns, `points` among them."""
    types = {row["array"]: numpy.dtype(row["type"]) for row in columns()}
    arrays = {name: numpy.ascontiguousarray(values, types[name]) for name, values in samples.items()}
    arrays["frame"] = numpy.asarray(frame, numpy.float64)
    arrays["path"] = numpy.frombuffer(_path(path), numpy.uint8)
    call_function("write_points", arrays, {})


def remesh(mesh, content, sample, lines, threads, timeout):
    threads, timeout = _limits(threads, timeout)
    arrays = {"content": numpy.frombuffer(_digest(content), numpy.uint8)}

    def call(text):  # that of all options; each list has its own
        given = json.loads(text)
        return call_function("remesh", arrays, {
            "sample": json.dumps({name: given[name] for name in sample}),
            "mesh": json.dumps({name: given[name] for name in lines}), "threads": threads, "timeout": timeout}, mesh)
    return _with_options(call, {**sample, **lines})
