#!/usr/bin/env python3
"""The package meander, from the folder of PYTHONPATH, beside the program.

    module_test.py MEANDER SHARED_DATA       exit status 77: numpy is not installed
"""
import concurrent.futures
import copy
import csv
import gc
import hashlib
import inspect
import json
import multiprocessing
import pickle
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time
import types
import unittest
from pathlib import Path

try:
    import numpy
except ImportError:
    print("skipped: numpy is not installed")
    sys.exit(77)
try:
    import h5py
except ImportError:
    h5py = None

import meander

PROGRAM, SHARED = "", Path()
CUBE = numpy.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
QUADS = numpy.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])


def bumpy_sphere(rings=40, columns=64):
    """A closed mesh of 2 (rings - 1) columns triangles."""
    points = [(0.0, 0.0, 1.0)]
    for i in range(1, rings):
        for j in range(columns):
            t, p = numpy.pi * i / rings, 2 * numpy.pi * j / columns
            r = 1 + 0.2 * numpy.sin(5 * p) * numpy.sin(t) ** 3
            points.append((r * numpy.sin(t) * numpy.cos(p), r * numpy.sin(t) * numpy.sin(p), numpy.cos(t)))
    points.append((0.0, 0.0, -1.0))
    at = lambda i, j: 1 + (i - 1) * columns + j % columns
    faces = [(0, at(1, j), at(1, j + 1)) for j in range(columns)]
    for i in range(1, rings - 1):
        for j in range(columns):
            faces += [(at(i, j), at(i + 1, j), at(i + 1, j + 1)), (at(i, j), at(i + 1, j + 1), at(i, j + 1))]
    faces += [(len(points) - 1, at(rings - 1, j + 1), at(rings - 1, j)) for j in range(columns)]
    return numpy.array(points), numpy.array(faces)


def write_colored_ply(path, vertices, faces, color):
    """One color for all vertices."""
    path.write_text("\n".join(
        ["ply", "format ascii 1.0", "element vertex %d" % len(vertices)] + ["property float " + name for name in "xyz"]
        + ["property uchar " + name for name in ("red", "green", "blue")]
        + ["element face %d" % len(faces), "property list uchar int vertex_indices", "end_header"]
        + ["%r %r %r %d %d %d" % (*map(float, v), *color) for v in vertices]
        + [" ".join(map(str, [len(f), *f])) for f in faces]) + "\n")


def write_off(path, vertices, faces):
    path.write_text("\n".join(["OFF", "%d %d 0" % (len(vertices), len(faces))]
                              + ["%r %r %r" % tuple(float(x) for x in v) for v in vertices]
                              + [" ".join(map(str, [len(f), *f])) for f in faces]) + "\n")


def read_off(path):
    words = path.read_text().split()
    assert words[0] == "OFF"
    v, f = int(words[1]), int(words[2])
    vertices = numpy.array(words[4:4 + 3 * v], dtype=float).reshape(v, 3)
    return vertices, numpy.array(words[4 + 3 * v:4 + 3 * v + 4 * f], dtype=numpy.int64).reshape(f, 4)[:, 1:]


def run_program(folder, *arguments):
    store = Path(folder) / "store.h5"
    subprocess.run([PROGRAM, *map(str, arguments), "-o", str(store), "--progress", "none", "--fresh"], check=True,
                   stdout=subprocess.DEVNULL)
    return store


ROW = {"points": "points", "normals": "normals", "face_index": "face_index", "corners": "corners",
       "barycentric": "barycentric", "curve_rank": "curve_rank", "density": "density"}


