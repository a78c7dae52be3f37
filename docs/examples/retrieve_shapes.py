"""Finds shapes by descriptors of a store, and by vectors that any other program has made.

    python3 retrieve_shapes.py [FOLDER]
"""
import sys
from pathlib import Path

import numpy

import meander


def revolved(radii, heights, turns=40):
    """A surface of revolution: vertices and quadrilaterals."""
    a = numpy.arange(turns) * 2 * numpy.pi / turns
    vertices = numpy.concatenate([numpy.stack([r * numpy.cos(a), r * numpy.sin(a), 0 * a + h], 1)
                                  for r, h in zip(radii, heights)])
    i, j = numpy.meshgrid(numpy.arange(len(radii) - 1), numpy.arange(turns), indexing="ij")
    at = lambda i, j: (i * turns + j % turns).ravel()
    return vertices, numpy.stack([at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)], 1)


folder = Path(sys.argv[1] if len(sys.argv) > 1 else "retrieval")
t, generator = numpy.linspace(0, 1, 30), numpy.random.default_rng(1)
profiles = {"cone": lambda: 1 - 0.98 * t, "vase": lambda: 0.6 + 0.3 * numpy.sin(7 * t), "tube": lambda: 0.3 + 0 * t}
for name, profile in profiles.items():
    for number in range(8):
        file = folder / "models" / name / ("%d.off" % number)
        file.parent.mkdir(parents=True, exist_ok=True)
        vertices, faces = revolved(profile() * (1 + 0.1 * generator.random()), 2 * t * (1 + 0.1 * generator.random()))
        vertices = vertices @ numpy.linalg.qr(generator.normal(size=(3, 3)))[0]        # turned somehow
        with open(file, "w") as out:
            out.write("OFF\n%d %d 0\n" % (len(vertices), len(faces)))
            numpy.savetxt(out, vertices, "%.6f")
            numpy.savetxt(out, numpy.insert(faces, 0, 4, 1), "%d")

meander.run(folder / "models", folder / "shapes.h5", n=1024, describe="pairs,d2", label_from_folder=True)
with meander.open_store(folder / "shapes.h5") as store:
    for descriptor in ("pairs", "d2"):                       # each model against all others
        found = meander.knn(store, k=7, descriptor=descriptor)
        right = store.labels[found.rows] == store.labels[store.ok, None]
        print("%s: %.0f %% of the nearest and %.0f %% of 7 neighbors are of the same class" % (
            descriptor, 100 * right[:, 0].mean(), 100 * right.mean()))
    near = meander.knn(store, ["vase/3.off"], k=3, descriptor="pairs")
    print("vase/3.off:", ", ".join("%s (%.3f)" % (store.ids[row], distance)
                                   for row, distance in zip(near.rows[0], near.distances[0])))

    new = meander.describe(*revolved(0.62 + 0.3 * numpy.sin(7 * t), 2 * t), "pairs", n=1024)["pairs"]
    print("a new vase is near", [store.ids[row] for row in meander.knn(store, [new], k=3, descriptor="pairs").rows[0]])

    points = store.points()                                   # vectors of any origin, a network's for example: here moments
    numpy.save(folder / "features.npy", numpy.linalg.svd(points - points.mean(axis=1, keepdims=True), compute_uv=False))
    found = meander.knn(folder / "features.npy", k=1, distance="l2")
    print("features.npy: %.0f %% of the nearest are of the same class" % (
        100 * (store.labels[store.ok][found.rows[:, 0]] == store.labels[store.ok]).mean()))
