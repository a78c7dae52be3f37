#!/usr/bin/env python3
"""How Open3D's Poisson disk sets stand beside spaced samples: error over rotated boxes and spacing, same boxes.

    poisson_disk_peers.py MEANDER MESH... [-n 1024 16384] [--sets 3] [--json result.json]

For every mesh and number of points: sets of Open3D (sample_points_poisson_disk from five times as many uniform
points, its default) and of `meander run --sequence spaced --order curve`, judged by `meander measure boxes` and
`measure spacing`: root mean square of the errors, mean rho, mean distance over that of the hexagonal lattice, and
the time that Open3D takes for a sample. Needs numpy and Open3D (Debian: python3-open3d). Exit status 1 when a run
failed. Points of other programs are judged the same way: write them as PLY or XYZ and give them to `meander measure`.
"""
import argparse
import json
import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import open3d


def measured(meander, measure, files, mesh, column):
    """One value of every set."""
    command = [meander, "measure", measure, *map(str, files), "--surface", str(mesh), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}: exit {done.returncode}\n{done.stderr[-2000:]}")
    return [row[column] for row in json.loads(done.stdout)["results"]]


def summary(meander, files, mesh, points, area):
    errors = measured(meander, "boxes", files, mesh, "error / random")
    hexagonal = math.sqrt(2 * area / (math.sqrt(3) * points))
    rho = measured(meander, "spacing", files, mesh, "rho")
    mean = measured(meander, "spacing", files, mesh, "mean")
    return {"error": math.sqrt(np.mean(np.square(errors))), "rho": float(np.mean(rho)), "least rho": min(rho),
            "mean distance": float(np.mean(mean)) / hexagonal}


def peer_sets(mesh, points, sets, scratch):
    surface = open3d.io.read_triangle_mesh(str(mesh))
    files, seconds = [], 0.0
    for seed in range(1, sets + 1):
        open3d.utility.random.seed(seed)
        start = time.perf_counter()
        cloud = surface.sample_points_poisson_disk(points)
        seconds += time.perf_counter() - start
        files.append(scratch / f"open3d{seed}.ply")
        open3d.io.write_point_cloud(str(files[-1]), cloud)
    return files, 1e6 * seconds / sets / points, surface.get_surface_area()


def own_sets(meander, mesh, points, sets, scratch):
    files = []
    for seed in range(1, sets + 1):
        files.append(scratch / f"spaced{seed}.h5")
        subprocess.run([meander, "run", str(mesh), "-o", str(files[-1]), "-n", str(points), "--seed", str(seed),
                        "--sequence", "spaced", "--order", "curve", "--fresh", "--progress", "none"],
                       check=True, capture_output=True)
    return files


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meander", help="the program")
    parser.add_argument("meshes", nargs="+", type=Path)
    parser.add_argument("-n", "--points", nargs="+", type=int, default=[1024, 16384])
    parser.add_argument("--sets", type=int, default=3)
    parser.add_argument("--json", metavar="FILE", help="all values")
    arguments = parser.parse_args()
    rows = []
    print(f"Open3D {open3d.__version__}, {arguments.sets} sets")
    print("| mesh | points | samples | error | rho (least) | mean distance | us a sample |\n|---|---|---|---|---|---|---|")
    for mesh in arguments.meshes:
        for points in arguments.points:
            with tempfile.TemporaryDirectory(prefix="meander-peers-") as folder:
                files, microseconds, area = peer_sets(mesh, points, arguments.sets, Path(folder))
                peer = summary(arguments.meander, files, mesh, points, area)
                own = summary(arguments.meander, own_sets(arguments.meander, mesh, points, arguments.sets,
                                                          Path(folder)), mesh, points, area)
            for name, row, shown in (("Open3D Poisson disk", peer, f"{microseconds:.0f}"), ("spaced", own, "")):
                print(f"| {mesh.stem} | {points} | {name} | {row['error']:.3f} | {row['rho']:.2f} "
                      f"({row['least rho']:.2f}) | {row['mean distance']:.2f} | {shown} |", flush=True)
                rows.append({"mesh": mesh.stem, "points": points, "samples": name, **row})
    if arguments.json:
        Path(arguments.json).write_text(json.dumps(rows, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
