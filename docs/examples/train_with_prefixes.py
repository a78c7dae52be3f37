"""Trains a classifier on a store of samples, with prefixes of its rows in place of farthest point sampling.

    python3 train_with_prefixes.py [FOLDER]        with PyTorch a small PointNet, without it nearest neighbors
"""
import sys
import time
from pathlib import Path

import numpy
import meander


def shape(kind, size):
    """A mesh of quadrilaterals: a torus, or a sphere with bumps."""
    u, v = numpy.meshgrid(numpy.linspace(0, 2 * numpy.pi, 48), numpy.linspace(0, 1, 24), indexing="ij")
    r, h = {"torus": (2 + size * numpy.cos(2 * numpy.pi * v), size * numpy.sin(2 * numpy.pi * v)),
            "sphere": ((1 + size / 3 * numpy.sin(5 * u)) * numpy.sin(numpy.pi * v), numpy.cos(numpy.pi * v))}[kind]
    i = (24 * numpy.arange(47)[:, None] + numpy.arange(23)).ravel()
    return numpy.stack([r * numpy.cos(u), r * numpy.sin(u), h], -1).reshape(-1, 3), numpy.stack([i, i + 24, i + 25, i + 1], 1)


folder = Path(sys.argv[1] if len(sys.argv) > 1 else "training")
for number in range(60):                              # CLASS/SPLIT/MODEL.off, as in ModelNet
    kind = ("sphere", "torus")[number % 2]
    file = folder / "models" / kind / ("test" if number % 3 == 0 else "train") / ("%02d.off" % number)
    file.parent.mkdir(parents=True, exist_ok=True)
    vertices, faces = shape(kind, 0.2 + 0.01 * number)
    with open(file, "w") as out:
        numpy.savetxt(out, vertices, "%.6f", header="OFF\n%d %d 0" % (len(vertices), len(faces)), comments="")
        numpy.savetxt(out, numpy.insert(faces, 0, 4, 1), "%d")
print(meander.run(folder / "models", folder / "shapes.h5", n=2048, layout="modelnet", normalize="pointnet"))

# The first 128 of 2,048 points cover the surface nearly as well as 128 chosen by their distances, and cost nothing.
points = meander.StoreDataset(folder / "shapes.h5", "points")[0]
start, chosen, far = time.perf_counter(), [0], numpy.full(len(points), numpy.inf)
while len(chosen) < 128:
    far = numpy.minimum(far, numpy.linalg.norm(points - points[chosen[-1]], axis=1))
    chosen.append(int(far.argmax()))
milliseconds = 1000 * (time.perf_counter() - start)
for name, some in (("prefix", points[:128]), ("farthest points (%.0f ms)" % milliseconds, points[chosen]),
                   ("random", numpy.random.default_rng(1).permutation(points)[:128])):
    distances = numpy.linalg.norm(points[:, None] - some, axis=2).min(axis=1)
    print("%s: mean distance to the nearest of 128: %.3f" % (name, distances.mean()))

train, test = (meander.StoreDataset(folder / "shapes.h5", ("points", "label"), points=128, split=s) for s in ("train", "test"))
try:
    import torch
except ImportError:                                   # sorted distances from the center, compared with those of all others
    vectors = [numpy.sort(numpy.linalg.norm([points for points, _ in data], axis=2)) for data in (train, test)]
    guessed = train.labels[meander.knn(*vectors, k=1).rows[:, 0]]
else:
    net, head = torch.nn.Sequential(torch.nn.Linear(3, 64), torch.nn.ReLU(), torch.nn.Linear(64, 64)), torch.nn.Linear(64, 2)
    optimizer = torch.optim.Adam([*net.parameters(), *head.parameters()], 1e-2)
    for epoch in range(30):
        for batch, label in torch.utils.data.DataLoader(train, 8, shuffle=True, num_workers=2, multiprocessing_context="fork"):
            optimizer.zero_grad()
            torch.nn.functional.cross_entropy(head(net(batch).amax(dim=1)), label).backward()
            optimizer.step()
    guessed = [int(head(net(torch.from_numpy(points)).amax(dim=0)).argmax()) for points, _ in test]
print("%d of %d test models right: %s" % ((guessed == test.labels).sum(), len(test), ", ".join(train.class_names)))
