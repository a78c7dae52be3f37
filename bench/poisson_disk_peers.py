#!/usr/bin/env python3
"""How sets of other samplers that keep points apart stand beside spaced samples: error over rotated boxes and spacing.

    poisson_disk_peers.py MEANDER MESH... [-n 1024 16384] [--sets 3] [--yuksel CYCODEBASE] [--program NAME=PROGRAM ...]
      [--json result.json]

For every mesh and number of points, sets of
  Yuksel's own code (--yuksel: the folder of github.com/cemyuksel/cyCodeBase), from five times as many random samples;
  farthest points, each the farthest from all before it, of ten times as many random samples;
  Open3D (sample_points_poisson_disk, its default), where Python can import it;
  each --program, called as PROGRAM MESH COUNT SEED FILE: writes about COUNT points to FILE (XYZ: a line of three numbers
  each) and prints the processor seconds of its sampler last;
  `meander run --sequence spaced --order curve`, and with `--finish relax`.
They are judged by `meander measure boxes` and `measure spacing`, on the same boxes: root mean square of the errors, and
that over the least that is known to be possible, mean rho, mean distance over that of the hexagonal lattice, largest hole
and Chamfer distance over its own, and the time that a sample takes one core (Meander: of a whole run with -j 1, reading and
writing included; others: of the elimination alone). Everything is relative to the points that a set has. Needs numpy, the
Python package of Meander (PYTHONPATH), and g++ for --yuksel. Exit status 1 when a run failed. Points of other programs are
judged the same way: write them as PLY or XYZ and give them to `meander measure`.
"""
import argparse
import functools
import json
import math
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import meander
import numpy as np

try:
    import open3d
except ImportError:
    open3d = None


