"""The models that figures show: of files, and made here."""
import os

import numpy

from .. import SamplingError, read_mesh

PACKAGED = "/usr/share/glmark2/models/bunny.obj"


class Model:
    """A triangle mesh: vertices (V, 3) float64, faces (T, 3) uint32, and the file that it came from, or None."""

    def __init__(self, name, vertices, faces, path=None):
        self.name, self.path = name, path
        self.vertices, self.faces = numpy.asarray(vertices, float), numpy.asarray(faces, numpy.uint32)

    @property
    def arrays(self):
        """As the functions of the laboratory take it."""
        return {"vertices": self.vertices, "faces": self.faces}

    def edge_lines(self):
        """(E, 6) segments, each edge once."""
        pairs = numpy.sort(self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2).astype(numpy.int64), axis=1)
        pairs = numpy.unique(pairs, axis=0)
        return numpy.hstack([self.vertices[pairs[:, 0]], self.vertices[pairs[:, 1]]])


def read_model(path):
    try:
        mesh = read_mesh(path)
    except SamplingError as error:
        raise ValueError("`%s`: %s" % (path, error)) from None
    faces = mesh.faces
    if faces is None or faces.shape[1] != 3:
        raise ValueError("`%s` has faces that are not triangles; figures need triangle meshes" % path)
    return Model(os.path.splitext(os.path.basename(path))[0], mesh.vertices, faces, os.path.abspath(path))


def chosen_models(paths):
    """Of the files; without any the packaged bunny, and a torus where that is not installed."""
    models = [read_model(path) for path in paths or [PACKAGED] * os.path.exists(PACKAGED)]
    names = [model.name for model in models]
    for name in names:
        if names.count(name) > 1:
            raise ValueError("two models are called `%s`: their figures would have the same names" % name)
    return models or [torus(96, 48)]


def subjects(figures, prefix):
    """The given models whose names start so; all of them where there is none."""
    return [model for model in figures.models if model.name.lower().startswith(prefix)] or figures.models


# Some models of the survey do not look along z with y up: the direction from them towards the eye, and up.
_VIEWS = {"maxplanck": ((-0.55, 0.42, -1), (0, 1, 0)), "igea_16k": ((1, 0.15, 0.25), (0, 1, 0)),
          "venus_100k": ((1, -0.35, 0.15), (0, 0, 1)), "eight_11k": ((0.55, -1, 0.42), (0, 0, 1))}


def view_of(figures, model):
    """view and up as laboratory.picture takes them: what was asked for, or where the model is known to look."""
    known = [looks for name, looks in _VIEWS.items() if model.name.lower().startswith(name) and not figures.view_given]
    view, up = known[0] if known else (figures.view, figures.up)
    return {"view": numpy.array(view, float), "up": numpy.array(up, float)}


def grid_faces(rows, columns, closed=False):
    """(T, 3) of a grid of vertices, row by row; `closed`: the last row and column meet the first."""
    i, j = numpy.meshgrid(numpy.arange(rows - (not closed)), numpy.arange(columns - (not closed)), indexing="ij")
    a, b = i * columns + j, (i + 1) % rows * columns + j
    c, d = (i + 1) % rows * columns + (j + 1) % columns, i * columns + (j + 1) % columns
    return numpy.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3).astype(numpy.uint32)


def torus(around, across, radius=0.4):
    u, v = numpy.meshgrid(numpy.arange(around) / around, numpy.arange(across) / across, indexing="ij")
    u, v = 2 * numpy.pi * u.ravel(), 2 * numpy.pi * v.ravel()
    ring = 1 + radius * numpy.cos(v)
    return Model("torus", numpy.stack([ring * numpy.cos(u), ring * numpy.sin(u), radius * numpy.sin(v)], axis=1),
                 grid_faces(around, across, True))


def unit_square(side):
    v, u = numpy.meshgrid(numpy.arange(side + 1) / side, numpy.arange(side + 1) / side, indexing="ij")
    return Model("unit-square", numpy.stack([u.ravel(), v.ravel(), 0 * u.ravel()], axis=1),
                 grid_faces(side + 1, side + 1)[:, ::-1])


def unit_sphere(rings, half_axes=(1, 1, 1)):
    """Triangles between rings of latitude; half_axes make an ellipsoid of it."""
    polar, around = numpy.meshgrid(numpy.pi * numpy.arange(1, rings) / rings,
                                   numpy.pi * numpy.arange(2 * rings) / rings, indexing="ij")
    body = numpy.stack([numpy.sin(polar) * numpy.cos(around), numpy.sin(polar) * numpy.sin(around), numpy.cos(polar)],
                       axis=-1).reshape(-1, 3)
    vertices = numpy.vstack([[[0, 0, 1]], body, [[0, 0, -1]]])
    i, j = numpy.meshgrid(numpy.arange(rings - 2), numpy.arange(2 * rings), indexing="ij")
    at = lambda i, j: 1 + i * 2 * rings + j % (2 * rings)
    a, b, c, d = at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)
    j = numpy.arange(2 * rings)
    faces = numpy.vstack([numpy.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3),
                          numpy.stack([0 * j, at(0, j), at(0, j + 1)], axis=1),
                          numpy.stack([0 * j + len(vertices) - 1, at(rings - 2, j + 1), at(rings - 2, j)], axis=1)])
    return Model("sphere", vertices * numpy.asarray(half_axes, float), faces)


def unit_cube(side):
    square = unit_square(side)
    u, v = square.vertices[:, 0], square.vertices[:, 1]
    zero, one = 0 * u, 0 * u + 1
    sides = [(v, u, zero), (u, v, one), (u, zero, v), (v, one, u), (zero, v, u), (one, u, v)]
    return Model("unit-cube", numpy.vstack([numpy.stack(s, axis=1) for s in sides]),
                 numpy.vstack([square.faces + k * len(u) for k in range(6)]))
