#!/usr/bin/env python3
"""The files of `meander export --schema` are what the loaders of the projects read: readers written anew.

    schemas_test.py PROGRAM       exit status 77: numpy is not installed
"""
import importlib.util
import io
import json
import subprocess
import sys
import tarfile
import tempfile
import unittest
from pathlib import Path

for needed in ("numpy", "h5py"):
    if importlib.util.find_spec(needed) is None:
        print("skipped: %s is not installed" % needed)
        sys.exit(77)

import numpy

PROGRAM = sys.argv.pop(1)
CUBE = "OFF\n8 6 0\n" + "".join("%d %d %d\n" % (x, y, z) for z in (2, 6) for y in (0, 4) for x in (0, 4)) + \
       "4 0 2 3 1\n4 4 5 7 6\n4 0 1 5 4\n4 2 6 7 3\n4 0 4 6 2\n4 1 3 7 5\n"
SHEET = "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n"


def meander(*words):
    done = subprocess.run([PROGRAM, *map(str, words)], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError("%s: %d\n%s%s" % (" ".join(map(str, words)), done.returncode, done.stdout, done.stderr))
    return done.stdout


def box_distance(points, half):
    """From the box [-half, half]^3, negative inside."""
    over = abs(points.astype(float)) - half
    return numpy.where((over > 0).any(1), numpy.linalg.norm(numpy.maximum(over, 0), axis=1), over.max(1))


class Schemas(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.folder = Path(cls.holder.name)
        (cls.folder / "in/box").mkdir(parents=True)
        (cls.folder / "in/box/cube.off").write_text(CUBE)
        queries = "near=800@.005,.05 near-sharp=600@.001,.003,.06,.01,.02,.04 volume=400@1.05"
        meander("run", cls.folder / "in", "-o", cls.folder / "none.h5", "-n", 256, "--sharp", 128, "--queries", queries)
        meander("run", cls.folder / "in", "-o", cls.folder / "sphere.h5", "-n", 256, "--normalize", "unit-sphere",
                "--queries", "near=900@.05,.0158 volume=100@1", "--queries-type", "float16")

    def export(self, store, schema, *more):
        out = self.folder / (schema + "-" + "-".join(more) + store)
        self.printed = meander("export", self.folder / store, "-o", out, "--schema", schema, *more)
        return out

    def check(self, npz, **expected):
        """The arrays by name, which have these types and shapes, and no others."""
        data = numpy.load(npz)
        self.assertEqual(set(data.files), set(expected))
        for name, (kind, shape) in expected.items():
            self.assertEqual((data[name].dtype, data[name].shape), (numpy.dtype(kind), shape), name)
        return data

    def test_hunyuan(self):
        out = self.export("none.h5", "hunyuan")
        data = self.check(out / "box/cube.off_surface.npz", random_surface=("f2", (256, 6)), sharp_surface=("f2", (128, 6)))
        for name, sides in (("random_surface", 1), ("sharp_surface", 2)):
            points, normals = data[name][:, :3].astype(float), data[name][:, 3:].astype(float)
            self.assertTrue(((abs(abs(points) - 1) < 1e-3).sum(1) >= sides).all())
            self.assertTrue((abs(numpy.linalg.norm(normals, axis=1) - 1) < 2e-3).all())
            self.assertTrue(((points * normals).sum(1) > 0.9).all())
        data = self.check(out / "box/cube.off_sdf.npz", vol_points=("f2", (400, 3)), vol_label=("f2", (400,)),
                          random_near_points=("f2", (800, 3)), random_near_label=("f2", (800,)),
                          sharp_near_points=("f2", (600, 3)), sharp_near_label=("f2", (600,)))
        self.assertLessEqual(abs(data["vol_points"]).max(), 1.05)
        self.assertGreater(abs(data["vol_points"]).max(), 1.02)
        for name in ("vol", "random_near", "sharp_near"):   # positive inside
            error = -box_distance(data[name + "_points"], 1) - data[name + "_label"]
            self.assertLess(abs(error).max(), 2e-3)
        self.assertTrue((data["vol_label"] > 0).mean() > 0.7)

    def test_dora(self):
        data = self.check(self.export("none.h5", "dora") / "box/cube.off.npz", fps_coarse_surface=("f4", (256, 1, 6)),
                          fps_sharp_surface=("f4", (128, 1, 6)), sharp_near_surface=("f4", (600, 4)), rand_points=("f4", (1200, 4)))
        for name in ("sharp_near_surface", "rand_points"):
            self.assertLess(abs(-box_distance(data[name][:, :3], 1) - data[name][:, 3]).max(), 1e-5)
        # The near points come first, as the loader slices them.
        near, volume = abs(data["rand_points"][:800, 3]), abs(data["rand_points"][800:, 3])
        self.assertLess(near.mean(), 0.06)
        self.assertGreater(volume.mean(), 0.15)

    def test_deepsdf(self):
        out = self.export("sphere.h5", "deepsdf")
        data = numpy.load(out / "SdfSamples/box/cube.off.npz")
        self.assertEqual(set(data.files), {"pos", "neg"})
        self.assertEqual(len(data["pos"]) + len(data["neg"]), 1000)
        half = 1 / 3 ** 0.5
        for name, sign in (("pos", 1), ("neg", -1)):
            self.assertEqual(data[name].dtype, numpy.float32)
            self.assertTrue((sign * data[name][:, 3] >= 0).all())
            self.assertLess(abs(box_distance(data[name][:, :3], half) - data[name][:, 3]).max(), 1e-3)
        with self.assertRaisesRegex(RuntimeError, "unit-sphere"):
            self.export("none.h5", "deepsdf")

    def test_occnet(self):
        out = self.export("none.h5", "occnet")
        data = self.check(out / "box/cube.off/points.npz", points=("f4", (400, 3)), occupancies=("u1", (50,)), loc=("f8", (3,)),
                          scale=("f8", ()))
        occupied = numpy.unpackbits(data["occupancies"])[:len(data["points"])]
        numpy.testing.assert_array_equal(occupied == 1, box_distance(data["points"], 0.5) < 0)
        self.assertEqual((data["loc"].tolist(), float(data["scale"])), ([2, 2, 4], 4))
        cloud = self.check(out / "box/cube.off/pointcloud.npz", points=("f4", (256, 3)), normals=("f4", (256, 3)), loc=("f8", (3,)),
                           scale=("f8", ()))
        self.assertLess(abs(abs(cloud["points"]).max(1) - 0.5).max(), 1e-6)

    def test_vecset(self):
        out = self.export("none.h5", "vecset")
        data = self.check(out / "ShapeNetV2_point/box/cube.off.npz", vol_points=("f4", (400, 3)), vol_label=("?", (400,)),
                          near_points=("f4", (800, 3)), near_label=("?", (800,)))
        for name in ("vol", "near"):
            numpy.testing.assert_array_equal(data[name + "_label"], box_distance(data[name + "_points"], 1) < 0)
        scale = numpy.load(out / "ShapeNetV2_point/box/cube.off.npy").item()
        surface = self.check(out / "ShapeNetV2_watertight/box/4_pointcloud/cube.off.npz", points=("f4", (256, 3)))["points"] * scale
        self.assertLess(abs(abs(surface).max(1) - 1).max(), 1e-6)

    def test_points_and_models_without_a_certain_side_are_left_out_and_counted(self):
        (self.folder / "two").mkdir()
        (self.folder / "two/cube.off").write_text(CUBE)
        (self.folder / "two/sheet.off").write_text(SHEET)
        meander("run", self.folder / "two", "-o", self.folder / "two.h5", "-n", 64, "--sign", "closed", "--queries", "volume=400@1")
        out = self.export("two.h5", "occnet")
        self.assertIn("1 model was left out", self.printed)
        self.assertFalse((out / "sheet.off").exists())
        self.assertEqual(len(numpy.load(out / "cube.off/points.npz")["points"]), 400)
        out = self.export("two.h5", "occnet", "--uncertain", "keep")
        self.assertEqual(numpy.load(out / "sheet.off/points.npz")["occupancies"].max(), 0)
        meander("run", self.folder / "two", "-o", self.folder / "shell.h5", "-n", 64, "--sign", "shell", "--queries", "volume=400@1")
        count = len(numpy.load(self.export("shell.h5", "occnet") / "sheet.off/points.npz")["points"])
        kept = len(numpy.load(self.export("shell.h5", "occnet", "--uncertain", "keep") / "sheet.off/points.npz")["points"])
        self.assertEqual(kept, 400)
        self.assertLessEqual(count, kept)

    def test_webdataset_shards_have_the_files_of_the_schema_by_key(self):
        ends = {"hunyuan": {"surface.npz": "box/cube.off_surface.npz", "sdf.npz": "box/cube.off_sdf.npz"},
                "occnet": {"points.npz": "box/cube.off/points.npz", "pointcloud.npz": "box/cube.off/pointcloud.npz"},
                "vecset": {"npz": "ShapeNetV2_point/box/cube.off.npz", "npy": "ShapeNetV2_point/box/cube.off.npy",
                           "4_pointcloud.npz": "ShapeNetV2_watertight/box/4_pointcloud/cube.off.npz"}}
        for schema, names in ends.items():
            single, shards = (self.export("none.h5", schema, "--fresh", "--format", form) for form in ("npz", "webdataset"))
            self.assertIn("1 models in 1 shards", self.printed)
            files = sorted(shards.glob("*.tar"))
            self.assertEqual([file.name for file in files], ["none-000000.tar"])
            with tarfile.open(files[0]) as tar:
                held = {member.name.split(".", 1)[1]: tar.extractfile(member).read() for member in tar}
                self.assertEqual({member.name.split(".", 1)[0] for member in tar}, {"00000000"})
            self.assertEqual(set(held), set(names) | {"json"})
            for end, name in names.items():
                self.assertEqual(held[end], (single / name).read_bytes())
            facts = json.loads(held["json"])
            self.assertEqual((facts["id"], facts["frame"], facts["loc"]), ("box/cube.off", schema, [2, 2, 4]))
            self.assertEqual(facts["scale"], 4 if schema == "occnet" else 2)
            points = numpy.load(io.BytesIO(held[next(iter(names))]))
            points = points[{"hunyuan": "random_surface"}.get(schema, "vol_points" if schema == "vecset" else "points")]
            self.assertLess(abs(points[:, :3].astype(float)).max(), 1.06)
        with self.assertRaisesRegex(RuntimeError, "--schema"):
            self.export("none.h5", "hunyuan", "--format", "ply")

    def test_webdataset_shards_leave_out_models_without_a_certain_side(self):
        (self.folder / "shards").mkdir()
        (self.folder / "shards/cube.off").write_text(CUBE)
        (self.folder / "shards/sheet.off").write_text(SHEET)
        meander("run", self.folder / "shards", "-o", self.folder / "shards.h5", "-n", 64, "--sign", "closed", "--queries", "volume=400@1")
        for more, keys in (((), {"00000000"}), (("--uncertain", "keep"), {"00000000", "00000001"})):
            out = self.export("shards.h5", "occnet", "--format", "webdataset", *more)
            self.assertEqual("1 model was left out" in self.printed, not more)
            with tarfile.open(out / "shards-000000.tar") as tar:
                self.assertEqual({member.name.split(".", 1)[0] for member in tar}, keys)

    def test_what_a_store_lacks_is_named(self):
        for store, schema, why in (("sphere.h5", "hunyuan", "--sharp"), ("sphere.h5", "dora", "--sharp")):
            with self.assertRaisesRegex(RuntimeError, why):
                self.export(store, schema)


unittest.main()
