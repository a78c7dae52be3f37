"""Fits a function to the signed distances that a run stored, and asks it which points are inside.

    python3 fit_distances.py [FOLDER]        numpy alone; a network would take the same arrays
"""
import sys
from pathlib import Path

import numpy
import meander

folder = Path(sys.argv[1] if len(sys.argv) > 1 else "distances")
(folder / "models").mkdir(parents=True, exist_ok=True)
for name, tube in (("thick", 0.45), ("thin", 0.25)):  # tori as quadrilaterals
    u, v = numpy.meshgrid(*[numpy.arange(64) * 2 * numpy.pi / 64] * 2, indexing="ij")
    ring = 1 + tube * numpy.cos(v)
    vertices = numpy.stack([ring * numpy.cos(u), ring * numpy.sin(u), tube * numpy.sin(v)], -1).reshape(-1, 3)
    a, b = numpy.arange(64)[:, None], numpy.arange(64)[None]
    faces = numpy.stack([64 * x % 4096 + y % 64 for x, y in ((a, b), (a + 1, b), (a + 1, b + 1), (a, b + 1))], -1).reshape(-1, 4)
    with open(folder / "models" / (name + ".off"), "w") as out:
        numpy.savetxt(out, vertices, "%.6f", header="OFF\n4096 4096 0", comments="")
        numpy.savetxt(out, numpy.insert(faces, 0, 4, 1), "%d")
print(meander.run(folder / "models", folder / "tori.h5", n=512, normalize="unit-box",
                  queries="near=6000@0.02,0.1 volume=2000@0.55"))

generator = numpy.random.default_rng(1)
waves, phases = generator.normal(0, 5, (3, 600)), generator.uniform(0, 2 * numpy.pi, 600)
columns = ("points", "distance", "inside", "sign_certain")
data = meander.StoreDataset(folder / "tori.h5", ("id", *("queries_" + name for name in columns)))
for name, points, distance, inside, certain in data:
    values = numpy.cos(points.astype(float) @ waves + phases)
    train, test = slice(0, 6000), slice(6000, None)   # the first 6,000 have near and volume points in the same shares as all
    matrix = values[train].T @ values[train] + 1e-3 * numpy.eye(600)
    weights = numpy.linalg.solve(matrix, values[train].T @ distance[train].astype(float))
    guessed = values[test] @ weights
    print("%s: %.4f mean error of the distance, %.1f %% of the sides right, %d of %d certain" % (
        name, abs(guessed - distance[test]).mean(), 100 * ((guessed < 0) == inside[test].astype(bool)).mean(),
        certain.sum(), len(certain)))
