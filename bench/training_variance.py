#!/usr/bin/env python3
"""Error of losses over Meander's sets of points with distances, against as many random points.

    training_variance.py DATA [-n 1024,4096,16384] [--seeds 32]

For closed models of DATA/paper, in the sphere of --normalize unit-sphere: points of `--queries "near=N@.05 volume=N@1"`,
and random ones of the same distributions (a uniform random point of the surface moved by a random Gaussian; a random
point of the cube). Over each set of N points means are taken of

    clipped   min(|d|, 0.1), d being the distance: what DeepSDF's loss of a network that says 0 everywhere is
    sphere    |clip(d) - clip(d')|, clip to 0.1, d' the distance from the sphere of radius 1/2: its loss of a network as it
              is often begun
    inside    1 inside, 0 outside: a share of labels

The variance of a mean is that over --seeds seeds. The table has the ratio of variances, random over Meander, the geometric
mean over the models: so many times more random points are as good. Needs numpy, and the package of the build in
PYTHONPATH. Exit status 1 for a model without certain sides.
"""
import argparse
import sys
from pathlib import Path

import numpy

import meander

MODELS = ("bunny_closed.off", "eight.off", "fandisk.off", "hand_3k.off", "igea_16k.off", "knot.obj", "maxplanck_25k.off")
KINDS = ("near", "volume")


def clip(values):
    return numpy.clip(values, -0.1, 0.1)


LOSSES = {"clipped": lambda points, distance: abs(clip(distance)),
          "sphere": lambda points, distance: abs(clip(distance) - clip(numpy.linalg.norm(points, axis=1) - 0.5)),
          "inside": lambda points, distance: distance < 0}


def random_points(vertices, faces, kind, count, generator):
    if kind == "volume":
        return generator.uniform(-1, 1, (count, 3))
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    area = numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1)
    chosen = generator.choice(len(faces), count, p=area / area.sum())
    root, second = numpy.sqrt(generator.random((count, 1))), generator.random((count, 1))
    on = a[chosen] + (1 - root) * (b - a)[chosen] + second * root * (c - a)[chosen]
    return on + generator.normal(0, 0.05, (count, 3))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("data", type=Path)
    parser.add_argument("-n", default="1024,4096,16384")
    parser.add_argument("--seeds", type=int, default=32)
    given = parser.parse_args()
    sizes = [int(n) for n in given.n.split(",")]
    logs = {(kind, loss, n): [] for kind in KINDS for loss in LOSSES for n in sizes}
    for name in MODELS:
        mesh = meander.read_mesh(given.data / "paper" / name)
        means = {key: ([], []) for key in logs}
        for seed in range(given.seeds):
            generator = numpy.random.default_rng(seed)
            # Prefixes are the sets of fewer points: kinds take turns.
            made = meander.sample(mesh, n=4, normalize="unit-sphere", seed=seed,
                                  queries="near=%d@.05 volume=%d@1" % (max(sizes), max(sizes)))
            if made.sign_rule != "closed":
                print("%s: sides by the rule %s" % (name, made.sign_rule), file=sys.stderr)
                return 1
            vertices, faces = (mesh.vertices - made.loc) / made.scale, mesh.faces
            for number, kind in enumerate(KINDS):
                own = made.queries_kind == number
                sets = [(made.queries_points[own].astype(float), made.queries_distance[own].astype(float))]
                points = random_points(vertices, faces, kind, max(sizes), generator)
                sets.append((points, meander.signed_distance(vertices, faces, points).distance))
                for n in sizes:
                    for loss, of in LOSSES.items():
                        for side, (at, distance) in enumerate(sets):
                            means[kind, loss, n][side].append(of(at[:n], distance[:n]).mean())
        for key, (nets, random) in means.items():
            logs[key].append(numpy.log(numpy.var(random) / numpy.var(nets)))
        print("%s: %s" % (name, ", ".join("%s %s %.3g" % (kind, loss, numpy.exp(logs[kind, loss, max(sizes)][-1]))
                                          for kind in KINDS for loss in LOSSES)), flush=True)
    print("\n| points | loss | %s |\n|---|---|%s" % (" | ".join("%d of them" % n for n in sizes), "---|" * len(sizes)))
    for kind in KINDS:
        for loss in LOSSES:
            print("| `%s` | %s | %s |" % (kind, loss, " | ".join("%.3g" % numpy.exp(numpy.mean(logs[kind, loss, n])) for n in sizes)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
