#!/usr/bin/env python3
"""Signed distances beside what users of Python have: processor seconds on one thread, and how far results differ.

    distance_peers.py FOLDER... [--every 1] [--libigl INCLUDE] [--limit 60] [--json FILE]

For every --every-th model below each FOLDER, in order of the names: the 624,640 points of training_sets.py (two fifths
near the surface, one fifth near sharp edges, two fifths in the volume) are made once. Then they are labeled, one after
the other on one core, trees included, by `meander.signed_distance` (sign="auto", and "none"); by Open3D's
RaycastingScene, whose compute_distance is Embree's point query and whose compute_signed_distance counts the crossings
of a ray as well; and by igl::signed_distance with fast winding numbers (libigl_distances.cpp), which is stopped after
--limit seconds; these then count as its time. The table has median and largest seconds, the median of each one's
seconds over those of sign="auto", the largest difference of absolute distances (of half the longest side of the box),
and the share of points that have another side, of all and of those whose side is certain. Needs the meander module
(PYTHONPATH), numpy, Open3D, and g++ and Eigen for --libigl. Exit status 1 when no model was labeled.
"""
import argparse
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy
import open3d

import meander
from training_sets import QUERIES, models_below


def points_of(path, scratch):
    """Vertices, triangles and query points of one model, in the frame of its box: center, half the longest side. None where
    polygons have different numbers of corners, which the others do not take."""
    store = Path(scratch) / "points.h5"
    meander.run(path, store, n=1024, normalize="unit-box", queries=QUERIES, sign="none", fresh=True, threads=1)
    with meander.Store(store) as opened:
        if opened.file["items/status"][0] != 0:
            return None
        points = numpy.asarray(opened.file["queries/points"][0], dtype=numpy.float64)
        loc, scale = opened.file["items/loc"][0], opened.file["items/scale"][0]
    mesh = meander.read_mesh(path)
    if mesh.faces is None:
        return None
    vertices = numpy.asarray(mesh.vertices, dtype=numpy.float64)
    triangles = numpy.vstack([mesh.faces[:, [0, k, k + 1]] for k in range(1, mesh.faces.shape[1] - 1)])
    low, high = vertices.min(0), vertices.max(0)
    points = loc + scale * points
    center, half = (low + high) / 2, (high - low).max() / 2
    return (vertices - center) / half, triangles.astype(numpy.int32), (points - center) / half


def by_meander(vertices, triangles, points, sign):
    start = time.process_time()
    labels = meander.signed_distance(vertices, triangles, points, sign=sign, threads=1)
    return time.process_time() - start, labels


def by_open3d(vertices, triangles, points, signed):
    start = time.process_time()
    scene = open3d.t.geometry.RaycastingScene(nthreads=1)
    scene.add_triangles(open3d.core.Tensor(vertices.astype(numpy.float32)), open3d.core.Tensor(triangles.astype(numpy.uint32)))
    of = scene.compute_signed_distance if signed else scene.compute_distance
    distances = of(open3d.core.Tensor(points.astype(numpy.float32))).numpy()
    return time.process_time() - start, distances


def rays_hit():
    """Whether rays of this build of Open3D hit anything: those of Debian 12's package do not, so that it has no sides."""
    ball = open3d.t.geometry.TriangleMesh.from_legacy(open3d.geometry.TriangleMesh.create_sphere(1.0))
    scene = open3d.t.geometry.RaycastingScene()
    scene.add_triangles(ball)
    return scene.compute_signed_distance(open3d.core.Tensor(numpy.zeros((1, 3), numpy.float32))).item() < 0


class Libigl:
    def __init__(self, include, scratch, limit):
        self.limit, self.scratch, self.program = limit, Path(scratch), Path(scratch) / "libigl_distances"
        subprocess.run(["g++", "-O3", "-march=native", "-DNDEBUG", "-w", "-std=c++17", "-I", include, "-I",
                        "/usr/include/eigen3", str(Path(__file__).parent / "libigl_distances.cpp"), "-pthread", "-o",
                        str(self.program)], check=True)

    def __call__(self, vertices, triangles, points):
        files = [self.scratch / name for name in ("vertices", "faces", "points", "distances")]
        for values, file in zip((vertices, triangles, points), files):
            numpy.ascontiguousarray(values).tofile(file)
        try:
            done = subprocess.run([str(self.program), *map(str, files)], check=True, capture_output=True, text=True,
                                  timeout=self.limit)
        except subprocess.TimeoutExpired:
            return self.limit, None
        return float(done.stdout), numpy.fromfile(files[3])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("folders", nargs="+", type=Path)
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--libigl", metavar="INCLUDE")
    parser.add_argument("--limit", type=float, default=60)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])
    rows, left_out, has_sides = [], 0, rays_hit()
    if not has_sides:
        print("distance_peers: rays of this Open3D hit nothing: compute_signed_distance is left out", file=sys.stderr)
    with tempfile.TemporaryDirectory() as scratch:
        libigl = Libigl(given.libigl, scratch, given.limit) if given.libigl else None
        for model in (m for folder in given.folders for m in models_below(folder, given.every)):
            try:
                mesh = points_of(model, scratch)
            except meander.SamplingError:
                mesh = None
            if mesh is None:
                left_out += 1
                continue
            seconds, labels = by_meander(*mesh, "auto")
            triangles = mesh[1]
            taken, alone = by_meander(*mesh, "none")
            peers = {"meander, no sides": (taken, alone.distance), "Open3D compute_distance": by_open3d(*mesh, False)}
            if has_sides:
                peers["Open3D compute_signed_distance"] = by_open3d(*mesh, True)
            if libigl:
                peers["igl::signed_distance"] = libigl(*mesh)
            row = {"model": model.name, "triangles": len(triangles), "sign": labels.sign, "seconds": {"meander": seconds}}
            certain, ours = numpy.asarray(labels.certain, bool), numpy.asarray(labels.distance)
            for name, (taken, distances) in peers.items():
                row["seconds"][name] = taken
                if distances is None:
                    continue
                other = (distances < 0) != (ours < 0)
                row[name] = {"difference": float(numpy.abs(numpy.abs(distances) - numpy.abs(ours)).max()),
                             "other_sides": float(other.mean()), "other_certain_sides": float(other[certain].mean())}
            rows.append(row)
            print(json.dumps(row), file=sys.stderr, flush=True)
    if given.json:
        given.json.write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")
    if not rows:
        return 1
    print("%d models, %d without labels\n" % (len(rows), left_out))
    print("| | median s | largest s | median over ours | stopped | largest difference | other sides | of certain ones |")
    print("|---|---|---|---|---|---|---|---|")
    for name in rows[0]["seconds"]:
        seconds = [row["seconds"][name] for row in rows]
        cells = ["%.2f" % statistics.median(seconds), "%.2f" % max(seconds), "", "", "", "", ""]
        if name != "meander":
            done = [row[name] for row in rows if name in row]
            cells[2] = "%.1f" % statistics.median(row["seconds"][name] / row["seconds"]["meander"] for row in rows)
            cells[3] = str(len(rows) - len(done))
            cells[4] = "%.1g" % max(each["difference"] for each in done)
            if name not in ("meander, no sides", "Open3D compute_distance"):
                cells[5:] = ["%.2g %%" % (100 * statistics.mean(each[key] for each in done))
                             for key in ("other_sides", "other_certain_sides")]
        print("| %s | %s |" % (name, " | ".join(cells)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