class WithMeshes(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.path = Path(self.folder.name)
        self.addCleanup(self.folder.cleanup)

    def assert_row(self, samples, store, row=0):
        with h5py.File(store) as f:
            for name, member in ROW.items():
                stored = f[name][row]
                mine = getattr(samples, member)
                self.assertEqual(stored.dtype, mine.dtype, name)
                self.assertEqual(stored.tobytes(), numpy.ascontiguousarray(mine).tobytes(), name)
            self.assertEqual(f["items/area"][row], samples.area)
            self.assertEqual(f["items/measure"][row], samples.measure)
            self.assertEqual(f["items/content_sha256"][row].tobytes(), samples.content)


@unittest.skipIf(h5py is None, "skipped: h5py is not installed")
class SameAsTheProgram(WithMeshes):
    VARIANTS = [
        ([], {}),
        (["--method", "direct", "--seed", "7", "--order", "curve"], dict(method="direct", seed=7, order="curve")),
        (["--method", "conformal", "--density", "mean"], dict(method="conformal", density="mean")),
        (["--sequence", "spaced", "--spacing", "fast"], dict(sequence="spaced", spacing="fast")),
        (["--density", "unit-formula:0.1 + z^2"], dict(density="unit-formula:0.1 + z^2")),
        (["--method", "anisotropic", "--normalize", "unit-sphere"],
         dict(method="anisotropic", normalize="unit-sphere")),
        (["--normalize", "unit-diagonal"], dict(normalize="unit-diagonal")),
        (["--normalize", "pointnet", "--order", "curve"], dict(normalize="pointnet", order="curve")),
        (["--normalize", "pointnet", "--curved"], dict(normalize="pointnet", curved=True)),
        (["--topology", "none"], dict(topology=False)),
        (["--curved", "--curve", "hilbert", "--method", "direct"], dict(curved=True, curve="hilbert", method="direct")),
    ]

    def test_a_file_has_the_rows_of_the_program(self):
        vertices, faces = bumpy_sphere()
        file = self.path / "sphere.off"
        write_off(file, vertices, faces)
        content = hashlib.sha256(file.read_bytes()).digest()
        self.assertEqual(content, meander.content_of(file))
        for arguments, options in self.VARIANTS:
            with self.subTest(options=options):
                store = run_program(self.path, "run", file, "-n", 777, *arguments)
                self.assert_row(meander.sample(vertices, faces, 777, content=content, **options), store)
                self.assert_row(meander.sample(vertices, faces, 777, content=content.hex(), threads=1, **options), store)
                self.assert_row(meander.sample(meander.read_mesh(file), n=777, **options), store)

    def test_files_with_normals_and_polygons_have_the_rows_of_the_program(self):
        file = self.path / "cube.obj"
        lines = ["v %r %r %r" % tuple(v) for v in CUBE.tolist()]
        lines += ["vn %r %r %r" % tuple(v) for v in (2 * CUBE - 1).tolist()]
        file.write_text("\n".join(lines + ["f " + " ".join("%d//%d" % (c + 1, c + 1) for c in q) for q in QUADS]))
        store = run_program(self.path, "run", file, "-n", 500)
        self.assert_row(meander.sample(meander.read_mesh(file), n=500), store)
        content = meander.content_of(file)
        self.assert_row(meander.sample(CUBE, QUADS, 500, normals=2 * CUBE - 1, content=content), store)
        [many] = meander.sample_many([file], 500)
        self.assert_row(many, store)
        mesh = meander.read_mesh(file)
        self.assertTrue((mesh.vertices == CUBE).all() and (mesh.faces == QUADS).all())

    def test_sample_file_has_colors_and_attributes_as_the_program_stores_them(self):
        folder = self.path / "textured"
        folder.mkdir()
        square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
        (folder / "a.obj").write_text("mtllib a.mtl\n" + square + "usemtl red\no seat\nf 1/1 2/2 3/3\no leg\nusemtl blue\nf 1/1 3/3 4/4\n")
        (folder / "a.mtl").write_text("newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\nmap_Kd missing.png\n")
        write_colored_ply(folder / "b.ply", CUBE, QUADS, [9, 60, 200])
        archive = shutil.make_archive(str(self.path / "packed"), "zip", folder)
        for file, taken in ((folder / "a.obj", ("object", "material")), (folder / "b.ply", ()), (Path(archive) / "b.ply", ())):
            with self.subTest(str(file)):
                store = run_program(self.path, "run", file, "-n", 300, "--colors", "--texcoord", *(
                    word for name in taken for word in ("--attribute", name)))
                s = meander.sample_file(file, 300, colors=True, texcoord=True, attributes=taken)
                self.assert_row(s, store)
                with meander.open_store(store) as stored:
                    row = stored[0]
                    self.assertEqual(s.rgb.tobytes(), row["rgb"].tobytes())
                    self.assertEqual(s.texcoord.tobytes(), row["texcoord"].tobytes())
                    self.assertEqual((s.names, s.color_source), (stored.names(0), stored.color_sources[0]))
                    self.assertEqual({**s.notes, **({"text": s.note_text} if s.notes else {})}, stored.notes(0))
                    self.assertEqual(sorted(s.attributes), sorted(taken))
                    for name in taken:
                        self.assertEqual(s.attributes[name].dtype, numpy.int32)
                        self.assertEqual(s.attributes[name].tobytes(), row["attributes"][name].tobytes())
        [many] = meander.sample_many([folder / "b.ply"], 300, colors=True)
        self.assertTrue((many.rgb == [9, 60, 200]).all())
        self.assertEqual(len(meander.sample_file(folder / "a.obj", 50, density="formula:1 + u")), 50)
        graded = meander.sample_file(folder / "b.ply", 500, density=lambda p: p[:, 2] == 1, density_at="faces")
        self.assertEqual(float(graded.points[:, 2].min()), 1)
        with self.assertRaisesRegex(TypeError, "colors: taken over from files, not from arrays"):
            list(meander.sample_many([(CUBE, QUADS)], colors=True))
        with self.assertRaisesRegex(ValueError, "colors are for arrays: a Mesh has its own, which sample_file"):
            meander.sample(meander.read_mesh(folder / "b.ply"), colors=CUBE)
        with self.assertRaisesRegex(ValueError, "`x:9` has `9` behind its name"):
            meander.sample_file(folder / "b.ply", attributes="x:9")
        with self.assertRaises(meander.SamplingError) as caught:
            meander.sample_file(self.path / "none.off")
        self.assertEqual(caught.exception.status, "unreadable")

    def test_descriptors_equal_those_of_the_program(self):
        vertices, faces = bumpy_sphere()
        write_off(self.path / "sphere.off", vertices, faces)
        store = run_program(self.path, "run", self.path / "sphere.off", "-n", 512, "--describe", "d2,pairs,basics",
                            "--bins", 64)
        made = meander.describe(vertices, faces, ["d2", "pairs", "basics"], n=512, bins=64,
                                content=meander.content_of(self.path / "sphere.off"))
        with h5py.File(store) as f:
            self.assertEqual(set(f["descriptors"]), set(made))
            for name, values in made.items():
                self.assertEqual(f["descriptors"][name][0].tobytes(), values.tobytes(), name)

    def test_surfaces_equal_those_of_the_program(self):
        for options, arguments in [({}, []), (dict(density="gaussian", curve="peano"),
                                              ["--density", "gaussian", "--curve", "peano"])]:
            store = self.path / "surface.h5"
            subprocess.run([PROGRAM, "surface", "torus", "-n", "600", "-o", store, "--fresh", *arguments], check=True,
                           stdout=subprocess.DEVNULL)
            samples = meander.surface("torus", 600, **options)
            with h5py.File(store) as f:
                for name in ("points", "normals", "uv", "curve_rank", "density"):
                    self.assertEqual(f[name][0].tobytes(), getattr(samples, name).tobytes(), name)
                self.assertEqual(f["items/area"][0], samples.area)

    def test_the_bunny_has_the_row_of_the_program(self):
        file = SHARED / "bunny_closed.off"
        if not file.exists():
            self.skipTest("skipped: there is no " + str(file))
        vertices, faces = read_off(file)
        store = run_program(self.path, "run", file)
        content = hashlib.sha256(file.read_bytes()).digest()
        self.assert_row(meander.sample(vertices, faces, content=content), store)

    def test_points_are_written_as_the_program_exports_them(self):
        vertices, faces = bumpy_sphere()
        write_off(self.path / "sphere.off", vertices, faces)
        store = run_program(self.path, "run", self.path / "sphere.off", "-n", 200, "--colors", "--normalize", "unit-box")
        samples = meander.sample_file(self.path / "sphere.off", 200, colors=True, normalize="unit-box")
        for ending in ("ply", "off", "xyz"):
            exported, written = self.path / ("exported." + ending), self.path / ("written." + ending.upper())
            subprocess.run([PROGRAM, "export", store, "-o", exported, "--fresh"], check=True, capture_output=True)
            meander.write_points(written, samples)
            self.assertEqual(exported.read_bytes(), written.read_bytes(), ending)
        # Any points, far from the origin, with colors of their own.
        meander.write_points(self.path / "far.ply", samples.coordinates() + 1e7, colors=numpy.eye(200, 3, dtype="u1"))
        content = (self.path / "far.ply").read_bytes()
        rows = numpy.frombuffer(content[content.index(b"end_header\n") + 11:],
                                [("places", "<f8", 3), ("rgb", "u1", 3)])
        self.assertLess(abs(rows["places"] - 1e7 - samples.coordinates()).max(), 1e-6)
        self.assertEqual(rows["rgb"].tolist(), numpy.eye(200, 3, dtype="u1").tolist())
        before = (self.path / "far.ply").read_bytes()
        for arguments, keywords, message in (
                (("far.obj", samples), {}, "ends in none of .ply, .off, .xyz"),
                (("far.ply", numpy.zeros((0, 3))), {}, "points must be one or more"),
                (("far.ply", numpy.full((2, 3), numpy.inf)), {}, "finite"),
                (("far.ply", samples), {"normals": numpy.zeros((3, 3))}, "normals has 3 rows for 200 points"),
                (("far.ply", samples), {"colors": numpy.zeros((3, 3))}, "colors has 3 rows for 200"),
                (("far.xyz", samples.points), {}, "an .xyz file has a normal at each point")):
            with self.assertRaisesRegex(ValueError, message):
                meander.write_points(self.path / arguments[0], *arguments[1:], **keywords)
        self.assertEqual((self.path / "far.ply").read_bytes(), before)
        with self.assertRaises(OSError):
            meander.write_points(self.path / "missing/far.ply", samples)

    def test_measure_boxes_equals_the_program(self):
        vertices, faces = bumpy_sphere()
        write_off(self.path / "sphere.off", vertices, faces)
        store = run_program(self.path, "run", self.path / "sphere.off", "-n", 1000)
        said = subprocess.run([PROGRAM, "measure", "boxes", store, "--surface", self.path / "sphere.off", "--csv",
                               self.path / "boxes.csv"], capture_output=True, text=True)
        samples = meander.sample(meander.read_mesh(self.path / "sphere.off"), n=1000)
        if "laboratory" in said.stderr:
            with self.assertRaisesRegex(RuntimeError, "laboratory"):
                meander.measure_boxes(samples.coordinates(), vertices, faces)
            return
        self.assertEqual(said.returncode, 0, said.stderr)
        error, limit, over_limit = map(float, (self.path / "boxes.csv").read_text().splitlines()[1].split(",")[3:])
        found = meander.measure_boxes(samples.coordinates(), vertices, faces)
        for one in (found, pickle.loads(pickle.dumps(found)), copy.copy(found)):
            self.assertIsInstance(one, float)
            self.assertAlmostEqual(one, error, 4)
            self.assertAlmostEqual(one.limit, limit, 6)
            self.assertAlmostEqual(one.over_limit, over_limit, 3)
        self.assertEqual(json.loads(json.dumps({"error": found}))["error"], float(found))
        self.assertLess(0.1, limit)  # 1.2 to 1.6 times the limit
        self.assertLess(limit, 0.9 * error)


class Arrays(unittest.TestCase):
    def test_any_array_type_and_layout_gives_the_same_samples(self):
        expected = meander.sample(CUBE, QUADS, 200)
        variants = [(CUBE.astype(numpy.float32), QUADS.astype(numpy.uint8)), (CUBE.tolist(), QUADS.tolist()),
                    (numpy.asfortranarray(CUBE), QUADS.astype(numpy.int16)), (CUBE.astype(">f8"), QUADS.astype(">i8")),
                    (CUBE[::-1][::-1], numpy.repeat(QUADS, 2, axis=0)[::2]), (CUBE.astype(int), QUADS.astype("u8")),
                    (CUBE.astype(numpy.longdouble), QUADS.astype("u4"))]
        for vertices, faces in variants:
            samples = meander.sample(vertices, faces, 200)
            self.assertEqual(samples.content, expected.content)
            self.assertEqual(samples.points.tobytes(), expected.points.tobytes())
        split = meander.sample(CUBE, [[q[0], q[1], q[2]] for q in QUADS] + [[q[0], q[2], q[3]] for q in QUADS], 200)
        self.assertNotEqual(split.content, expected.content)
        moved = meander.sample(CUBE + 1e-9, QUADS, 200)
        self.assertNotEqual(moved.content, expected.content)

    def test_results_have_documented_types_and_shapes(self):
        s = meander.sample(CUBE, QUADS, 300)
        self.assertEqual(len(s), 300)
        for name, dtype, shape in [("points", "f4", (300, 3)), ("normals", "f4", (300, 3)), ("face_index", "u4", (300,)),
                                   ("corners", "u4", (300, 3)), ("barycentric", "f4", (300, 2)),
                                   ("curve_rank", "u4", (300,)), ("density", "f4", (300,)), ("weights", "f8", (300,))]:
            array = getattr(s, name)
            self.assertEqual((array.dtype, array.shape), (numpy.dtype(dtype), shape), name)
            self.assertFalse(array.flags.owndata, name)  # the memory that it was computed in
        self.assertIsNone(s.uv)
        self.assertIsNone(s.tensor_direction)
        self.assertAlmostEqual(s.area, 6)
        self.assertEqual([type(value) for value in (s.area, s.measure, s.scale)], [float] * 3)
        self.assertEqual([array.dtype for array in (s.bbox, s.loc)], [numpy.float64] * 2)
        self.assertAlmostEqual(s.weights.sum(), 6)
        self.assertEqual((s.components, s.genus, s.boundaries, s.method), (1, 0, 0, "balanced"))
        self.assertTrue((s.bbox == [[0, 0, 0], [1, 1, 1]]).all())
        self.assertEqual(sorted(s.curve_rank.tolist()), list(range(300)))
        self.assertTrue(numpy.allclose(s.interpolate(CUBE), s.points, atol=1e-6))
        self.assertLessEqual(abs(numpy.bincount(s.face_index, minlength=6) - 50).max(), 12)  # faces of equal area
        around = CUBE[QUADS[s.face_index]]
        self.assertTrue((around.min(axis=1) <= s.points).all() and (s.points <= around.max(axis=1)).all())
        again = pickle.loads(pickle.dumps(s))
        self.assertTrue((again.points == s.points).all() and again.area == s.area)

    def test_arrays_outlive_their_samples(self):
        points = meander.sample(CUBE, QUADS, 5000).points
        copy = points.copy()
        gc.collect()
        for _ in range(20):
            meander.sample(CUBE, QUADS, 5000, seed=2)
        self.assertTrue((points == copy).all())
        points += 1  # they are the caller's
        self.assertTrue((points == copy + 1).all())

    def test_samples_follow_the_density(self):
        one = meander.sample(CUBE, QUADS, 1000, density=[1, 0, 0, 0, 0, 3])
        self.assertEqual(set(one.face_index.tolist()), {0, 5})
        self.assertAlmostEqual((one.face_index == 5).mean(), 0.75, 2)
        square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
        two = meander.sample(square, [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 2, 3]], 2000, density=[0, 2, 2, 0],
                             density_at="vertices")
        self.assertAlmostEqual(two.points[:, 0].mean(), 2 / 3, 2)
        tops = meander.sample(CUBE, QUADS, 500, density="formula:max(nz, 0)")
        self.assertEqual(float(tops.points[:, 2].min()), 1)
        self.assertAlmostEqual((two.weights * two.points[:, 0]).sum(), 1, 2)  # the square lies there twice

    def test_densities_may_be_functions_of_positions(self):
        square, quad = numpy.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.]]), [[0, 1, 2, 3]]
        calls = []
        def density(positions):
            calls.append(positions.shape)
            return 1 + 3 * positions[:, 0]
        made = meander.sample(square, quad, 500, density=density)
        given = meander.sample(square, quad, 500, density=[1, 4, 4, 1], density_at="vertices")
        self.assertEqual((calls, made.points.tobytes()), ([(4, 3)], given.points.tobytes()))
        self.assertTrue(numpy.allclose(made.density, density(made.points), atol=1e-5))
        tops = meander.sample(CUBE, QUADS, 500, density=lambda p: p[:, 2] == 1, density_at="faces")
        self.assertEqual(float(tops.points[:, 2].min()), 1)
        nan = numpy.vstack([square, [[numpy.nan, 0, 0]]])
        mended = meander.sample(nan, [[0, 1, 2, 3], [0, 1, 2, 9]], 500, density=density, check=False)
        self.assertEqual((len(mended), calls[-1]), (500, (4, 3)))
        several = list(meander.sample_many([(square, quad), (CUBE, QUADS)], 100, density=lambda p: p[:, 2] + 1e-3 * (p[:, 2] == 0)))
        self.assertEqual(several[1].points.tobytes(), meander.sample(
            CUBE, QUADS, 100, density=CUBE[:, 2] + 1e-3 * (CUBE[:, 2] == 0)).points.tobytes())
        for function, error, pattern in [(lambda p: p, ValueError, r"shape \(8, 3\) for 8 positions"),
                                         (lambda p: -p[:, 0], ValueError, r"density\[4\] is -1"), (lambda p: 1 / 0, ZeroDivisionError, "")]:
            with self.assertRaisesRegex(error, pattern):
                meander.sample(CUBE, QUADS, density=function)
            with self.assertRaisesRegex(error, pattern):
                list(meander.sample_many([(CUBE, QUADS)], density=function))

    def test_colors_and_attributes_of_arrays_are_those_of_the_samples(self):
        place = CUBE[:, :2]
        s = meander.sample(CUBE, QUADS, 400, colors=CUBE.astype("f4"),
                           attributes={"height": CUBE[:, 2], "place": place, "number": numpy.arange(8), "side": numpy.arange(6),
                                       "flag": QUADS[:, 0] == 0, "pair": QUADS[:, :2], "a:class": CUBE[:, 0], "density": CUBE[:, 0]},
                           density=numpy.ones(8))
        self.assertLessEqual(numpy.abs(s.rgb - 255.0 * s.points).max(), 0.501)
        self.assertEqual((s.rgb.dtype, s.color_source, s.color_fills), (numpy.uint8, "vertex", 0))
        a = s.attributes
        for name, values in (("height", s.points[:, 2]), ("place", s.points[:, :2]), ("a:class", s.points[:, 0]), ("density", s.points[:, 0])):
            self.assertEqual((a[name].dtype, a[name].shape), (numpy.float32, values.shape), name)
            self.assertTrue(numpy.allclose(a[name], values, atol=1e-6), name)
        weights = numpy.stack([1 - s.barycentric.sum(axis=1), *s.barycentric.T], axis=1)
        nearest = s.corners[numpy.arange(400), weights.argmax(axis=1)]
        self.assertTrue((a["number"] == nearest).mean() > 0.99)  # equal weights aside
        self.assertEqual((a["number"].dtype, a["pair"].dtype), (numpy.int32, numpy.int32))
        self.assertTrue((a["side"] == s.face_index).all())
        self.assertTrue((a["flag"] == (QUADS[s.face_index, 0] == 0)).all())
        self.assertTrue((a["pair"] == QUADS[s.face_index, :2]).all())
        self.assertEqual(s.points.tobytes(), meander.sample(CUBE, QUADS, 400, density=numpy.ones(8)).points.tobytes())
        faces = numpy.full((6, 4), 255, "u1")
        faces[:, 0] = 40 * numpy.arange(6)
        of_faces = meander.sample(CUBE, QUADS, 100, colors=faces)
        self.assertTrue((of_faces.rgb[:, 0] == 40 * of_faces.face_index).all())
        self.assertEqual(of_faces.color_source, "face")
        lacking = meander.sample(CUBE, QUADS, 100, colors=numpy.full((6, 3), numpy.nan), attributes={"x": CUBE[:, 0] * numpy.nan})
        self.assertTrue((lacking.rgb == 204).all() and numpy.isnan(lacking.attributes["x"]).all())
        self.assertEqual((lacking.color_source, lacking.color_fills), ("none", 100))
        self.assertEqual((meander.sample(CUBE, QUADS, 9).rgb, meander.sample(CUBE, QUADS, 9).attributes), (None, {}))
        self.assertEqual(pickle.loads(pickle.dumps(s)).attributes["side"].tolist(), a["side"].tolist())
        for options, pattern in [
                (dict(colors=CUBE + 1), r"colors\[0, 0\] is 1|colors\[1, 2\] is 2"), (dict(colors=CUBE.astype(int)), "colors must be uint8"),
                (dict(colors=CUBE[:5]), "colors has 5 values: there are 8 vertices and 6 faces"),
                (dict(colors=CUBE[:5], colors_at="faces"), "colors has 5 rows for 6 faces"),
                (dict(colors_at="faces"), "colors_at applies"), (dict(attributes_at="faces"), "attributes_at applies"),
                (dict(attributes={"a,b": CUBE[:, 0]}), "without commas"), (dict(attributes={"a": CUBE[:3, 0]}), "attributes has 3 values"),
                (dict(attributes={"a": numpy.ones((8, 5))}), r"'a' must be numbers .* not float64 \(8, 5\)"),
                (dict(attributes={"a": numpy.ones((6, 2))}, attributes_at="vertices"), "'a' has 6 values for 8 vertices")]:
            with self.assertRaisesRegex(ValueError, pattern):
                meander.sample(CUBE, QUADS, 9, **options)

    def test_invalid_arguments_are_refused_by_name_and_index(self):
        def refused(error, pattern, *arguments, **options):
            with self.assertRaisesRegex(error, pattern):
                meander.sample(*arguments, **options)
        nan = CUBE.copy()
        nan[5, 1] = numpy.nan
        far = QUADS.copy()
        far[2, 3] = 8
        refused(ValueError, r"vertices\[5\] is \(1, nan, 1\): not finite", nan, QUADS)
        refused(ValueError, r"faces\[2, 3\] is 8: there are 8 vertices", CUBE, far)
        far[2, 3] = -8
        refused(ValueError, r"faces\[2, 3\] is -8", CUBE, far)
        refused(ValueError, r"faces\[0, 0\] is 4294967296", CUBE, QUADS + 2 ** 32)
        refused(ValueError, r"vertices must have the shape \(n, 3\), not \(8, 2\)", CUBE[:, :2], QUADS)
        refused(ValueError, r"faces must have the shape \(F, k\) with k >= 3, not \(12, 2\)", CUBE, QUADS.reshape(12, 2))
        refused(TypeError, r"faces must be whole numbers \(of vertices\), not float64", CUBE, QUADS.astype(float))
        refused(TypeError, "vertices must be real numbers, not complex128", CUBE.astype(complex), QUADS)
        refused(TypeError, "vertices must be real numbers", [["a", "b", "c"]], QUADS)
        refused(TypeError, "faces are missing", CUBE)
        refused(TypeError, "'cube.off' is a file: sample_file", "cube.off")
        refused(TypeError, "name what follows it, as in n=5000", types.SimpleNamespace(vertices=CUBE, faces=QUADS),
                5000)
        refused(ValueError, "3 normals of 8 vertices|8 vertices", CUBE, QUADS, normals=CUBE[:3])
        refused(ValueError, r"density\[1\] is -1", CUBE, QUADS, density=[1, -1, 1, 1, 1, 1])
        refused(ValueError, "density has 5 values: there are 8 vertices and 6 faces", CUBE, QUADS, density=[1] * 5)
        refused(ValueError, "as many vertices as faces", CUBE[:6], QUADS % 6, density=[1] * 6)
        refused(ValueError, "content must have 32 bytes", CUBE, QUADS, content=b"short")
        refused(ValueError, "method: `conformla` .*did you mean `conformal`", CUBE, QUADS, method="conformla")
        refused(ValueError, "`u` and `v` are texture coordinates, which meshes here do not have", CUBE, QUADS,
                density="formula:u")
        refused(ValueError, "applies to densities of curvature", CUBE, QUADS, density="formula:1",
                density_floor=0.5)
        refused(ValueError, "column 4", CUBE, QUADS, density="formula:1 +")
        refused(ValueError, "density: `texture` is read from the images of models", CUBE, QUADS, density="texture")
        refused(ValueError, "sequence(.|\n)*normalize", CUBE, QUADS, sequence="x", normalize="y")
        refused(ValueError, "spacing applies", CUBE, QUADS, spacing="best")
        refused(ValueError, "d22", CUBE, QUADS, describe="d22")
        refused(ValueError, "", CUBE, QUADS, n=0)
        refused(ValueError, "n cannot be -1", CUBE, QUADS, n=-1)
        refused(TypeError, "", CUBE, QUADS, n=1000.0)
        refused(TypeError, "method cannot be None", CUBE, QUADS, method=None)
        refused(TypeError, "curved cannot be 'yes'", CUBE, QUADS, curved="yes")
        refused(TypeError, r"describe cannot be \('d2', 3\)", CUBE, QUADS, describe=("d2", 3))
        refused(ValueError, "seed cannot be 18446744073709551616", CUBE, QUADS, seed=2 ** 64)
        refused(ValueError, "density exponent is nan", CUBE, QUADS, density="mean", density_exponent=numpy.nan)
        refused(ValueError, "threads is -1", CUBE, QUADS, threads=-1)
        refused(ValueError, "timeout is 0: ", CUBE, QUADS, timeout=0)
        refused(TypeError, "timeout cannot be '1'", CUBE, QUADS, timeout="1")
        far[2, 3] = 8
        dropped = meander.sample(nan, far, 100, check=False)
        self.assertEqual(dropped.repairs["index_out_of_range"], 1)
        self.assertGreaterEqual(dropped.repairs["non_finite"], 2)

    def test_meshes_that_cannot_be_sampled_have_a_status(self):
        for vertices, faces, status in [(CUBE, numpy.zeros((0, 3), int), "empty"), ([], [], "empty"),
                                        ([[0, 0, 0]] * 3, [[0, 1, 2]], "zero_area")]:
            with self.assertRaises(meander.SamplingError) as caught:
                meander.sample(numpy.reshape(vertices, (-1, 3)), faces)
            self.assertEqual(caught.exception.status, status)
            self.assertIn(status, str(caught.exception))
            again = pickle.loads(pickle.dumps(caught.exception))
            self.assertEqual((again.status, again.reason), (status, caught.exception.reason))
        with self.assertRaises(meander.SamplingError) as caught:
            meander.sample(*bumpy_sphere(), 100000, method="conformal", timeout=1e-6)
        self.assertEqual(caught.exception.status, "timeout")
        with self.assertRaises(meander.SamplingError) as caught:
            meander.read_mesh("/nowhere/at/all.off")
        self.assertEqual(caught.exception.status, "unreadable")


