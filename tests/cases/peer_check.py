"""Compares areas and boxes with those that other programs give: Open3D for OBJ, STL, PLY and OFF, glTF-Transform for
glTF.

usage: peer_check.py MEANDER [--modules FOLDER] [--generated] [--packaged] [--json FILE] [PATH ...]
PATH: files and folders. --generated: the files of public_cases.py that are right by its table. --packaged: models of
the packages assimp-testmodels, geomview and glmark2-data, where they are installed. --modules, or
MEANDER_NODE_MODULES: a folder node_modules with @gltf-transform/core and @gltf-transform/extensions, draco3dgltf and
meshoptimizer (`npm install` them anywhere).
Prints each file that differs and counts. Exit code 1 when a file differs that KNOWN does not name, or when the other
program alone reads one of --generated; 77 (skipped) where neither of the two is installed.
"""
import argparse
import collections
import json
import os
import shutil
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy
except ImportError:
    sys.exit(77)

HERE = os.path.dirname(os.path.abspath(__file__))
TEXT_MODELS = (".obj", ".stl", ".ply", ".off")
GLTF_MODELS = (".gltf", ".glb")
PACKAGES = ("assimp-testmodels", "geomview", "glmark2-data")
# Relative: areas in float against double. Boxes: of the largest side or distance from the origin.
AREA_TOLERANCE, BOX_TOLERANCE = 1e-4, 1e-5

# Where the two differ for a known reason, by the end of the path.
KNOWN = {
    "obj_continued/a.obj": "Open3D joins the line behind a comment that ends in a backslash",
    "obj_weights/a.obj": "Open3D divides by the weight of rational curves",
    "text_fortran_exponents/a.obj": "Open3D ends a number at the D of its exponent",
    "OBJ/number_formats.obj": "3.1+e2 is no number; Open3D reads it as one",
    "OBJ/regr_3429812.obj": "Open3D leaves out the object that has polygons of different sizes",
    "derived_eight_far.off": "Open3D reads coordinates in single precision",
    "trimesh_fuze_ascii.ply": "Open3D stops at rows that are longer than the header says",
}


# One line of JSON for each file: a file that ends the process has only begun.
OPEN3D = r"""
import json, sys
import numpy, open3d
open3d.utility.set_verbosity_level(open3d.utility.VerbosityLevel.Error)
for path in json.load(open(sys.argv[1])):
    print(json.dumps(["begin", path]), flush=True)
    mesh = open3d.io.read_triangle_mesh(path)
    vertices, triangles = numpy.asarray(mesh.vertices), numpy.asarray(mesh.triangles).reshape(-1, 3)
    triangles = triangles[((triangles >= 0) & (triangles < len(vertices))).all(1)]
    corners = vertices[triangles].reshape(-1, 3, 3)
    corners = corners[numpy.isfinite(corners).all((1, 2))]
    sides = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = numpy.linalg.norm(sides, axis=1) / 2
    kept = corners[areas > 0].reshape(-1, 3)
    box = kept.min(0).tolist() + kept.max(0).tolist() if len(kept) else []
    print(json.dumps(["model", path, float(areas.sum()), box, len(corners)]), flush=True)
"""


def open3d_models(paths, scratch):
    """By path: (area, box, triangles), or None where it crashed. A file that crashes it ends only its own process."""
    found, left = {}, list(paths)
    while left:
        names = os.path.join(scratch, "names.json")
        json.dump(left, open(names, "w"))
        try:
            command = [sys.executable, "-c", OPEN3D, names]
            lines = subprocess.run(command, capture_output=True, text=True, timeout=3000).stdout
        except subprocess.TimeoutExpired as error:
            lines = (error.stdout or b"").decode()
        begun = None
        for line in lines.splitlines():
            if not line.startswith("["):
                continue
            entry = json.loads(line)
            begun = entry[1]
            if entry[0] == "model":
                found[begun] = tuple(entry[2:])
                begun = None
        if begun is not None:
            found[begun] = None
        remaining = [p for p in left if p not in found]
        if len(remaining) == len(left):
            return found
        left = remaining
    return found


def has_open3d():
    return subprocess.run([sys.executable, "-c", "import open3d"], capture_output=True).returncode == 0


def gltf_models(paths, modules, scratch):
    """By path: (area, box, triangles), or None where it cannot be read."""
    names = os.path.join(scratch, "gltf_names.json")
    json.dump(paths, open(names, "w"))
    command = ["node", os.path.join(HERE, "gltf_areas.mjs"), modules, names]
    result = subprocess.run(command, capture_output=True, text=True, timeout=3000)
    found = {}
    for line in result.stdout.splitlines():
        if line.startswith("["):
            path, *entry = json.loads(line)
            found[path] = tuple(entry) if entry[0] is not None else None
    if result.returncode != 0:
        print(result.stderr)
    return found


