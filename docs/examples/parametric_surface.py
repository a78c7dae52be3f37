"""Samples a parametric surface that is a function of Python, where it is bent more densely, and integrates over it.

    python3 parametric_surface.py [FILE.xyz]
"""
import sys

import numpy

import meander


def torus(u, v):
    """Two arrays of parameters in [0, 1] to positions (k, 3): radii 2 and 1."""
    a, b = 2 * numpy.pi * u, 2 * numpy.pi * v
    return numpy.stack([(2 + numpy.cos(b)) * numpy.cos(a), (2 + numpy.cos(b)) * numpy.sin(a), numpy.sin(b)], axis=1)


even = meander.surface(torus, n=4096)
print("area %.4f, exactly %.4f" % (even.area, 8 * numpy.pi ** 2))

# Gaussian curvature is largest on the outside: cos(b) / (2 + cos(b)), 1/3 there and -1 inside, whose absolute value counts.
bent = meander.surface(torus, n=4096, density="gaussian")
inside = lambda s: float((numpy.hypot(s.points[:, 0], s.points[:, 1]) < 2).mean())
print("on the inner half: %.3f of even samples, %.3f of those by curvature" % (inside(even), inside(bent)))

# The weights are the areas that samples stand for: sums of them integrate, whatever the density. Here the squared distance
# from the axis, which is (R^2 + 3/2 r^2) A for the radii R and r.
exact = (2 ** 2 + 1.5) * 8 * numpy.pi ** 2
for name, samples in (("even", even), ("by curvature", bent)):
    square = (samples.points[:, :2].astype(float) ** 2).sum(axis=1)
    print("%s: integral of the squared distance %.3f, exactly %.3f" % (name, (samples.weights * square).sum(), exact))

# Every prefix is a good sample by itself.
generator = numpy.random.default_rng(1)
squares = (even.points[:, :2].astype(float) ** 2).sum(axis=1)
for n in (64, 256, 1024):
    error = abs(squares[:n].mean() * even.area / exact - 1)
    others = numpy.mean([abs(generator.choice(squares, n).mean() * even.area / exact - 1) for _ in range(200)])
    print("the first %4d points: relative error %.5f, %.5f for random ones" % (n, error, others))

# Surfaces by name and by formula, and the parameters of each sample.
print(meander.surface("u, v, sin(6*u)/6", n=500).uv[:2].round(3).tolist(), meander.surface_names()[:4])
path = sys.argv[1] if len(sys.argv) > 1 else "torus.xyz"
numpy.savetxt(path, numpy.hstack([bent.points, bent.normals]), "%.6f")
print("%s: %d points with normals" % (path, len(bent)))
