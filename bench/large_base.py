#!/usr/bin/env python3
"""A base of very many small models, queried and evaluated: time and memory of retrieval at scale.

    large_base.py MEANDER FOLDER [--models 100000] [--classes 200] [-n 128] [--describe d2] [--graph]
      [--memory-mib 2048] [--json result.json]

Writes FOLDER/models/CLASS/NUMBER.off: every class is a box, an ellipsoid, a torus or a cone with proportions
and a twist of its own, every model a perturbation of it in random position, 96 to 216 triangles. Then `meander
run --method direct --describe D` (of d2 64 bins), `retrieve query` and `retrieve evaluate`, each with its time and
peak memory and, the retrieve jobs, with an address space limited to --memory-mib; with --graph, `retrieve graph`
and one query and 101 by it instead. What stands in FOLDER already is taken as it is. Python's standard library
only. Exit status 1 when a step failed.
"""
import argparse
import json
import math
import os
import random
import resource
import shutil
import subprocess
import sys
import time
from pathlib import Path


class Failure(Exception):
    """A step that did not run."""


# ---- models --------------------------------------------------------------------------------------------------

def grid_mesh(around, along, point, closed):
    """A grid of points round and along; closed: round in both directions, else capped by two poles."""
    vertices, faces = [], []
    for j in range(along):
        for i in range(around):
            vertices.append(point(i / around, j / along if closed else (j + 1) / (along + 1)))
    rows = along if closed else along - 1
    for j in range(rows):
        for i in range(around):
            a, b = j * around + i, j * around + (i + 1) % around
            c, d = ((j + 1) % along) * around + i, ((j + 1) % along) * around + (i + 1) % around
            faces += [(a, b, d), (a, d, c)]
    if not closed:
        for end, row in ((0.0, 0), (1.0, along - 1)):
            pole = len(vertices)
            vertices.append(point(0.0, end))
            for i in range(around):
                a, b = row * around + i, row * around + (i + 1) % around
                faces.append((pole, b, a) if row == 0 else (pole, a, b))
    return vertices, faces


def superellipse(angle, power):
    """Point of a superellipse: power 1 a circle, small powers near a square."""
    c, s = math.cos(angle), math.sin(angle)
    return math.copysign(abs(c) ** power, c), math.copysign(abs(s) ** power, s)


def make_model(kind, shape, random_numbers):
    """shape: (two proportions, twist, bend) of the class; every model differs from it by some per cent."""
    vary = lambda value: value * math.exp(random_numbers.gauss(0, 0.05))
    a, b, twist, bend = vary(shape[0]), vary(shape[1]), vary(shape[2]), vary(shape[3])
    if kind == "torus":
        def point(u, v):
            r = 1 + 0.45 * a * math.cos(2 * math.pi * v)
            return (r * math.cos(2 * math.pi * u), b * r * math.sin(2 * math.pi * u),
                    0.45 * a * math.sin(2 * math.pi * v))
        vertices, faces = grid_mesh(12, 9, point, True)
    else:
        power = {"box": 0.2, "ellipsoid": 1.0, "cone": 1.0}[kind]
        def point(u, v):
            z, r = math.cos(math.pi * v), math.sin(math.pi * v)
            if kind == "box":
                r, z = superellipse(math.pi * (v - 0.5), 0.2)
            elif kind == "cone":
                z, r = 1 - 2 * v, v if v < 1 else 0.0
            x, y = superellipse(2 * math.pi * u, power)
            return r * x, a * r * y, (0.5 + 2 * b) * z
        vertices, faces = grid_mesh(9, 6, point, False)
    moved = []
    for x, y, z in vertices:
        angle = twist * z
        x, y = x * math.cos(angle) - y * math.sin(angle), x * math.sin(angle) + y * math.cos(angle)
        noise = [random_numbers.gauss(0, 0.01) for _ in range(3)]
        moved.append((x + bend * z * z + noise[0], y + noise[1], z + noise[2]))
    return moved, faces


def write_models(folder, models, classes):
    kinds = ["box", "ellipsoid", "torus", "cone"]
    for c in range(classes):
        of_class = random.Random(1000 + c)
        shape = (of_class.uniform(0.3, 1), of_class.uniform(0.3, 1), of_class.uniform(0, 1.5),
                 of_class.uniform(0, 0.6))
        kind = kinds[c % len(kinds)]
        into = folder / f"{kind}{c:04d}"
        into.mkdir(parents=True)
        for m in range(c, models, classes):
            vertices, faces = make_model(kind, shape, random.Random(m))
            lines = [f"OFF\n{len(vertices)} {len(faces)} 0"]
            lines += [f"{x:.5g} {y:.5g} {z:.5g}" for x, y, z in vertices]
            lines += [f"3 {p} {q} {r}" for p, q, r in faces]
            (into / f"{m:07d}.off").write_text("\n".join(lines) + "\n")


