"""What the programs of the campaign share: small meshes in every format, folders, processes, and a count of what was
seen. Python's own library alone."""
import argparse
import json
import math
import os
import shutil
import signal
import struct
import subprocess
import sys
import time
from pathlib import Path

# ---- Meshes: (vertices, faces) ------------------------------------------------------------------------------------


def box(x=1.0, y=1.0, z=1.0):
    vertices = [(a, b, c) for a in (0, x) for b in (0, y) for c in (0, z)]
    return vertices, [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def torus(around, across, radius=0.4):
    vertices, faces = [], []
    for i in range(around):
        for j in range(across):
            u, v = 2 * math.pi * i / around, 2 * math.pi * j / across
            ring = 1 + radius * math.cos(v)
            vertices.append((ring * math.cos(u), ring * math.sin(u), radius * math.sin(v)))
            a, b = (i + 1) % around, (j + 1) % across
            faces += [(i * across + j, a * across + j, a * across + b),
                      (i * across + j, a * across + b, i * across + b)]
    return vertices, faces


def terrain(columns, rows):
    """A grid of quadrangles with a boundary."""
    vertices = [(i, j, 0.3 * math.sin(1.3 * i) * math.cos(0.7 * j)) for j in range(rows) for i in range(columns)]
    return vertices, [(j * columns + i, j * columns + i + 1, (j + 1) * columns + i + 1, (j + 1) * columns + i)
                      for j in range(rows - 1) for i in range(columns - 1)]


def soup(random, triangles):
    """Triangles that share nothing."""
    vertices = []
    for _ in range(triangles):
        center = [random.uniform(-1, 1) for _ in range(3)]
        vertices += [tuple(c + random.gauss(0, 0.2) for c in center) for _ in range(3)]
    return vertices, [(3 * t, 3 * t + 1, 3 * t + 2) for t in range(triangles)]


def together(*meshes):
    vertices, faces = [], []
    for their_vertices, their_faces in meshes:
        faces += [tuple(v + len(vertices) for v in face) for face in their_faces]
        vertices += their_vertices
    return vertices, faces


def triangles(faces):
    return [(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)]


# ---- Files ---------------------------------------------------------------------------------------------------------


def off_bytes(mesh):
    vertices, faces = mesh
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0"] + ["%.9g %.9g %.9g" % v for v in vertices]
    return ("\n".join(lines + [" ".join(map(str, (len(f),) + tuple(f))) for f in faces]) + "\n").encode()


def obj_bytes(mesh):
    vertices, faces = mesh
    lines = ["# a mesh", "o thing"] + ["v %.9g %.9g %.9g" % v for v in vertices] + ["vt 0 0", "vn 0 0 1", "usemtl m"]
    return ("\n".join(lines + ["f " + " ".join(f"{v + 1}/1/1" for v in f) for f in faces]) + "\n").encode()


def ply_bytes(mesh, form):
    """form: ascii, binary_little_endian or binary_big_endian."""
    vertices, faces = mesh
    head = f"ply\nformat {form} 1.0\ncomment a mesh\nelement vertex {len(vertices)}\n" + "".join(
        f"property {kind}\n" for kind in ("float x", "float y", "float z", "double quality"))
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    if form == "ascii":
        lines = ["%.9g %.9g %.9g 0.5" % v for v in vertices] + [" ".join(map(str, (len(f),) + tuple(f))) for f in faces]
        return (head + "\n".join(lines) + "\n").encode()
    order = "<" if form == "binary_little_endian" else ">"
    return head.encode() + b"".join(struct.pack(order + "fffd", *v, 0.5) for v in vertices) + b"".join(
        struct.pack(order + f"B{len(f)}i", len(f), *f) for f in faces)


def stl_bytes(mesh, text):
    vertices, faces = mesh
    if text:
        lines = ["solid thing"]
        for f in triangles(faces):
            lines += ["facet normal 0 0 0", "outer loop"] + ["vertex %.9g %.9g %.9g" % vertices[v] for v in f] + [
                "endloop", "endfacet"]
        return ("\n".join(lines + ["endsolid thing"]) + "\n").encode()
    corners = triangles(faces)
    return bytes(80) + struct.pack("<I", len(corners)) + b"".join(
        struct.pack("<12fH", 0, 0, 0, *vertices[f[0]], *vertices[f[1]], *vertices[f[2]], 0) for f in corners)


def glb_bytes(mesh):
    vertices, faces = mesh
    points = b"".join(struct.pack("<3f", *v) for v in vertices)
    corners = b"".join(struct.pack("<3I", *f) for f in triangles(faces))
    count = len(corners) // 4
    scene = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [0.5, 0, 0], "children": [1]}, {"mesh": 0, "scale": [1, 2, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(points) + len(corners)}],
        "bufferViews": [{"buffer": 0, "byteLength": len(points)},
                        {"buffer": 0, "byteOffset": len(points), "byteLength": len(corners)}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": len(vertices), "type": "VEC3",
                       "min": [-9, -9, -9], "max": [9, 9, 9]},
                      {"bufferView": 1, "componentType": 5125, "count": count, "type": "SCALAR"}]}
    text = json.dumps(scene).encode()
    text += b" " * (-len(text) % 4)
    binary = points + corners
    return (struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)) + struct.pack("<I4s", len(text), b"JSON")
            + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary)