class Many(unittest.TestCase):
    def test_sample_many_equals_single_calls_for_any_number_of_threads(self):
        meshes = [bumpy_sphere(6 + i, 10 + i) for i in range(40)]
        expected = [meander.sample(v, f, 256).points.tobytes() for v, f in meshes]
        for threads in (0, 1, 2, 5):
            many = meander.sample_many(meshes, 256, threads=threads)
            self.assertEqual([s.points.tobytes() for s in many], expected)
        self.assertEqual([s.points.tobytes() for s in meander.sample_many((m for m in meshes), 256)], expected)
        self.assertEqual(list(meander.sample_many([])), [])

    def test_sample_many_takes_and_gives_meshes_as_results_are_asked_for(self):
        taken = []
        def meshes():
            for i in range(10 ** 6):
                taken.append(i)
                yield bumpy_sphere(6, 10 + i % 7)
        many = meander.sample_many(meshes(), 64, threads=2)
        self.assertEqual(taken, [])
        first = [next(many) for _ in range(3)]
        self.assertLess(len(taken), 20)
        self.assertEqual([s.points.tobytes() for s in first],
                         [meander.sample(*bumpy_sphere(6, 10 + i), 64).points.tobytes() for i in range(3)])
        many.close()
        slow = [bumpy_sphere(100, 200)] + [(CUBE, QUADS)] * 30
        counts = [len(s) for s in meander.sample_many(slow, 3000, sequence="spaced", threads=2)]
        self.assertEqual(counts, [3000] * 31)

    def test_failures_keep_their_index(self):
        nan = CUBE * numpy.nan
        meshes = [(CUBE, QUADS), (nan, QUADS), (CUBE, [[0, 0, 0]]), "/nowhere.off", (CUBE, QUADS, b"1" * 32)]
        results = list(meander.sample_many(meshes, 64, errors="return"))
        self.assertEqual([type(r).__name__ for r in results],
                         ["Samples", "ValueError", "SamplingError", "SamplingError", "Samples"])
        self.assertEqual(results[2].index, 2)
        self.assertEqual(results[4].content, b"1" * 32)
        many = meander.sample_many(meshes, 64)
        self.assertEqual(len(next(many)), 64)
        with self.assertRaisesRegex(ValueError, "not finite") as caught:
            next(many)
        self.assertEqual(caught.exception.index, 1)
        with self.assertRaises(StopIteration):
            next(many)
        for options, pattern in [(dict(errors="ignore"), "errors is 'ignore'"), (dict(threads=-1), "threads is -1"),
                                 (dict(density_at="faces"), "density_at applies"),
                                 (dict(density=len, density_at="edges"), "density_at is 'edges'")]:
            with self.assertRaisesRegex(ValueError, pattern):  # before any mesh is taken
                meander.sample_many([], **options)

    def test_an_exception_of_the_iterator_ends_the_call(self):
        def meshes():
            yield CUBE, QUADS
            raise KeyError("the source is gone")
        with self.assertRaisesRegex(KeyError, "the source is gone"):
            list(meander.sample_many(meshes()))

    def test_calls_from_many_threads_give_the_same_samples(self):
        expected = meander.sample(CUBE, QUADS, 3000).points.tobytes()
        with concurrent.futures.ThreadPoolExecutor(8) as pool:
            for points in pool.map(lambda _: meander.sample(CUBE, QUADS, 3000).points.tobytes(), range(64)):
                self.assertEqual(points, expected)

    def test_other_python_threads_run_during_a_call(self):
        ticks, stop = [], threading.Event()
        def tick():
            while not stop.is_set():
                ticks.append(time.perf_counter())
                time.sleep(0.001)
        thread = threading.Thread(target=tick)
        thread.start()
        start = time.perf_counter()
        meander.sample(*bumpy_sphere(100, 200), 60000, sequence="spaced")
        end = time.perf_counter()
        stop.set()
        thread.join()
        self.assertGreater(sum(start < t < end for t in ticks), 3)

    def test_a_signal_interrupts_long_calls(self):
        code = ("import meander, numpy, signal, sys\n"
                "signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell may have it ignored\n"
                "sys.path.insert(0, %r)\n"
                "from module_test import bumpy_sphere\n"
                "v, f = bumpy_sphere()\n"
                "try:\n"
                "    print('ready', flush=True)\n"
                "    %s\n"
                "except KeyboardInterrupt:\n"
                "    print('interrupted', flush=True)\n")
        one = "meander.sample(v, f, 2000000, sequence='spaced')"
        many = "list(meander.sample_many(((v, f) for _ in range(10 ** 7)), 20000))"
        for call, delay in ((one, 0.3), (many, 0.3), (many, 0.21), (many, 0.13), (many, 0.05)):
            child = subprocess.Popen([sys.executable, "-c", code % (str(Path(__file__).parent), call)],
                                     stdout=subprocess.PIPE, text=True)
            self.assertEqual(child.stdout.readline(), "ready\n")
            time.sleep(delay)
            child.send_signal(signal.SIGINT)
            output = child.communicate(timeout=120)[0]
            self.assertEqual((child.returncode, output), (0, "interrupted\n"), (call, delay))

    def test_a_forked_process_samples_with_one_thread(self):
        expected = meander.sample(*bumpy_sphere(100, 200), 20000).points.tobytes()
        with multiprocessing.get_context("fork").Pool(2) as pool:
            for made in pool.map_async(_sample_in_child, range(4)).get(timeout=120):
                self.assertEqual(made, expected)


