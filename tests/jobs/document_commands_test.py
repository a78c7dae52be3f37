"""Every command of README and the documents that needs no foreign data runs, as it is written, on generated models; and
docs/OPTIONS.md is what the program writes.

    document_commands_test.py SOURCES MEANDER

Left out, and counted: commands with placeholders in capitals or dots, and those that go on in a second line; `figures` is not
counted, as its own tests are shorter. Prints how many were run, of how many.
"""
import json
import math
import os
import re
import shlex
import struct
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

SOURCES, MEANDER = Path(sys.argv[1]), sys.argv[2]
COMMAND = re.compile(r"^    (meander (?!figures).*?)(?:\s+# .*)?$", re.MULTILINE)
PLACEHOLDER = re.compile(r"\b[A-Z]{3,}(?!v)[A-Z._0-9a-z]*\b(?<!ModelNet40)|\$|\.\.\.|\\$|\[|;")


def cube(shift):
    """Corners and quads of a box, each side cut into 4 x 4 faces, welded, pushed a little towards a ball."""
    points, faces, number = [], [], {}

    def vertex(p):
        key = tuple(round(c, 6) for c in p)
        if key not in number:
            number[key] = len(points)
            length = math.sqrt(sum(c * c for c in p))
            points.append([c * (1 + shift * (1 / length - 1)) for c in p])
        return number[key]

    for axis in range(3):
        for side in (-1, 1):
            for i in range(4):
                for j in range(4):
                    quad = []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = [0.0, 0.0, 0.0]
                        p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3] = side, a / 2 - 1, b / 2 - 1
                        quad.append(vertex(p))
                    faces.append(quad if side > 0 else quad[::-1])
    return points, faces


def write_off(path, shift, glued=False):
    points, faces = cube(shift)
    lines = ["OFF%s%d %d 0" % ("" if glued else "\n", len(points), len(faces))]
    lines += ["%.6g %.6g %.6g" % tuple(p) for p in points] + ["4 %d %d %d %d" % tuple(f) for f in faces]
    put(path, "\n".join(lines) + "\n")


def write_obj(path, shift, material=False):
    points, faces = cube(shift)
    lines = ["mtllib %s.mtl" % path.stem, "usemtl paint"] if material else []
    lines += ["v %.6g %.6g %.6g" % tuple(p) for p in points]
    lines += ["vt %.4g %.4g" % (p[0] / 2 + 0.5, p[1] / 2 + 0.5) for p in points]
    lines += ["f " + " ".join("%d/%d" % (c + 1, c + 1) for c in face) for face in faces]
    put(path, "\n".join(lines) + "\n")
    if material:
        put(path.with_suffix(".mtl"), "newmtl paint\nKd 0.2 0.4 0.8\n")


def write_stl(path, shift):
    points, faces = cube(shift)
    triangles = [(f[0], f[k], f[k + 1]) for f in faces for k in (1, 2)]
    data = bytes(80) + struct.pack("<I", len(triangles))
    for t in triangles:
        data += struct.pack("<12fH", 0, 0, 0, *(c for v in t for c in points[v]), 0)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def write_ply(path, shift):
    """With the attributes that the documents name: quality, flow_x to flow_z, grain_xx to grain_zz, texture coordinates."""
    points, faces = cube(shift)
    names = ["x", "y", "z", "quality", "flow_x", "flow_y", "flow_z",
             "grain_xx", "grain_xy", "grain_xz", "grain_yy", "grain_yz", "grain_zz", "s", "t"]
    lines = ["ply", "format ascii 1.0", "element vertex %d" % len(points)] + ["property float " + n for n in names]
    lines += ["element face %d" % len(faces), "property list uchar int vertex_indices", "end_header"]
    lines += [" ".join("%.6g" % v for v in [*p, p[2], 1, 0, p[0], 2, 0, 0, 1, 0, 1, p[0], p[1]]) for p in points]
    lines += ["4 %d %d %d %d" % tuple(f) for f in faces]
    put(path, "\n".join(lines) + "\n")


def write_glb(path, shift):
    points, faces = cube(shift)
    triangles = [c for f in faces for k in (1, 2) for c in (f[0], f[k], f[k + 1])]
    place = b"".join(struct.pack("<3f", *p) for p in points)
    color = b"".join(struct.pack("<3f", *(c / 2 + 0.5 for c in p)) for p in points)
    index = b"".join(struct.pack("<I", t) for t in triangles)
    low, high = ([f(p[k] for p in points) for k in range(3)] for f in (min, max))
    views, at = [], 0
    for part in (place, color, index):
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(part)})
        at += len(part)
    accessors = [{"bufferView": 0, "componentType": 5126, "count": len(points), "type": "VEC3", "min": low, "max": high},
                 {"bufferView": 1, "componentType": 5126, "count": len(points), "type": "VEC3"},
                 {"bufferView": 2, "componentType": 5125, "count": len(triangles), "type": "SCALAR"}]
    mesh = {"primitives": [{"attributes": {"POSITION": 0, "COLOR_0": 1}, "indices": 2}]}
    text = json.dumps({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                       "meshes": [mesh], "accessors": accessors, "bufferViews": views,
                       "buffers": [{"byteLength": at}]}).encode()
    text += b" " * (-len(text) % 4)
    data = place + color + index
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data))
                     + struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data)


