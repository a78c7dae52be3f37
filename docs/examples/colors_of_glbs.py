"""Samples GLB files with their colors into a store, as collections such as Objaverse have them, and reads them back.

    python3 colors_of_glbs.py [FOLDER]
"""
import json
import struct
import sys
from pathlib import Path

import numpy

import meander


def write_glb(path, vertices, triangles, colors):
    """vertices (V, 3); triangles (F, 3); colors (V, 3), real numbers in linear light."""
    arrays = [numpy.asarray(vertices, "<f4"), numpy.asarray(triangles, "<u4").reshape(-1), numpy.asarray(colors, "<f4")]
    views, accessors, data = [], [], b""
    for array, kind, component in zip(arrays, ("VEC3", "SCALAR", "VEC3"), (5126, 5125, 5126)):
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": array.nbytes})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(array), "type": kind})
        data += array.tobytes()
    accessors[0].update(min=arrays[0].min(axis=0).tolist(), max=arrays[0].max(axis=0).tolist())
    primitive = {"attributes": {"POSITION": 0, "COLOR_0": 2}, "indices": 1}
    text = json.dumps({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "scene": 0, "nodes": [{"mesh": 0}],
                       "meshes": [{"primitives": [primitive]}], "accessors": accessors, "bufferViews": views,
                       "buffers": [{"byteLength": len(data)}]}).encode()
    text += b" " * (-len(text) % 4)
    with open(path, "wb") as file:
        file.write(struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(data)))
        file.write(struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data)


folder = Path(sys.argv[1] if len(sys.argv) > 1 else "colors")
(folder / "glbs").mkdir(parents=True, exist_ok=True)
corners = numpy.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1.0]])
octahedron = numpy.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])
for name, colors in (("red", [[1, 0, 0]] * 6), ("blue", [[0, 0, 1]] * 6), ("graded", (corners + 1) / 2)):
    write_glb(folder / "glbs" / (name + ".glb"), corners, octahedron, colors)

result = meander.run(folder / "glbs", folder / "colors.h5", n=4096, colors=True, normalize="unit-sphere",
                     progress=lambda done, total, item: print("%d of %d: %s" % (done, total, item["status"])))
print(result)
with meander.open_store(folder / "colors.h5") as store:
    for item, source, rgb in zip(store.ids, store.color_sources, store.rgb):
        print("%s: from %s, mean color %s" % (item, source, rgb.mean(axis=0).round().astype(int).tolist()))
    print("files that miss something:", store.noted or "none")

one = meander.sample_file(folder / "glbs" / "graded.glb", 1024, colors=True)    # one file, without a store
print("%d points, %d without a color; the topmost is %s" % (len(one), one.color_fills,
                                                           one.rgb[one.points[:, 2].argmax()].tolist()))
