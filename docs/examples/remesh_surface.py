"""Makes a mesh of few, well spread vertices out of a fine one, takes colors along, and writes it as PLY.

    python3 remesh_surface.py [FILE.ply]
"""
import sys

import numpy

import meander


def knot(around=300, across=24):
    """A trefoil knot as a tube of quadrilaterals."""
    s = numpy.arange(around) * 2 * numpy.pi / around
    curve = numpy.stack([numpy.sin(s) + 2 * numpy.sin(2 * s), numpy.cos(s) - 2 * numpy.cos(2 * s), -numpy.sin(3 * s)], 1)
    along = numpy.roll(curve, -1, axis=0) - numpy.roll(curve, 1, axis=0)
    along /= numpy.linalg.norm(along, axis=1, keepdims=True)
    side = numpy.cross(along, [0.0, 0.0, 1.0])
    side /= numpy.linalg.norm(side, axis=1, keepdims=True)
    up = numpy.cross(side, along)
    a = numpy.arange(across) * 2 * numpy.pi / across
    tube = curve[:, None] + 0.4 * (numpy.cos(a)[:, None] * side[:, None] + numpy.sin(a)[:, None] * up[:, None])
    i, j = numpy.meshgrid(numpy.arange(around), numpy.arange(across), indexing="ij")
    at = lambda i, j: (i % around * across + j % across).ravel()
    return tube.reshape(-1, 3), numpy.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], 1)


vertices, faces = knot()
colors = (vertices - vertices.min(axis=0)) / numpy.ptp(vertices, axis=0)
options = dict(n=1500, sequence="spaced", seed=3)
coarse = meander.remesh(vertices, faces, fit=True, **options)
print("%d vertices and %d quadrilaterals -> %s" % (len(vertices), len(faces), coarse))
print("euler characteristic %d, components %d, crossings %d" % tuple(
    coarse.report[name] for name in ("euler", "components", "crossings")))

# The first vertices are the samples that meander.sample places with the same options, with their colors.
samples = meander.sample(vertices, faces, colors=colors, colors_at="vertices", **options)
rgb = numpy.full((len(coarse.vertices), 3), 204, numpy.uint8)
rgb[:coarse.samples] = samples.rgb

edges = coarse.vertices[coarse.faces] - coarse.vertices[numpy.roll(coarse.faces, 1, axis=1)]
lengths = numpy.linalg.norm(edges, axis=2)
print("edges: mean %.3f, shortest %.3f, longest %.3f" % (lengths.mean(), lengths.min(), lengths.max()))

path = sys.argv[1] if len(sys.argv) > 1 else "knot.ply"
with open(path, "w") as file:
    file.write("ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\nproperty float z\n"
               "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face %d\n"
               "property list uchar int vertex_indices\nend_header\n" % (len(coarse.vertices), len(coarse.faces)))
    for vertex, color in zip(coarse.vertices, rgb):
        file.write("%.6f %.6f %.6f %d %d %d\n" % (*vertex, *color))
    numpy.savetxt(file, numpy.insert(coarse.faces.astype(int), 0, 3, axis=1), "%d")
again = meander.read_mesh(path)
print("%s: %s" % (path, again))
