"""Compares samplers of one surface by the error over boxes, by spacing, and by time.

    python3 compare_samplers.py [N [MESH]]
"""
import sys
import time

import numpy

import meander


def bumpy_sphere(rings=60, columns=120):
    """Vertices and quadrilaterals; those at the poles are folded, which Meander mends."""
    t, p = numpy.meshgrid(numpy.linspace(0, numpy.pi, rings + 1), numpy.arange(columns), indexing="ij")
    p = 2 * numpy.pi * p / columns
    r = 1 + 0.2 * numpy.sin(5 * p) * numpy.sin(t) ** 3
    vertices = numpy.stack([r * numpy.sin(t) * numpy.cos(p), r * numpy.sin(t) * numpy.sin(p), numpy.cos(t)], -1)
    i, j = numpy.meshgrid(numpy.arange(rings), numpy.arange(columns), indexing="ij")
    at = lambda i, j: (i * columns + j % columns).ravel()
    return vertices.reshape(-1, 3), numpy.stack([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], 1)


def random_points(vertices, faces, n, generator=numpy.random.default_rng(1)):
    """Independent uniform points, as trimesh or Open3D draw them."""
    triangles = numpy.concatenate([faces[:, [0, k, k + 1]] for k in range(1, faces.shape[1] - 1)])
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    areas = numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1)
    chosen = generator.choice(len(triangles), n, p=areas / areas.sum())
    u, v = generator.random((2, n, 1))
    u, v = numpy.where(u + v > 1, 1 - u, u), numpy.where(u + v > 1, 1 - v, v)
    return a[chosen] + u * (b - a)[chosen] + v * (c - a)[chosen]


def farthest_points(vertices, faces, n):
    """n of 8 n random points, each the farthest from those before it."""
    points = random_points(vertices, faces, 8 * n)
    chosen, far = [0], numpy.full(len(points), numpy.inf)
    while len(chosen) < n:
        far = numpy.minimum(far, ((points - points[chosen[-1]]) ** 2).sum(axis=1))
        chosen.append(int(far.argmax()))
    return points[chosen]


n = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
mesh = bumpy_sphere()
if len(sys.argv) > 2:
    given = meander.read_mesh(sys.argv[2])
    if given.faces is None:
        sys.exit("%s has faces of different sizes: give a mesh of triangles" % sys.argv[2])
    mesh = given.vertices, given.faces
samplers = {"random": random_points, "farthest points": farthest_points,
            "meander": lambda v, f, n: meander.sample(v, f, n).coordinates(),
            "meander, spaced": lambda v, f, n: meander.sample(v, f, n, sequence="spaced").coordinates()}
print("%-16s %8s %8s %10s %8s" % ("%d points" % n, "boxes", "rho", "coverage", "ms"))
for name, sampler in samplers.items():
    start = time.perf_counter()
    points = sampler(*mesh, n)
    seconds, m = time.perf_counter() - start, meander.measure(points, *mesh)
    print("%-16s %8.3f %8.3f %10.4f %8.1f" % (name, m["boxes"], m["rho"], m["coverage"], 1000 * seconds))