def _sample_in_child(_):
    return meander.sample(*bumpy_sphere(100, 200), 20000, threads=1).points.tobytes()


class Surfaces(unittest.TestCase):
    def test_surfaces_of_functions(self):
        def torus(u, v):
            a, b = 2 * numpy.pi * u, 2 * numpy.pi * v
            r = 1 + 0.5 * numpy.cos(b)
            return numpy.stack([r * numpy.cos(a), r * numpy.sin(a), 0.5 * numpy.sin(b)], axis=1)
        area = 2 * numpy.pi ** 2
        s = meander.surface(torus, 4000)
        self.assertLess(abs(s.area - area), 1e-3 * area)
        self.assertEqual((s.uv.shape, s.face_index), ((4000, 2), None))
        self.assertTrue(numpy.allclose(torus(*s.uv.T.astype(float)), s.points, atol=1e-5))
        r = numpy.hypot(s.points[:, 0], s.points[:, 1])
        self.assertLess(abs((r < 1).mean() - (0.5 - 0.5 / numpy.pi)), 0.005)
        middle = numpy.stack([s.points[:, 0] / r, s.points[:, 1] / r, 0 * r], axis=1)
        outward = (s.points - middle) / 0.5
        self.assertGreater(numpy.abs((outward * s.normals).sum(axis=1)).min(), 1 - 1e-5)
        # Curvatures come from second differences: they agree with those of the surface of that name.
        curved = meander.surface(torus, 4000, density="mean")
        named = meander.surface("torus", 4000, density="mean")
        self.assertLess(abs(curved.measure - named.measure), 2e-3 * named.measure)

    def test_invalid_functions_are_refused(self):
        for function, error, pattern in [(lambda u, v: u, ValueError, "shape"),
                                         (lambda u, v: (u, v, u / 0 * numpy.nan), ValueError, "not finite"),
                                         (lambda u, v: (u[1:], v[1:], v[1:]), ValueError, "positions for"),
                                         (lambda u, v: 1 / 0, ZeroDivisionError, "")]:
            with numpy.errstate(all="ignore"), self.assertRaisesRegex(error, pattern):
                meander.surface(function, 100)
        with self.assertRaisesRegex(ValueError, "did you mean `torus`"):
            meander.surface("tours")
        with self.assertRaisesRegex(ValueError, "did you mean `mean`"):
            meander.surface("torus", density="maen")