def meander_models(program, paths, scratch):
    """By path: (status, area, box, reason)."""
    rows = {}
    names = os.path.join(scratch, "paths")
    with open(names, "wb") as file:
        file.write(b"".join(os.fsencode(p) + b"\0" for p in paths))
    store = os.path.join(scratch, "peer.h5")
    result = subprocess.run([program, "run", "-0", "@" + names, "--root", "/", "-o", store, "-n", "16",
                             "--layout", "flat", "--progress", "none", "--topology", "none", "--fresh"],
                            capture_output=True, text=True)
    if not os.path.exists(store):
        sys.exit(f"the run failed: {result.stderr}")
    with h5py.File(store) as file:
        items = file["items"]
        statuses = {v: k for k, v in h5py.check_enum_dtype(items["status"].dtype).items()}
        columns = [items[name][:] for name in ("id", "status", "area", "bbox", "reason")]
        for i, status, area, box, reason in zip(*columns):
            rows[i.decode()] = (statuses[status], float(area), box.tolist(), reason.decode())
    return {path: rows.get(path.lstrip("/")) for path in paths}


def difference(ours, peer):
    """What differs, or an empty text; None where one of the two reads nothing."""
    if ours is None:
        return None
    status, area, box, _ = ours
    if peer is None or peer[2] == 0:
        return None
    if status != "ok":
        return "" if status == "zero_area" and peer[0] <= 1e-12 else None
    found = []
    if abs(area - peer[0]) > AREA_TOLERANCE * max(area, peer[0]):
        found.append(f"area {area:.8g} and {peer[0]:.8g}")
    size = max(1e-30, numpy.abs(numpy.asarray(box)).max())
    if peer[1] and numpy.abs(numpy.asarray(box) - numpy.asarray(peer[1])).max() > BOX_TOLERANCE * size:
        found.append("box " + " ".join(f"{v:.6g}" for v in box) + " and " + " ".join(f"{v:.6g}" for v in peer[1]))
    return "; ".join(found)


def packaged_models():
    paths = []
    for package in PACKAGES:
        if shutil.which("dpkg") is None:
            break
        listed = subprocess.run(["dpkg", "-L", package], capture_output=True, text=True)
        paths += [p for p in listed.stdout.splitlines() if p.lower().endswith(TEXT_MODELS + GLTF_MODELS)]
    return paths


def generated_models(scratch):
    import public_cases
    root = os.path.join(scratch, "generated")
    for c in public_cases.CASES:
        public_cases.write(os.path.join(root, c.name), c.files)
    paths = [os.path.join(root, c.name, path) for c in public_cases.CASES for path, row in c.rows.items()
             if row["status"] == "ok"]
    return [path for path in paths if os.path.exists(path)]  # others are members of archives


def models_below(path):
    if os.path.isfile(path):
        return [path]
    return [os.path.join(folder, name) for folder, _, names in os.walk(path) for name in names
            if name.lower().endswith(TEXT_MODELS + GLTF_MODELS)]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("paths", nargs="*")
    parser.add_argument("--modules", default=os.environ.get("MEANDER_NODE_MODULES", ""))
    parser.add_argument("--generated", action="store_true")
    parser.add_argument("--packaged", action="store_true")
    parser.add_argument("--json")
    arguments = parser.parse_intermixed_args()
    open3d = has_open3d()
    node = bool(arguments.modules and shutil.which("node") and
                os.path.isdir(os.path.join(arguments.modules, "@gltf-transform/core")))
    if not open3d and not node:
        print("skipped: neither python3-open3d nor a folder node_modules with @gltf-transform/core is there")
        return 77
    with tempfile.TemporaryDirectory() as scratch:
        generated = set(generated_models(scratch)) if arguments.generated else set()
        given = [m for p in arguments.paths for m in models_below(p)]
        given += packaged_models() if arguments.packaged else []
        paths = sorted({os.path.abspath(p) for p in given} | generated)
        text = [p for p in paths if p.lower().endswith(TEXT_MODELS)] if open3d else []
        gltf = [p for p in paths if p.lower().endswith(GLTF_MODELS)] if node else []
        if not text and not gltf:
            print("skipped: no model that the programs which are there read")
            return 77
        peers = open3d_models(text, scratch) if text else {}
        peers.update(gltf_models(gltf, arguments.modules, scratch) if gltf else {})
        ours = meander_models(arguments.program, text + gltf, scratch)
        counts, rows = collections.Counter(), []
        for path in text + gltf:
            peer, row = peers.get(path), ours[path]
            found = difference(row, peer)
            known = next((why for end, why in KNOWN.items() if path.endswith(end)), "")
            is_read, is_read_by_peer = row is not None and row[0] == "ok", peer is not None and peer[2] > 0
            if found is not None:
                kind = "agree" if not found else "known" if known else "differ"
            elif is_read_by_peer:
                kind = "known" if known else "other alone"
            else:
                kind = "meander alone" if is_read else "neither"
            counts["open3d" if path in set(text) else "gltf-transform", kind] += 1
            rows.append(dict(path=path, kind=kind, found=found or "", status=row[0] if row else "",
            reason=row[3] if row else "", known=known))
            if kind in ("differ", "other alone", "known"):
                said = found or (f"{row[0]} {row[3]}" if row else "there is no row")
                print(f"{kind}: {path}: {said}{' (' + known + ')' if known else ''}")
        for (program, kind), count in sorted(counts.items()):
            print(f"{program}: {count} {kind}")
        if arguments.json:
            json.dump(rows, open(arguments.json, "w"), indent=1)
        wrong = [r for r in rows if r["kind"] == "differ" or (r["kind"] == "other alone" and r["path"] in generated)]
        return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