def mesh_files(mesh):
    """The mesh in every format: pairs of extension and bytes."""
    return [(".off", off_bytes(mesh)), (".obj", obj_bytes(mesh)), (".ply", ply_bytes(mesh, "ascii")),
            (".ply", ply_bytes(mesh, "binary_little_endian")), (".ply", ply_bytes(mesh, "binary_big_endian")),
            (".stl", stl_bytes(mesh, True)), (".stl", stl_bytes(mesh, False)), (".glb", glb_bytes(mesh))]


def write_models(folder, count=3):
    """Small models of two classes and, behind them, one without faces; older than every run."""
    shapes = [box(), torus(8, 5), terrain(4, 3), together(box(0.5), torus(5, 4)), torus(11, 4, 0.2), box(3, 1, 0.1)]
    kinds = [(".off", off_bytes), (".ply", lambda m: ply_bytes(m, "binary_little_endian")), (".obj", obj_bytes)]
    for i in range(count):
        extension, write = kinds[i % len(kinds)]
        path = Path(folder) / ("round" if i % 2 else "square") / f"{i:03d}{extension}"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(write(shapes[i % len(shapes)]))
        os.utime(path, (1e9, 1e9))


# ---- Processes and folders -----------------------------------------------------------------------------------------


class Ended:
    """How a process ended: code (negative: the signal), out, err, peak_bytes, and whether it was hung."""

    def __init__(self, code, out, err, peak_bytes, hung):
        self.code, self.out, self.err, self.peak_bytes, self.hung = code, out, err, peak_bytes, hung


def run(command, cwd=None, environment=None, seconds=120, kill_after=None):
    """Runs to the end, or is killed after so many seconds: `seconds` is a hang, `kill_after` was asked for."""
    start = time.monotonic()
    with open(os.devnull, "rb") as nothing, TemporaryFiles() as files:
        process = subprocess.Popen([str(word) for word in command], cwd=cwd, stdin=nothing, stdout=files.out,
                                   stderr=files.err, env=None if environment is None else {**os.environ, **environment})
        hung, limit = False, seconds if kill_after is None else kill_after
        while True:
            pid, state, usage = os.wait4(process.pid, os.WNOHANG)
            if pid:
                break
            if time.monotonic() - start > limit:
                hung = kill_after is None
                os.kill(process.pid, signal.SIGKILL)  # process.kill() would take its state if it has just ended
                pid, state, usage = os.wait4(process.pid, 0)
                break
            time.sleep(0.0005 if time.monotonic() - start < 1 else 0.01)
        process.returncode = os.waitstatus_to_exitcode(state)
        return Ended(process.returncode, files.text(files.out), files.text(files.err), usage.ru_maxrss * 1024, hung)


class TemporaryFiles:
    """Where a process writes to: pipes would be full one day."""

    def __enter__(self):
        import tempfile
        self.out, self.err = tempfile.TemporaryFile(), tempfile.TemporaryFile()
        return self

    def __exit__(self, *_):
        self.out.close()
        self.err.close()

    @staticmethod
    def text(file):
        file.seek(0)
        return file.read().decode(errors="replace")


def content(folder):
    """Every file below a folder with its bytes."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(Path(folder).rglob("*"))
            if path.is_file()}


def copy_folder(source, target):
    shutil.rmtree(target, ignore_errors=True)
    shutil.copytree(source, target, symlinks=True)


# ---- Results -------------------------------------------------------------------------------------------------------


class Findings:
    """Prints what is wrong as it is found, and keeps what reproduces it."""

    def __init__(self, name, keep):
        self.name, self.keep, self.problems, self.start = name, Path(keep) if keep else None, [], time.monotonic()

    def add(self, what, *reproducers):
        self.problems.append(what)
        print(f"{self.name}: FOUND {what}", flush=True)
        if self.keep is None:
            return
        folder = self.keep / f"{self.name}-{len(self.problems):03d}"
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "what.txt").write_text(what + "\n")
        for path in reproducers:
            path = Path(path)
            if path.is_dir():
                shutil.copytree(path, folder / path.name, dirs_exist_ok=True)
            elif path.exists():
                shutil.copy(path, folder)

    def end(self, counts):
        """Prints the counts and ends the program: 0, or 1 when something was found."""
        seconds = time.monotonic() - self.start
        print(f"{self.name}: {counts}; {len(self.problems)} found, {seconds:.0f} s", flush=True)
        sys.exit(1 if self.problems else 0)


def arguments(description, **defaults):
    """A parser with what all programs of the campaign know."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meander", help="the program")
    parser.add_argument("--keep", help="a folder for what reproduces a finding")
    parser.add_argument("--seed", type=int, default=1)
    for name, (value, text) in defaults.items():
        parser.add_argument("--" + name.replace("_", "-"), type=type(value), default=value, help=text)
    return parser


def signal_name(code):
    return signal.Signals(-code).name if code < 0 else str(code)