def measured(program, measure, files, mesh):
    """The values of every set by column."""
    command = [program, "measure", measure, *map(str, files), "--surface", str(mesh), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit {done.returncode}\n{done.stderr[-2000:]}")
    results = json.loads(done.stdout)["results"]
    return {column: np.array([row[column] for row in results]) for column in results[0] if column != "set"}


def summary(program, files, mesh, area):
    boxes, spacing = measured(program, "boxes", files, mesh), measured(program, "spacing", files, mesh)
    hexagonal = np.sqrt(2 * area / (math.sqrt(3) * spacing["points"]))
    root_mean_square = {name: float(np.sqrt(np.mean(np.square(boxes[column]))))
                        for name, column in (("error", "error / random"), ("over limit", "over_limit"))}
    return {**root_mean_square, "rho": float(spacing["rho"].mean()), "least rho": float(spacing["rho"].min()),
            "mean distance": float((spacing["mean"] / hexagonal).mean()), "hole": float(spacing["hole"].mean()),
            "chamfer": float(spacing["chamfer"].mean()), "points of a set": float(spacing["points"].mean())}


def candidates(surface, count, seed):
    return meander.sample(surface, n=count, seed=seed, method="direct", sequence="random").coordinates()


def farthest_points(points, k):
    """k of (n, 3) points, each the farthest from all before it, and the seconds of one core that it took."""
    start = time.process_time()
    chosen, nearest = np.zeros(k, np.int64), np.full(len(points), np.inf, np.float32)
    for i in range(1, k):
        apart = points - points[chosen[i - 1]]
        np.minimum(nearest, np.einsum("ij,ij->i", apart, apart), out=nearest)
        chosen[i] = nearest.argmax()
    return points[chosen], time.process_time() - start


class Eliminator:
    """Yuksel's own code: k of (n, 3) points on a surface of this area, and the seconds of one core that it took."""

    def __init__(self, yuksel, scratch):
        self.scratch, self.program = scratch, scratch / "yuksel_elimination"
        subprocess.run(["g++", "-O3", "-march=native", "-w", "-I", str(yuksel),
                        str(Path(__file__).parent / "yuksel_elimination.cpp"), "-o", str(self.program)], check=True)

    def __call__(self, points, k, area):
        given, kept = self.scratch / "given.raw", self.scratch / "kept.raw"
        points.astype(np.float32).tofile(given)
        done = subprocess.run([self.program, given, kept, str(k), repr(area)], capture_output=True, text=True, check=True)
        return np.fromfile(kept, np.float32).reshape(-1, 3), float(done.stdout)


class Peers:
    """Functions of (mesh, surface, area, points, seed, file): write a set to the file, return the seconds of one core."""

    def __init__(self, program, yuksel, programs, scratch):
        self.program = program
        self.all = {}
        if yuksel:
            self.eliminate = Eliminator(yuksel, scratch)
            self.all["Yuksel's own code"] = (self.yuksel, ".npy")
        self.all["farthest points"] = (self.farthest, ".npy")
        if open3d:
            self.all["Open3D Poisson disk"] = (self.open3d, ".ply")
        for name, peer in programs:
            self.all[name] = (functools.partial(self.other, peer), ".xyz")
        self.all["spaced"] = (self.spaced, ".h5")
        self.all["spaced, relaxed"] = (functools.partial(self.spaced, options=("--finish", "relax")), ".h5")

    def yuksel(self, mesh, surface, area, points, seed, file):
        kept, seconds = self.eliminate(candidates(surface, 5 * points, seed), points, area)
        np.save(file, kept)
        return seconds

    def farthest(self, mesh, surface, area, points, seed, file):
        chosen, seconds = farthest_points(candidates(surface, 10 * points, seed).astype(np.float32), points)
        np.save(file, chosen)
        return seconds

    def open3d(self, mesh, surface, area, points, seed, file):
        triangles = open3d.io.read_triangle_mesh(str(mesh))
        open3d.utility.random.seed(seed)
        start = time.process_time()
        cloud = triangles.sample_points_poisson_disk(points)
        seconds = time.process_time() - start
        open3d.io.write_point_cloud(str(file), cloud)
        return seconds

    @staticmethod
    def other(peer, mesh, surface, area, points, seed, file):
        done = subprocess.run([peer, str(mesh), str(points), str(seed), str(file)], capture_output=True, text=True,
                              check=True)
        return float(done.stdout.split()[-1])

    def spaced(self, mesh, surface, area, points, seed, file, options=()):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([self.program, "run", str(mesh), "-o", str(file), "-n", str(points), "--seed", str(seed),
                        "--sequence", "spaced", "--order", "curve", "--fresh", "--progress", "none", "-j", "1", *options],
                       check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meander", help="the program", type=os.path.abspath)
    parser.add_argument("meshes", nargs="+", type=Path)
    parser.add_argument("-n", "--points", nargs="+", type=int, default=[1024, 16384])
    parser.add_argument("--sets", type=int, default=3)
    parser.add_argument("--yuksel", metavar="CYCODEBASE", type=Path)
    parser.add_argument("--program", metavar="NAME=PROGRAM", action="append", default=[])
    parser.add_argument("--json", metavar="FILE", help="all values")
    arguments = parser.parse_args()
    programs = [text.partition("=")[::2] for text in arguments.program]
    for name, peer in programs:
        if not name or not os.access(peer, os.X_OK):
            parser.error(f"--program {name}={peer}: NAME=PROGRAM is expected, a program that can be run")
    rows = []
    print(f"{'Open3D ' + open3d.__version__ if open3d else 'without Open3D'}, {arguments.sets} sets")
    print("| mesh | points | samples | of a set | error | over limit | rho (least) | mean distance | hole | chamfer "
          "| us a sample |\n|" + "---|" * 11)
    with tempfile.TemporaryDirectory(prefix="meander-peers-") as folder:
        peers = Peers(arguments.meander, arguments.yuksel, programs, Path(folder))
        for mesh in arguments.meshes:
            surface = meander.read_mesh(mesh)
            area = meander.sample(surface, n=1).area
            for points in arguments.points:
                for name, (make, suffix) in peers.all.items():
                    files = [Path(folder) / f"{seed}{suffix}" for seed in range(1, arguments.sets + 1)]
                    seconds = [make(mesh, surface, area, points, seed, file)
                               for seed, file in enumerate(files, 1)]
                    row = summary(arguments.meander, files, mesh, area)
                    row["us a sample"] = 1e6 * min(seconds) / row["points of a set"]
                    print(f"| {mesh.stem} | {points} | {name} | {row['points of a set']:.0f} | {row['error']:.3f} "
                          f"| {row['over limit']:.2f} | {row['rho']:.2f} ({row['least rho']:.2f}) "
                          f"| {row['mean distance']:.2f} | {row['hole']:.2f} | {row['chamfer']:.3f} "
                          f"| {row['us a sample']:.1f} |", flush=True)
                    rows.append({"mesh": mesh.stem, "points": points, "samples": name, **row})
        print("\nMeans over the meshes:")
        for points in arguments.points:
            for name in peers.all:
                of = [row for row in rows if row["points"] == points and row["samples"] == name]
                print(f"| {points} | {name} | " + " | ".join(
                    f"{np.mean([row[column] for row in of]):.3f}"
                    for column in ("error", "over limit", "rho", "mean distance", "hole", "chamfer", "us a sample")) + " |")
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(rows, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
