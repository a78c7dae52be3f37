#!/usr/bin/env python3
"""The Python programs of docs/examples run, are short, and print what they promise.

    programs_test.py EXAMPLES       exit status 77: numpy or h5py is not installed
"""
import importlib.util
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

for needed in ("numpy", "h5py"):
    if importlib.util.find_spec(needed) is None:
        print("skipped: %s is not installed" % needed)
        sys.exit(77)

import meander
import meander.laboratory

EXAMPLES = Path(sys.argv[1]).resolve()
HAS_LABORATORY = True
try:
    meander.laboratory.points_in_square(method="random", n=1)
except RuntimeError:
    HAS_LABORATORY = False
NUMBER = r"(-?\d+(?:\.\d+)?)"


class Programs(unittest.TestCase):
    def run_program(self, name, *arguments):
        """What it printed, in an empty folder; checks that nothing went to standard error. Then the folder."""
        holder = tempfile.TemporaryDirectory()
        self.addCleanup(holder.cleanup)
        done = subprocess.run([sys.executable, EXAMPLES / name, *arguments], cwd=holder.name, capture_output=True, text=True)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        return done.stdout, Path(holder.name)

    def numbers(self, pattern, text):
        """Those at NUMBER of the one place that the pattern has in the text."""
        found = re.findall(pattern.replace("NUMBER", NUMBER), text)
        self.assertEqual(len(found), 1, "%s in\n%s" % (pattern, text))
        return [float(number) for number in (found[0] if isinstance(found[0], tuple) else found)]

    def test_prefixes_train_as_well_as_farthest_points(self):
        text, folder = self.run_program("train_with_prefixes.py")
        spread = [self.numbers(name + r".*: mean distance to the nearest of 128: NUMBER", text)[0]
                  for name in ("prefix", r"farthest points", "random")]
        self.assertLess(spread[0], 1.15 * spread[1])
        self.assertLess(spread[0], 0.95 * spread[2])
        right, tested = self.numbers("NUMBER of NUMBER test models right: sphere, torus", text)
        self.assertEqual(tested, 20)
        self.assertGreaterEqual(right, 18)
        with meander.open_store(folder / "training/shapes.h5") as store:
            self.assertEqual((len(store.ok), store.splits.count("test")), (60, 20))

    def test_a_function_is_fitted_to_signed_distances(self):
        text, _ = self.run_program("fit_distances.py")
        for name in ("thick", "thin"):
            error, right, certain, count = self.numbers(
                name + r"\.off: NUMBER mean error of the distance, NUMBER % of the sides right, NUMBER of NUMBER certain", text)
            self.assertLess(error, 0.02)
            self.assertGreater(right, 93)
            self.assertEqual(certain, count)

    @unittest.skipUnless(HAS_LABORATORY, "skipped: a build without the laboratory")
    def test_samplers_of_a_mesh_are_compared(self):
        with tempfile.TemporaryDirectory() as folder:
            mesh = Path(folder) / "tetrahedron.off"
            mesh.write_text("OFF\n4 4 0\n1 1 1\n1 -1 -1\n-1 1 -1\n-1 -1 1\n3 0 1 2\n3 0 3 1\n3 0 2 3\n3 1 3 2\n")
            text, _ = self.run_program("compare_samplers.py", "200", str(mesh))
        errors = [self.numbers(r"(?m)^%s +NUMBER" % name, text)[0] for name in ("random", "farthest points", "meander")]
        self.assertLess(errors[2], 0.6 * errors[0])
        self.assertLess(errors[2], errors[1])

    def test_colors_of_glbs_are_those_of_the_files(self):
        text, _ = self.run_program("colors_of_glbs.py", "here")
        for line in ("3 of 3: ok", "blue.glb: from vertex, mean color [0, 0, 255]", "red.glb: from vertex, mean color [255, 0, 0]",
                     "files that miss something: none", "1024 points, 0 without a color"):
            self.assertIn(line, text)
        topmost = [int(number) for number in re.search(r"the topmost is \[(.*)\]", text)[1].split(", ")]
        self.assertGreater(topmost[2], 240)  # blue grows with z

    @unittest.skipUnless(HAS_LABORATORY, "skipped: this build has no laboratory")
    def test_samplers_are_compared(self):
        text, _ = self.run_program("compare_samplers.py", "500")
        rows = {name: self.numbers(r"(?m)^%s +NUMBER +NUMBER +NUMBER +NUMBER$" % re.escape(name), text)
                for name in ("random", "farthest points", "meander", "meander, spaced")}
        self.assertTrue(0.8 < rows["random"][0] < 1.2, text)
        self.assertLess(rows["meander"][0], 0.5 * rows["random"][0])
        self.assertGreater(rows["meander, spaced"][1], 0.5)
        self.assertLess(rows["random"][1], 0.3)

    def test_shapes_are_retrieved(self):
        text, folder = self.run_program("retrieve_shapes.py", "here")
        for name in ("pairs", "features.npy"):
            self.assertGreater(self.numbers(re.escape(name) + ": NUMBER % of the nearest", text)[0], 90)
        self.assertEqual(re.search(r"a new vase is near \['(\w+)/", text)[1], "vase")
        self.assertTrue((folder / "here/features.npy").exists())

    def test_a_surface_is_remeshed(self):
        text, folder = self.run_program("remesh_surface.py", "made.ply")
        self.assertIn("euler characteristic 0, components 1, crossings 0", text)
        mesh = meander.read_mesh(folder / "made.ply")
        self.assertEqual((len(mesh.vertices), len(mesh.faces)), (1500, 3000))
        self.assertEqual(meander.sample_file(folder / "made.ply", 200, colors=True).color_source, "vertex")

    def test_a_parametric_surface_is_integrated_over(self):
        text, folder = self.run_program("parametric_surface.py")
        area, exact = self.numbers("area NUMBER, exactly NUMBER", text)
        self.assertAlmostEqual(area, exact, 2)
        even, bent = self.numbers("on the inner half: NUMBER of even samples, NUMBER of those", text)
        self.assertLess(even + 0.1, bent)
        for name in ("even", "by curvature"):
            integral, exact = self.numbers(name + ": integral of the squared distance NUMBER, exactly NUMBER", text)
            self.assertLess(abs(integral - exact), 0.01 * exact)
        error, of_random = self.numbers("the first   64 points: relative error NUMBER, NUMBER for random", text)
        self.assertLess(error, of_random)
        self.assertEqual(len((folder / "torus.xyz").read_text().splitlines()), 4096)

    def test_every_program_is_short_and_runs_here(self):
        programs = sorted(file.name for file in EXAMPLES.glob("*.py"))
        self.assertEqual(len(programs), 7)
        tested = set(re.findall(r'run_program\("(\w+\.py)"', Path(__file__).read_text()))
        self.assertEqual(sorted(tested), programs)
        for name in programs:
            lines = (EXAMPLES / name).read_text().splitlines()
            self.assertLessEqual(len(lines), 60, name)
            self.assertLessEqual(max(map(len, lines)), 130, name)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