@unittest.skipIf(h5py is None, "skipped: h5py is not installed")
class Stores(WithMeshes):
    def test_a_store_gives_rows_and_data_sets(self):
        for i in range(5):
            write_off(self.path / ("m%d.off" % i), *bumpy_sphere(6 + i, 12))
        (self.path / "broken.off").write_text("OFF\nnothing\n")
        store = self.path / "s.h5"
        done = subprocess.run([PROGRAM, "run", self.path, "-o", store, "-n", "128", "--describe", "d2", "--progress",
                               "none"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 3)
        with meander.open_store(store) as s:
            self.assertEqual((len(s), len(s.ok), s.samples), (6, 5, 128))
            self.assertEqual(s.ids[0], "broken.off")
            self.assertEqual(s.status, ["unreadable"] + ["ok"] * 5)
            self.assertEqual(s.points().shape, (5, 128, 3))
            self.assertEqual(s.points("test").shape, (0, 128, 3))
            self.assertEqual(s.descriptor("d2").shape, (5, 32))
            row = s["m3.off"]
            made = meander.sample(meander.read_mesh(self.path / "m3.off"), n=128)
            self.assertTrue((row["points"] == made.points).all() and (s[-2]["points"] == made.points).all())
            with self.assertRaises(meander.SamplingError) as caught:
                s["broken.off"]
            self.assertEqual(caught.exception.status, "unreadable")
            with self.assertRaises(KeyError):
                s["m9.off"]
            with self.assertRaises(IndexError):
                s[6]
            data = s.dataset(points=32)
        self.assertEqual(len(data), 5)
        first = data[0]
        self.assertEqual((first[0].shape, first[1].shape, first[2]), ((32, 3), (32, 3), -1))
        for way in ("fork", "spawn"):
            with multiprocessing.get_context(way).Pool(2) as pool:
                for a, b in zip(pool.map(data.__getitem__, range(5)), map(data.__getitem__, range(5))):
                    self.assertTrue((a[0] == b[0]).all())
        with self.assertRaisesRegex(ValueError, "points is 129: 1 to the 128"):
            meander.StoreDataset(store, points=129)
        index = shutil.copy(store, self.path / "index.h5")
        with h5py.File(index, "r+") as file:  # as an index of packs, one of which is not there
            file["packs/file"] = numpy.array([b"s.pack-00000.h5"])
            file["packs/bytes"] = numpy.array([100], "u8")
        with self.assertRaisesRegex(FileNotFoundError, "s.pack-00000.h5"):
            meander.open_store(index)
        with h5py.File(self.path / "other.h5", "w"):
            pass
        with self.assertRaisesRegex(ValueError, "no store"):
            meander.open_store(self.path / "other.h5")


    def test_chosen_columns_are_read(self):
        names = ("x", "y", "z", "height", "place_0", "place_1")
        corners = [(a, b, c) for a in (0, 1) for b in (0, 1) for c in (0, 2)]
        faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
        (self.path / "box.ply").write_text("\n".join(
            ["ply", "format ascii 1.0", "element vertex 8"] + ["property float " + name for name in names]
            + ["element face 6", "property list uchar int vertex_indices", "end_header"]
            + ["%d %d %d %d %d %d" % (a, b, c, c, a, b) for a, b, c in corners]
            + ["4 %d %d %d %d" % face for face in faces]) + "\n")
        store = self.path / "chosen.h5"
        subprocess.run([PROGRAM, "run", self.path / "box.ply", "-o", store, "-n", "64", "--attribute", "height,place:2",
                        "--texcoord", "--colors", "--store", "face", "--progress", "none"], stdout=subprocess.DEVNULL,
                       check=True)
        with meander.open_store(store) as s:
            self.assertEqual(s.attributes, ["height", "place"])
            row = s[0]
            self.assertEqual(sorted(row), ["attributes", "face_index", "points", "rgb", "texcoord"])
            self.assertTrue(numpy.allclose(row["attributes"]["height"], row["points"][:, 2], atol=1e-6))
            self.assertTrue(numpy.allclose(row["attributes"]["place"], row["points"][:, :2], atol=1e-6))
            self.assertTrue(numpy.isnan(row["texcoord"]).all())
            self.assertEqual(s.lacks(0), ["texcoord"])
            self.assertEqual(s.names(0), {})
            with self.assertRaisesRegex(ValueError, "no column 'normals': it has points, face_index, rgb, texcoord, attributes/height"):
                s.dataset()

    def a_collection(self, *options):
        """A store of four colored cubes in two classes and two splits."""
        folder = self.path / "collection"
        for number, name in enumerate(("chair/train/a", "chair/test/b", "table/train/c", "table/train/d")):
            path = folder / (name + ".ply")
            path.parent.mkdir(parents=True, exist_ok=True)
            write_colored_ply(path, CUBE + number, QUADS, [255, 60 * number, 0])
        store = self.path / "collection.h5"
        subprocess.run([PROGRAM, "run", folder, "-o", store, "-n", "128", "--layout", "modelnet", "--colors", "--describe", "d2",
                        "--progress", "none", *options], stdout=subprocess.DEVNULL, check=True)
        return store

    def test_classes_splits_colors_and_notes_are_properties(self):
        with meander.open_store(self.a_collection()) as s:
            self.assertEqual(s.ids, ["chair/test/b.ply", "chair/train/a.ply", "table/train/c.ply", "table/train/d.ply"])
            self.assertEqual((s.class_names, s.labels.tolist()), (["chair", "table"], [0, 0, 1, 1]))
            self.assertEqual(s.splits, ["test", "train", "train", "train"])
            self.assertEqual(s.color_sources, ["vertex"] * 4)
            self.assertEqual((s.rgb.shape, s.rgb.dtype), ((4, 128, 3), numpy.uint8))
            self.assertTrue((s.rgb[:, :, 1] == numpy.array([60, 0, 120, 180])[:, None]).all())
            self.assertEqual(s.noted, {})
            self.assertTrue((s.column("rgb", "train", 5) == s.rgb[1:, :5]).all())
            self.assertTrue((s.column("face_index") == s.column("face")).all())
            self.assertIn("descriptors/d2", s.columns)
            with self.assertRaisesRegex(KeyError, "no column 'uv': it has points, normals"):
                s.column("uv")

    def test_a_data_set_has_the_columns_that_are_asked_for(self):
        store = self.a_collection()
        data = meander.StoreDataset(store, columns=("points", "rgb", "descriptors/d2", "label", "class_name", "split", "id"),
                                    points=16, split="train")
        self.assertEqual([item[3:] for item in data],
                         [(0, "chair", "train", "chair/train/a.ply"), (1, "table", "train", "table/train/c.ply"),
                          (1, "table", "train", "table/train/d.ply")])
        points, rgb, d2 = data[2][:3]
        with meander.open_store(store) as s:
            row = s["table/train/d.ply"]
            self.assertTrue((points == row["points"][:16]).all() and (rgb == row["rgb"][:16]).all())
            self.assertTrue((d2 == s.descriptor("d2")[3]).all())
            lone = meander.StoreDataset(s, "points", transform=numpy.ndarray.mean, points=8)
            self.assertEqual(lone[3], row["points"][:8].mean())
        self.assertEqual(meander.StoreDataset(store, "label")[1], 0)
        for way in ("fork", "spawn"):
            with multiprocessing.get_context(way).Pool(2) as pool:
                self.assertEqual(pool.map(lone.__getitem__, range(4)), list(lone))
        with self.assertRaisesRegex(ValueError, "no column 'normal_s'.* and label, class_name"):
            meander.StoreDataset(store, ("points", "normal_s"))
        with self.assertRaisesRegex(ValueError, "no split 'dev'"):
            meander.StoreDataset(store, split="dev")
        with self.assertRaisesRegex(ValueError, "has no ok row in the split 'validation'|has no ok row in the split 'val'"):
            meander.StoreDataset(store, split="val")

    def test_points_of_sets_have_numbers_of_their_own(self):
        store = self.a_collection("--sharp", "40", "--queries", "near=300@.01 volume=100@1")
        with meander.open_store(store) as s:
            self.assertEqual(s.sizes, {"samples": 128, "sharp": 40, "queries": 400})
            row = s["chair/train/a.ply"]
            self.assertEqual(s.column("queries/points", points=300).shape, (4, 300, 3))
            self.assertEqual(s.column("sharp_edge", "train", 40).shape, (3, 40))
            with self.assertRaisesRegex(ValueError, "points is 41: 1 to the 40 of a row of .* in /sharp"):
                s.column("sharp/points", points=41)
            with self.assertRaisesRegex(ValueError, "1 to the 128"):
                s.column("points", points=300)
        columns = ("points", "sharp/points", "queries/distance", "label", "descriptors/d2")
        item = meander.StoreDataset(store, columns, points={"samples": 16, "queries": 250})[1]
        self.assertEqual([len(value) for value in item[:3]], [16, 40, 250])
        self.assertTrue((item[2] == row["queries_distance"][:250]).all())
        self.assertEqual([len(value) for value in meander.StoreDataset(store, columns, points=30)[1][:3]], [30, 30, 30])
        self.assertEqual(meander.StoreDataset(store, "queries/points", points=399)[1].shape, (399, 3))
        lone = meander.StoreDataset(store, columns[1:4], points={"sharp": 7})
        with multiprocessing.get_context("spawn").Pool(1) as pool:
            self.assertEqual([len(value) for value in pool.map(lone.__getitem__, [2])[0][:2]], [7, 400])
        for points, why in ((41, "1 to the 40"), ({"queries": 401}, "1 to the 400 .* in /queries"), ({"edges": 4}, "'edges': samples")):
            with self.assertRaisesRegex(ValueError, why):
                meander.StoreDataset(store, columns, points=points)

    def test_prefixes_along_a_curve_are_refused(self):
        store = self.a_collection("--order", "curve")
        self.assertEqual(meander.StoreDataset(store, "points", points=128)[0].shape, (128, 3))
        with self.assertRaisesRegex(ValueError, "--order curve"):
            meander.StoreDataset(store, "points", points=64)
        store = self.a_collection("--order", "curve", "--sharp", "40", "--queries", "volume=100@1", "--fresh")
        with self.assertRaisesRegex(ValueError, "--order curve"):
            meander.StoreDataset(store, "sharp/points", points=20)
        self.assertEqual(len(meander.StoreDataset(store, "queries/points", points=50)[0]), 50)

    def test_classes_are_read_with_their_names(self):
        folder = self.path / "parts"
        folder.mkdir()
        square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
        (folder / "a.obj").write_text(square + "o seat\nf 1 2 3\no leg\nf 1 3 4\n")
        (folder / "b.obj").write_text(square + "f 1 2 3 4\n")
        (folder / "c.obj").write_text(square + "f 1 2 3\no \u00e9t\u00e9\nf 1 3 4\n")
        store = self.path / "parts.h5"
        subprocess.run([PROGRAM, "run", folder, "-o", store, "-n", "64", "--attribute", "object", "--progress", "none"],
                       stdout=subprocess.DEVNULL, check=True)
        with meander.open_store(store) as s:
            self.assertEqual(s.names("a.obj"), {"object": ["seat", "leg"]})
            self.assertEqual(s.names("b.obj"), {})
            self.assertEqual(s.names(-1), {"object": ["\u00e9t\u00e9"]})
            objects = s["a.obj"]["attributes"]["object"]
            self.assertEqual(objects.dtype, numpy.int32)
            self.assertTrue((objects == s["a.obj"]["face_index"]).all())
            self.assertTrue((s["b.obj"]["attributes"]["object"] == -1).all())
            self.assertTrue((s["c.obj"]["attributes"]["object"] == s["c.obj"]["face_index"].astype(int) - 1).all())
            self.assertEqual([s.lacks(row) for row in range(3)], [[], ["attributes/object"], ["attributes/object"]])


    def test_notes_of_rows_are_read(self):
        folder = self.path / "noted"
        folder.mkdir()
        triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
        (folder / "a.obj").write_text("mtllib none.mtl\n" + triangle)
        (folder / "b.obj").write_text(triangle)
        store = self.path / "noted.h5"
        subprocess.run([PROGRAM, "run", folder, "-o", store, "-n", "64", "--colors", "--progress", "none"],
                       stdout=subprocess.DEVNULL, check=True)
        with meander.open_store(store) as s:
            self.assertEqual(s.notes("a.obj"),
                             {"library_missing": 1, "text": "library_missing 1: `none.mtl` is not there"})
            self.assertEqual(s.notes(1), {})
            self.assertEqual(s.noted, {"a.obj": s.notes(0)})


class Meshes(WithMeshes):
    def test_remesh_makes_the_mesh_of_the_program(self):
        vertices, faces = bumpy_sphere()
        write_off(self.path / "sphere.off", vertices, faces)
        content = meander.content_of(self.path / "sphere.off")
        for options, arguments in [(dict(), []), (dict(fit=True, crease_angle=60, density="mean", seed=3), [
                "--fit", "--crease-angle", "60", "--density", "mean", "--seed", "3"])]:
            subprocess.run([PROGRAM, "remesh", self.path / "sphere.off", "-o", self.path / "out", "-n", "300", "--fresh", "--format",
                            "obj", "--progress", "none", *arguments], check=True, stdout=subprocess.DEVNULL)
            theirs = meander.read_mesh(self.path / "out/sphere.obj")
            for made in (meander.remesh(vertices, faces, 300, content=content, **options),
                         meander.remesh(meander.read_mesh(self.path / "sphere.off"), n=300, threads=1, **options)):
                self.assertTrue((made.faces == theirs.faces).all())
                self.assertTrue(numpy.allclose(made.vertices, theirs.vertices, atol=1e-7))
        self.assertEqual((made.samples, made.report["euler"], made.report["vertices"]), (300, 2, len(made.vertices)))
        self.assertEqual(repr(made), "<meander.RemeshedMesh of %d vertices and %d faces>" % (made.vertices.shape[0], made.faces.shape[0]))
        samples = meander.sample(vertices, faces, 300, sequence="spaced", content=content)
        plain = meander.remesh(vertices, faces, 300, content=content)
        self.assertTrue(numpy.allclose(plain.vertices[:300], samples.points, atol=1e-6))
        graded = meander.remesh(vertices, faces, 300, density=lambda p: numpy.where(p[:, 2] > 0, 8.0, 1.0))
        self.assertGreater((graded.vertices[:300, 2] > 0).mean(), 0.75)
        for error, pattern, options in [(ValueError, "crease angle", dict(crease_angle=200)), (TypeError, "fit cannot be 'yes'", dict(fit="yes")),
                                        (TypeError, "unexpected keyword argument 'normalize'", dict(normalize="unit-box")),
                                        (ValueError, "sequence", dict(sequence="x")), (ValueError, "threads is -1", dict(threads=-1)),
                                        (meander.SamplingError, "timeout", dict(n=100000, timeout=1e-6))]:
            with self.subTest(pattern), self.assertRaisesRegex(error, pattern):
                meander.remesh(vertices, faces, **{"n": 300, **options})
        with self.assertRaisesRegex(meander.SamplingError, "zero_area"):
            meander.remesh(CUBE * [0, 0, 1], QUADS, 10)

    def test_signed_distances_of_a_box_and_of_a_sphere(self):
        random = numpy.random.default_rng(1)
        points = random.uniform(-1, 2, (5000, 3))
        beyond = numpy.abs(points - 0.5) - 0.5
        expected = numpy.linalg.norm(numpy.maximum(beyond, 0), axis=1) + numpy.minimum(beyond.max(axis=1), 0)
        whole = meander.signed_distance(CUBE, QUADS, points)
        # Some faces turned over, and all of them once more: sides do not come from the winding of the file.
        turned = numpy.concatenate([QUADS[:, ::-1], QUADS[:3]])
        for found in (whole, meander.signed_distance(CUBE, turned, points, threads=1)):
            self.assertLess(numpy.abs(found.distance - expected).max(), 1e-12)
            self.assertEqual((found.sign, found.open_edges, len(found)), ("closed", 0, 5000))
            self.assertTrue(found.certain.all() and (found.inside == (expected < 0)).all() and (found.winding == found.inside).all())
            nearest = found.interpolate(CUBE)
            self.assertLess(numpy.abs(numpy.linalg.norm(nearest - points, axis=1) - numpy.abs(expected)).max(), 1e-12)
            for corners, face in zip(found.corners, found.face_index):
                self.assertTrue(set(corners) <= set(QUADS[face]))
        self.assertEqual(repr(whole), "<meander.SignedDistances: 5000 points, sign closed, 0 uncertain>")
        vertices, faces = bumpy_sphere()
        write_off(self.path / "sphere.off", vertices, faces)
        of_arrays = meander.signed_distance(vertices, faces, points.astype("f4"))
        of_file = meander.signed_distance(meander.read_mesh(self.path / "sphere.off"), points=points.astype("f4"), threads=1)
        for name in ("distance", "face_index", "corners", "barycentric", "inside", "winding"):
            self.assertTrue(numpy.allclose(getattr(of_arrays, name), getattr(of_file, name), atol=1e-6), name)
        plain = meander.signed_distance(vertices, faces, points, sign="none")
        self.assertTrue(plain.winding is None and not plain.certain.any() and (plain.distance >= 0).all())
        lidless = meander.signed_distance(vertices, faces[64:], points)
        self.assertEqual(lidless.sign, "winding")
        self.assertGreater(lidless.open_edges, 0)
        sides = meander.signed_distance(vertices, faces, points).inside
        self.assertTrue((lidless.inside == sides)[lidless.certain].all())
        self.assertGreater(lidless.certain.mean(), 0.9)
        shell = meander.signed_distance(vertices, faces, points, sign="shell")
        self.assertTrue(shell.winding is None and (shell.inside == sides)[shell.certain].all())
        self.assertGreater(shell.certain.mean(), 0.99)
        for error, pattern, arguments, options in [
                (ValueError, "not closed: it has 64 open edges", (vertices, faces[64:], points), dict(sign="closed")),
                (ValueError, "sign: .*`inside`", (CUBE, QUADS, points), dict(sign="inside")),
                (TypeError, "sign cannot be 3", (CUBE, QUADS, points), dict(sign=3)),
                (TypeError, "points is None", (CUBE, QUADS), {}),
                (ValueError, r"points must have the shape \(n, 3\)", (CUBE, QUADS, points[0]), {}),
                (ValueError, r"points\[1\] is \(.*nan", (CUBE, QUADS, [[0, 0, 0], [0, numpy.nan, 0]]), {}),
                (ValueError, r"points\[0, 2\] is 1e\+30: farther", (CUBE, QUADS, [[0, 0, 1e30]]), {}),
                (ValueError, "there are 8 vertices", (CUBE, QUADS + 1, points), {}),
                (meander.SamplingError, "zero_area", (CUBE * [0, 0, 1], QUADS, points), {}),
                (meander.SamplingError, "timeout", (vertices, faces, numpy.tile(points, (40, 1))), dict(timeout=1e-6))]:
            with self.subTest(pattern), self.assertRaisesRegex(error, pattern):
                meander.signed_distance(*arguments, **options)
        self.assertEqual(len(meander.signed_distance(CUBE, QUADS, numpy.zeros((0, 3)))), 0)

    def test_winding_numbers_of_faces_as_they_are_wound(self):
        vertices, faces = bumpy_sphere()
        points = numpy.random.default_rng(2).uniform(-1.3, 1.3, (500, 3))
        inside = meander.signed_distance(vertices, faces, points).inside
        exact = meander.winding_number(vertices, faces, points, error=0)
        self.assertLess(numpy.abs(exact - inside).max(), 1e-9)
        self.assertLess(numpy.abs(meander.winding_number(vertices, faces[:, ::-1], points, error=0) + inside).max(), 1e-9)
        half = faces[vertices[faces].mean(axis=1)[:, 2] > 0]
        exact = meander.winding_number(vertices, half, points, error=0)
        for error in (0.001, 0.3):
            fast = meander.winding_number(vertices, half, points, error=error)
            self.assertLess(numpy.abs(fast - exact).max(), error + 2e-5)
            self.assertTrue((meander.winding_number(vertices, half, points, error=error, threads=1) == fast).all())
        for error in (-1, float("nan")):
            with self.assertRaisesRegex(ValueError, "error is"):
                meander.winding_number(vertices, half, points, error=error)

    def test_measures_equal_those_of_the_program(self):
        vertices, faces = bumpy_sphere()
        write_off(self.path / "sphere.off", vertices, faces)
        points = meander.sample(vertices, faces, 1000, seed=5).points
        numpy.save(self.path / "points.npy", points)
        said = subprocess.run([PROGRAM, "measure", "spacing", self.path / "points.npy", "--surface", self.path / "sphere.off", "--csv",
                               self.path / "spacing.csv", "--seed", "4"], capture_output=True, text=True)
        if "laboratory" in said.stderr:
            with self.assertRaisesRegex(RuntimeError, "laboratory"):
                meander.measure(points, vertices, faces)
            return
        self.assertEqual(said.returncode, 0, said.stderr)
        least, mean, rho, coverage, _, hole, chamfer = map(
            float, (self.path / "spacing.csv").read_text().splitlines()[1].split(",")[2:])
        for made in (meander.measure(points, vertices, faces, seed=4), meander.measure(points, meander.read_mesh(self.path / "sphere.off"), seed=4)):
            for name, value in dict(least=least, mean=mean, rho=rho, coverage=coverage, hole=hole, chamfer=chamfer).items():
                self.assertAlmostEqual(made[name], value, 5, name)
            boxes = meander.measure_boxes(points, vertices, faces, seed=4)
            self.assertEqual((made["boxes"], made["limit"], made["over_limit"]), (boxes, boxes.limit, boxes.over_limit))
            self.assertIs(type(made["boxes"]), float)
            self.assertNotIn("modes", made)
        subprocess.run([PROGRAM, "measure", "modes", self.path / "points.npy", "--surface", self.path / "sphere.off", "--csv",
                        self.path / "modes.csv", "--shapes", "20"], check=True, stdout=subprocess.DEVNULL)
        error = float((self.path / "modes.csv").read_text().splitlines()[1].split(",")[-1])
        self.assertAlmostEqual(meander.measure(points, vertices, faces, modes=20)["modes"], error, 5)
        self.assertLess(error, 0.4)
        for modes in (-1, 1001):
            with self.assertRaisesRegex(ValueError, "0 to 1000"):
                meander.measure(points, vertices, faces, modes=modes)
        for pattern, given in (("is one point", points[:1]), ("points is empty", points[:0]), (r"points\[1\] is", points * [[1]] * numpy.where(
                numpy.arange(1000) == 1, numpy.nan, 1)[:, None])):
            with self.assertRaisesRegex(ValueError, pattern):
                meander.measure(given, vertices, faces)


class Neighbors(WithMeshes):
    def test_neighbors_are_those_of_all_distances(self):
        base = numpy.random.default_rng(1).random((200, 37), numpy.float32)
        queries = numpy.random.default_rng(2).random((9, 37))
        all_distances = {"l1": lambda a, b: numpy.abs(a - b).sum(-1), "l2": lambda a, b: numpy.sqrt(((a - b) ** 2).sum(-1)),
                         "emd": lambda a, b: numpy.abs(numpy.cumsum(a - b, -1)).sum(-1),
                         "chi2": lambda a, b: 0.5 * ((a - b) ** 2 / (a + b)).sum(-1),
                         "cosine": lambda a, b: 1 - (a * b).sum(-1) / numpy.linalg.norm(a, axis=-1) / numpy.linalg.norm(b, axis=-1)}
        for name, distance in all_distances.items():
            expected = distance(base[None].astype(float), queries[:, None].astype("f4").astype(float))
            found = meander.knn(base, queries, k=7, distance=name)
            self.assertEqual((found.rows.dtype, found.distances.dtype), (numpy.int64, numpy.float32))
            self.assertTrue((found.rows == numpy.argsort(expected, axis=1, kind="stable")[:, :7]).all(), name)
            self.assertTrue(numpy.allclose(found.distances, numpy.sort(expected, axis=1)[:, :7], rtol=1e-4, atol=1e-6), name)
        numpy.save(self.path / "base.npy", base)
        numpy.save(self.path / "queries.npy", queries)
        filed = meander.knn(self.path / "base.npy", self.path / "queries.npy", k=7, distance="cosine")
        self.assertTrue((filed.rows == found.rows).all())
        each = meander.knn(base, k=3)
        self.assertEqual(each.rows.shape, (200, 3))
        self.assertFalse((each.rows == numpy.arange(200)[:, None]).any())
        some = meander.knn(base, [5, 199], k=300)
        self.assertEqual(some.rows.shape, (2, 199))
        self.assertTrue((some.rows[:, :3] == each.rows[[5, 199]]).all())
        self.assertEqual(meander.knn(base, numpy.zeros((0, 37))).rows.shape, (0, 0))
        for pattern, arguments, options in [
                ("distance: `l3` is none of", (base,), dict(distance="l3")), ("k is 0", (base,), dict(k=0)),
                ("there is no row 200 of 200", (base, [200]), {}), ("there is no row -1 of 200", (base, [-1]), {}),
                ("queries have 36 numbers each where the base has 37", (base, base[:, :36]), {}),
                ("finite", (base * numpy.nan,), {}), ("base must be real numbers of the shape", (base[0],), {}),
                ("no other row", (base[:1],), {}), ("descriptor is for stores", (base,), dict(descriptor="d2"))]:
            with self.subTest(pattern), self.assertRaisesRegex(ValueError, pattern):
                meander.knn(*arguments, **options)

    @unittest.skipIf(h5py is None, "skipped: h5py is not installed")
    def test_neighbors_in_a_store_are_those_of_retrieve_query(self):
        folder = self.path / "models"
        folder.mkdir()
        for i in range(12):
            write_off(folder / ("m%02d.off" % i), *bumpy_sphere(8 + i, 12 + 5 * i % 7))
        (folder / "broken.off").write_text("OFF\nnothing\n")
        store = self.path / "s.h5"
        meander.run(folder, store, n=128, describe="d2,basics,pairs", curved=True)
        for descriptor, distance in (("pairs", "l1"), ("d2", "emd"), ("basics", "l2")):
            subprocess.run([PROGRAM, "retrieve", "query", store, "m03.off", "m07.off", "-k", "4", "--descriptor", descriptor, "--distance",
                            distance, "--csv", self.path / "hits.csv"], check=True, stdout=subprocess.DEVNULL)
            with open(self.path / "hits.csv", newline="") as file:
                lines = list(csv.DictReader(file))
            with meander.open_store(store) as s:
                found = meander.knn(s, ["m03.off", "m07.off"], 4, descriptor=descriptor, distance=distance)
                self.assertEqual([s.ids[row] for row in found.rows.ravel()], [line["id"] for line in lines])
                for mine, line in zip(found.distances.ravel(), lines):
                    self.assertAlmostEqual(float(mine), float(line["distance"]), 4)
                self.assertEqual(s.described(descriptor).tolist(), list(range(1, 13)))
                again = meander.knn(store, s.file["descriptors"][descriptor][4:5], 5, descriptor=descriptor, distance=distance)
                self.assertEqual(again.rows[0].tolist(), [4, *found.rows[0].tolist()])
            every = meander.knn(str(store), k=4, descriptor=descriptor, distance=distance)
            self.assertTrue((every.rows[3] == found.rows[0]).all() and every.rows.shape == (12, 4))
        for error, pattern, arguments, options in [
                (ValueError, "say descriptor=, one of d2, basics, pairs", (), {}), (ValueError, "row 0 \\(`broken.off`\\) has no descriptor", (["broken.off"],), dict(descriptor="d2")),
                (KeyError, "no column 'descriptors/d3'", (), dict(descriptor="d3")), (KeyError, "m99", (["m99.off"],), dict(descriptor="d2"))]:
            with self.subTest(pattern), self.assertRaisesRegex(error, pattern):
                meander.knn(store, *arguments, **options)


class Runs(WithMeshes):
    def models(self, count=12, rings=40):
        folder = self.path / "models"
        folder.mkdir(exist_ok=True)
        for i in range(count):
            write_off(folder / ("m%02d.off" % i), *bumpy_sphere(rings, 20 + i))
        return folder

    def by_program(self, folder, *arguments):
        store = self.path / "by_program.h5"
        done = subprocess.run([PROGRAM, "run", folder, "-o", store, "--progress", "none", *map(str, arguments)],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.assertIn(done.returncode, (0, 3))
        return store.read_bytes()

    def test_run_makes_the_store_of_the_program_and_tells_its_progress(self):
        folder = self.models()
        (folder / "broken.off").write_text("OFF\nnothing\n")
        told = []
        result = meander.run(folder, self.path / "s.h5", n=200, describe=["d2", "d1"], topology=False, columns=["normals"],
                             attributes=("height", "other"), method="direct", threads=numpy.int64(2), timeout=60, memory="1G",
                             progress=lambda done, total, item: told.append((done, total, item["id"], item["status"])))
        self.assertEqual((self.path / "s.h5").read_bytes(), self.by_program(
            folder, "-n", 200, "--describe", "d2,d1", "--topology", "none", "--store", "normals", "--attribute", "height",
            "--attribute", "other", "--method", "direct"))
        self.assertEqual(sorted(done for done, _, _, _ in told), list(range(1, 14)))
        self.assertEqual({total for _, total, _, _ in told}, {13})
        self.assertIn(("broken.off", "unreadable"), [line[2:] for line in told])
        self.assertEqual((result.items, result.done_now, result.samples, result.exit_status), (13, 13, 200, 3))
        self.assertEqual(result.status, {"ok": 12, "unreadable": 1})
        self.assertEqual([failed["id"] for failed in result.failed], ["broken.off"])
        self.assertEqual(repr(result), "<meander.RunResult %s: 13 rows, 12 ok, 1 failed>" % (self.path / "s.h5"))

    def test_a_run_that_is_ended_by_an_exception_is_continued_by_the_same_call(self):
        folder, store = self.models(40, 12), self.path / "s.h5"
        def stop(done, total, item):
            if done == 5:
                raise KeyError("enough")
        with self.assertRaisesRegex(KeyError, "enough"):
            meander.run([folder], store, n=4000, sequence="spaced", threads=1, progress=stop)
        self.assertFalse(store.exists())
        result = meander.run([folder], store, n=4000, sequence="spaced")
        self.assertEqual((result.items, result.exit_status), (40, 0))
        self.assertLessEqual(result.done_now, 35)
        self.assertEqual(store.read_bytes(), self.by_program(folder, "-n", 4000, "--sequence", "spaced"))

    def test_a_signal_interrupts_a_run_which_ends_before_the_exception(self):
        folder, store = self.models(40, 12), self.path / "s.h5"
        code = ("import meander, signal, sys\n"
                "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
                "try:\n"
                "    meander.run(%r, %r, n=4000, sequence='spaced', threads=1, progress=lambda *_: print('.', flush=True))\n"
                "except KeyboardInterrupt:\n"
                "    print('interrupted')\n") % (str(folder), str(store))
        child = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
        self.assertEqual(child.stdout.readline(), ".\n")
        child.send_signal(signal.SIGINT)
        output = child.communicate(timeout=120)[0]
        self.assertTrue(output.endswith("interrupted\n") and child.returncode == 0, output)
        self.assertEqual(meander.run(folder, store, n=4000, sequence="spaced").exit_status, 0)  # nobody holds the store

    def test_runs_that_cannot_be_are_refused(self):
        folder, store = self.models(3), self.path / "s.h5"
        meander.run(folder, store, n=64)
        for error, pattern, inputs, options in [
                (ValueError, r'^`.*s.h5` was made with other parameters: parameter "samples" was 64, now it is 65', folder, dict(n=65)),
                (ValueError, "method.*did you mean `?conformal", folder, dict(method="conformla")),
                (ValueError, "begins with a minus", "-", {}), (ValueError, "nowhere", "nowhere", {}),
                (TypeError, "curved cannot be 'yes'", folder, dict(curved="yes")),
                (TypeError, "n cannot be True", folder, dict(n=True)), (TypeError, r"n cannot be \{", folder, dict(n={})),
                (TypeError, "unexpected keyword argument 'memmory'; did you mean 'memory'", folder, dict(memmory=3)),
                (meander.RunStopped, "1", folder, dict(fresh=True, timeout="0.000001", n=100000, max_failures=0))]:
            with self.subTest(pattern), self.assertRaisesRegex(error, pattern):
                meander.run(inputs, store, **options)
        result = meander.run(folder, store, n=65, fresh=True)
        self.assertEqual((result.samples, result.done_now), (65, 3))


class Documentation(unittest.TestCase):
    def test_stubs_and_docstrings_match_the_functions(self):
        stubs = (Path(meander.__file__).parent / "__init__.pyi").read_text()
        for name in meander.__all__:
            thing = getattr(meander, name)
            if inspect.isfunction(thing):
                self.assertTrue(thing.__doc__, name)
                if thing.__module__ == "meander":
                    start = stubs.index("def %s(" % name)
                    stub = stubs[start:stubs.index(" ...\n", start)]
                    for parameter in inspect.signature(thing).parameters:
                        self.assertRegex(stub, r"\b%s:" % parameter, name)
        for field in meander.Samples.__dataclass_fields__:
            self.assertIn("    %s: " % field, stubs)


if __name__ == "__main__":
    PROGRAM, SHARED = sys.argv[1], Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