# ---- steps ---------------------------------------------------------------------------------------------------

def run_step(name, command, steps, memory_mib=0):
    """Runs the command, notes wall and processor seconds and peak memory, and returns its output."""
    def limit():
        if memory_mib:
            resource.setrlimit(resource.RLIMIT_AS, (memory_mib << 20, memory_mib << 20))
    start = time.perf_counter()
    child = subprocess.Popen(command, stdout=subprocess.PIPE, preexec_fn=limit)
    output = child.stdout.read()
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    if child.returncode != 0:
        raise Failure(f"{' '.join(command)}: exit {child.returncode}")
    steps[name] = {"seconds": time.perf_counter() - start, "cpu_seconds": usage.ru_utime + usage.ru_stime,
                   "peak_mib": usage.ru_maxrss / 1024, "limit_mib": memory_mib}
    step = steps[name]
    print(f"{name:9} {step['seconds']:9.1f} s  {step['cpu_seconds']:9.1f} s of processors  "
          f"{step['peak_mib']:7.0f} MiB" + (f" (limit {memory_mib})" if memory_mib else ""), flush=True)
    return output.decode()


def measure(arguments):
    folder = Path(arguments.folder).resolve()
    models, store, steps = folder / "models", folder / "base.h5", {}
    if not models.exists():
        start = time.perf_counter()
        unfinished = folder / "models.part"
        shutil.rmtree(unfinished, ignore_errors=True)
        write_models(unfinished, arguments.models, arguments.classes)
        unfinished.rename(models)
        print(f"{'write':9} {time.perf_counter() - start:9.1f} s  {arguments.models} models of "
              f"{arguments.classes} classes")
    if not store.exists():
        bins = ["--bins", "64"] if arguments.describe == "d2" else []
        run_step("run", [arguments.meander, "run", str(models), "-o", str(store), "-n", str(arguments.samples),
                         "--method", "direct", "--describe", arguments.describe, *bins, "--label-from-folder",
                         "--progress", "none"], steps)
    asked = ["--descriptor", arguments.describe, "--memory", f"{arguments.memory_mib}M", "--json"]
    retrieve = lambda action, *more, name=None: run_step(name or action, [arguments.meander, "retrieve", action, str(store),
                                                         *more, *asked], steps, arguments.memory_mib)
    if arguments.graph:
        graph = json.loads(retrieve("graph"))
        size = Path(graph["graph"]).stat().st_size / 2**20
        retrieve("query", "0", "--rank", "diffusion")
        retrieve("query", *map(str, range(101)), "--rank", "diffusion", name="101")
        print(f"{graph['models']} models, {graph['edges']} edges, {size:.0f} MiB")
        return 0
    query = retrieve("query", "0")
    text = retrieve("evaluate")
    answer = json.loads(text)
    scores = answer["results"][0]
    print(f"{answer['models']} models, {answer['classes']} classes: NN {scores['NN']:.3f}, 1st tier "
          f"{scores['1st tier']:.3f}, mAP {scores['mAP']:.3f}")
    if arguments.json:
        Path(arguments.json).write_text(json.dumps({"steps": steps, "models": answer["models"], "scores": scores,
                                                    "nearest": json.loads(query)["results"]}, indent=1) + "\n")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meander", help="the program")
    parser.add_argument("folder", help="folder for models and store; about 4.5 KB a model")
    parser.add_argument("--models", type=int, default=100000, help="how many (default 100000)")
    parser.add_argument("--classes", type=int, default=200, help="of how many classes (default 200)")
    parser.add_argument("-n", "--samples", type=int, default=128, help="samples per model (default 128)")
    parser.add_argument("--describe", default="d2", help="the descriptor (default d2)")
    parser.add_argument("--graph", action="store_true", help="make the graph of neighbors, and query by it")
    parser.add_argument("--memory-mib", type=int, default=2048, help="limit of the retrieve jobs (default 2048)")
    parser.add_argument("--json", metavar="FILE", help="times, memory and scores as JSON")
    arguments = parser.parse_args()
    arguments.meander = os.path.abspath(shutil.which(arguments.meander) or arguments.meander)
    try:
        return measure(arguments)
    except Failure as failure:
        print(f"large_base: {failure}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
