#!/usr/bin/env python3
"""Small sets for training out of stored rows: prefixes beside farthest point sampling, elimination and random points.

    prefixes.py MESH... [-n 4096] [-k 256 1024] [--sets 16] [--yuksel CYCODEBASE]

For every mesh and k, means over the sets of
  random points: the first k of n random points;
  farthest points: k of n random points, each the farthest from all before it (as training scripts take them);
  Yuksel's own code (--yuksel: the folder of github.com/cemyuksel/cyCodeBase): k of n random points by elimination;
  the first k of n samples of Meander, by default and with sequence="spaced";
and the least error that is known to be possible for k points.
Error: root mean square error of the share of points in random rotated boxes, relative to random points (the same boxes for
all). rho: the smallest distance over that of the hexagonal lattice of k points. Time: microseconds of one core to choose
the k points, for each of them; a prefix costs nothing. Needs numpy, a Python package of Meander with the laboratory
(PYTHONPATH), and g++ for --yuksel.
"""
import argparse
import math
import tempfile
from pathlib import Path

import meander
import numpy as np
from poisson_disk_peers import Eliminator, farthest_points


def smallest_distance(points):
    squares = np.einsum("ij,ij->i", points, points)
    apart = squares[:, None] + squares[None, :] - 2 * points @ points.T
    np.fill_diagonal(apart, np.inf)
    return math.sqrt(max(0.0, apart.min()))


def sets_of(mesh, n, k, seed, eliminate):
    """(name, points, seconds) of every way."""
    random = meander.sample(mesh, n=n, seed=seed, method="direct", sequence="random")
    points = random.coordinates().astype(np.float32)
    yield "random points", points[:k], 0.0
    if eliminate:
        yield ("Yuksel's own code", *eliminate(points, k, random.area))
    yield ("farthest points", *farthest_points(points, k))
    for name, options in (("prefix", {}), ("prefix, spaced", {"sequence": "spaced"})):
        yield name, meander.sample(mesh, n=n, seed=seed, **options).coordinates()[:k], 0.0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+", type=Path)
    parser.add_argument("-n", "--points", type=int, default=4096, help="of a stored row")
    parser.add_argument("-k", "--taken", type=int, nargs="+", default=[256, 1024])
    parser.add_argument("--sets", type=int, default=16)
    parser.add_argument("--yuksel", metavar="CYCODEBASE", type=Path)
    arguments = parser.parse_args()
    print("| mesh | points | samples | error | rho | us a point |\n|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="meander-prefixes-") as folder:
        eliminate = Eliminator(arguments.yuksel, Path(folder)) if arguments.yuksel else None
        for path in arguments.meshes:
            mesh = meander.read_mesh(path)
            area = meander.sample(mesh, n=1).area
            for k in arguments.taken:
                hexagonal = math.sqrt(2 * area / (math.sqrt(3) * k))
                found = {}
                for seed in range(1, arguments.sets + 1):
                    for name, points, seconds in sets_of(mesh, arguments.points, k, seed, eliminate):
                        error = meander.measure_boxes(points, mesh)
                        limit = error.limit
                        found.setdefault(name, []).append(
                            (error * error, smallest_distance(points.astype(float)) / hexagonal, 1e6 * seconds / k))
                print(f"| {path.stem} | {k} of {arguments.points} | limit | {limit:.3f} | 1 | |")
                for name, rows in found.items():
                    square, rho, each = np.mean(rows, axis=0)
                    print(f"| {path.stem} | {k} of {arguments.points} | {name} | {math.sqrt(square):.3f} | {rho:.2f} | "
                          f"{each:.0f} |", flush=True)


if __name__ == "__main__":
    main()