def put(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def fill(folder):
    """The files that the commands name."""
    for name, shift in (("chair/m12", 0.1), ("chair/m13", 0.2), ("chair/m14", 0.3), ("table/m1", 0.8), ("table/m2", 0.9)):
        write_off(folder / "models" / (name + ".off"), shift)
    for split in ("train", "test"):
        for name, shift in (("chair", 0.2), ("sofa", 0.7)):
            write_off(folder / "ModelNet40" / name / split / ("%s_%s.off" % (name, split)), shift, glued=True)
    put(folder / "modelnet40_train.txt", "chair_train\nsofa_train\n")
    put(folder / "modelnet40_test.txt", "chair_test\nsofa_test\n")
    for number, name in enumerate(("02691156/10155655850468db78d106ce0a280f87", "03001627/1a6f615e8b1b5ae4dbbc9440457e303e")):
        write_obj(folder / "ShapeNetCore.v2" / name / "models/model_normalized.obj", 0.3 * number, material=True)
    put(folder / "ShapeNetCore.v2/all.csv", "id,synsetId,subSynsetId,modelId,split\n"
        "1,02691156,02691156,10155655850468db78d106ce0a280f87,train\n2,03001627,03001627,1a6f615e8b1b5ae4dbbc9440457e303e,val\n")
    with zipfile.ZipFile(folder / "ShapeNetCore.v2.zip", "w") as archive:
        for path in sorted((folder / "ShapeNetCore.v2").rglob("*")):
            archive.write(path, path.relative_to(folder))
    uids = ["8476c4170df24cf5bbe6967222d1a42d", "9476c4170df24cf5bbe6967222d1a42d"]
    for number, uid in enumerate(uids):
        for glbs in (folder / "glbs", folder / ".objaverse/hf-objaverse-v1/glbs"):
            write_glb(glbs / "000-023" / (uid + ".glb"), 0.4 * number)
    put(folder / "lvis-annotations.json", json.dumps({"chair": uids[:1], "sofa": uids[1:]}))
    subprocess.run(["gzip", folder / "lvis-annotations.json"], check=True)
    put(folder / "held_out.txt", uids[0] + "\n")
    write_ply(folder / "scans/scan.ply", 0.5)
    write_obj(folder / "chair.obj", 0.6)
    write_off(folder / "bunny.off", 0.6)
    write_stl(folder / "mine.stl", 0.25)
    write_off(folder / "more/other.off", 0.35)
    points, faces = cube(0.6)
    middles = [[sum(points[f[k]][axis] for k in range(3)) / 3 for axis in range(3)] for f in faces]
    put(folder / "theirs.ply", "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
        "property float z\nend_header\n" % len(middles) + "".join("%.9g %.9g %.9g\n" % tuple(p) for p in middles))
    put(folder / "test.cla", "PSB 1\n2 5\nchair 0 3\n12\n13\n14\ntable 0 2\n1\n2\n")
    put(folder / "patches/plane.nurbs", "degree 1 1\nknots_u 0 0 1 1\nknots_v 0 0 1 1\n"
        "point 0 0 0\npoint 0 1 0\npoint 1 0 0\npoint 1 1 0.5\n")


# What these end with: two of 64 shards of an array are not the whole of it.
EXPECTED = {"meander status set.h5.run": 75, "meander merge set.h5.run": 75, "meander merge all.h5.run": 75}
# Commands that go on with the store of a command that was left out, or need more rows than there are.
LEFT_OUT = {"meander retrieve select c.h5 --most 3",
            "meander export base.h5 --descriptors d2 --format ann-hdf5 --queries 1000 --neighbors 100 -o base.hdf5"}

# Where a document needs another folder `models/`, or files that earlier commands of other documents make.
PREPARED = {
    "docs/ANISOTROPIC.md": lambda folder: [write_ply(folder / "models/grain.ply", 0.5), remove_off(folder)],
    "docs/STORE.md": lambda folder: run(folder, "meander run models/ -o store.h5 -n 256"),
    "docs/COLUMNS.md": lambda folder: run(folder, "meander run glbs/ -o store.h5 -n 256 --colors"),
    "docs/VIEWER.md": lambda folder: run(folder, "meander run models/ -o store.h5 -n 256"),
}


def remove_off(folder):
    for path in (folder / "models").rglob("*.off"):
        path.unlink()


def run(folder, command):
    command = command.replace("meander", shlex.quote(MEANDER), 1)
    return subprocess.run(["bash", "-c", command], cwd=folder, env=dict(os.environ, HOME=str(folder)), capture_output=True,
                          text=True)


def has_its_package(command):
    return all(os.path.exists(word) for word in shlex.split(command) if word.startswith("/usr/"))


def options_page_differs():
    """Whether docs/OPTIONS.md is another one than the program writes."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([MEANDER, "pages", folder], check=True, stdout=subprocess.DEVNULL)
        return (Path(folder) / "doc/meander/OPTIONS.md").read_text() != (SOURCES / "docs/OPTIONS.md").read_text()


def main():
    failed, ran, all_commands = [], 0, 0
    if options_page_differs():
        failed.append("docs/OPTIONS.md differs from share/doc/meander/OPTIONS.md of `meander pages share`: copy it")
    documents = [SOURCES / "README.md", *sorted((SOURCES / "docs").glob("*.md"))]
    for document in documents:
        name = str(document.relative_to(SOURCES))
        commands = COMMAND.findall(document.read_text())
        all_commands += len(commands)
        commands = [c for c in commands if not PLACEHOLDER.search(c) and c not in LEFT_OUT and has_its_package(c)]
        if not commands:
            continue
        with tempfile.TemporaryDirectory() as scratch:
            folder = Path(scratch)
            fill(folder)
            if name in PREPARED:
                PREPARED[name](folder)
            for command in commands:
                done = run(folder, command)
                ran += 1
                if done.returncode != EXPECTED.get(command, 0):
                    failed.append("%s: %s\n  exit %d: %s" % (name, command, done.returncode, (done.stderr or done.stdout)[-600:]))
    print("%d of %d commands of the documents were run" % (ran, all_commands))
    print("\n".join(failed))
    return 1 if failed or ran < 40 else 0


if __name__ == "__main__":
    sys.exit(main())
