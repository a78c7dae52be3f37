#!/usr/bin/env python3
"""A user's notebook: samples a plane with a density, opens the store with plain h5py, integrates with /density.

    integrate_with_density.py MEANDER       exit status 77: h5py is not installed
"""
import subprocess
import sys
import tempfile
from pathlib import Path

try:
    import h5py
    import numpy
except ImportError:
    print("skipped: h5py is not installed")
    sys.exit(77)


def write_plane(path, cells):
    """The unit square with the vertex attribute weight = 1 + 3 x."""
    rows = [(i / cells, j / cells) for j in range(cells + 1) for i in range(cells + 1)]
    faces = []
    for j in range(cells):
        for i in range(cells):
            a = j * (cells + 1) + i
            faces += [(a, a + 1, a + cells + 2), (a, a + cells + 2, a + cells + 1)]
    header = ["ply", "format ascii 1.0", f"element vertex {len(rows)}", "property double x", "property double y",
              "property double z", "property double weight", f"element face {len(faces)}",
              "property list uchar int vertex_indices", "end_header"]
    body = [f"{x!r} {y!r} 0 {1 + 3 * x!r}" for x, y in rows] + ["3 %d %d %d" % face for face in faces]
    path.write_text("\n".join(header + body) + "\n")


def main():
    meander = sys.argv[1]
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        write_plane(folder / "plane.ply", 24)
        store = folder / "s.h5"
        subprocess.run([meander, "run", str(folder / "plane.ply"), "-o", str(store), "-n", "4096", "--density",
                        "attribute:weight", "--progress", "none"], check=True, stdout=subprocess.DEVNULL)
        with h5py.File(store, "r") as f:
            assert f["data"] == f["points"] and f["normal"] == f["normals"] and f["label"].shape == (1, 1)
            points = f["points"][0].astype(float)
            density = f["density"][0].astype(float)
            measure = f["items/measure"][0]
            area = f["items/area"][0]
        assert abs(area - 1) < 1e-12 and abs(measure - 2.5) < 1e-12, (area, measure)
        assert numpy.allclose(density, 1 + 3 * points[:, 0], atol=1e-5)
        # integral of g dA = measure / n x sum of g / density; closed forms over the unit square
        for name, g, exact in [("1", numpy.ones(len(points)), 1.0), ("x^2", points[:, 0] ** 2, 1 / 3),
                               ("x y", points[:, 0] * points[:, 1], 1 / 4)]:
            estimate = measure * numpy.mean(g / density)
            print(f"integral of {name}: {estimate:.5f}, exact {exact:.5f}")
            # random points would be off by about 0.7 % here; these are ten times better
            assert abs(estimate - exact) < 0.003 * exact, (name, estimate, exact)


main()
