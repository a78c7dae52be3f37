#!/usr/bin/env python3
"""The wheel of a build folder: what it asks of the system, what is in it, and how it does in an environment of its own.

    wheel_test.py SOURCE BUILD       exit status 77: pip, venv, numpy, patchelf or binutils is not installed
"""
import base64
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
import unittest
import zipfile
from pathlib import Path

missing = [name for name in ("pip", "numpy", "venv") if importlib.util.find_spec(name) is None]
missing += [name for name in ("patchelf", "readelf", "strip") if shutil.which(name) is None]
if missing:
    print("skipped: %s is not installed" % ", ".join(missing))
    sys.exit(77)

SOURCE, BUILD = (Path(name).resolve() for name in sys.argv[1:3])
SYSTEM_TBB = next(Path("/usr/lib").glob("*/libtbb.so.12"))
sys.path.insert(0, str(SOURCE / "jobs/python"))
sys.dont_write_bytecode = True
import distribution  # noqa: E402
import elf  # noqa: E402

SAMPLE = """
square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
samples = meander.sample(square, [[0, 1, 2, 3]], n=20000)
assert samples.points.shape == (20000, 3) and abs(samples.area - 1) < 1e-12
many = meander.sample_many([(square, [[0, 1, 2, 3]])] * 20, 20000)
assert all((one.points == samples.points).all() for one in many)
"""
STORE = """
import subprocess, sys
subprocess.run([sys.prefix + "/bin/meander", "run", "square.off", "-o", "store.h5", "--fresh", "-n", "500", "--progress",
                "none"], check=True, stdout=subprocess.DEVNULL)
assert meander.run("square.off", "again.h5", n=500).exit_status == 0  # by the program in the wheel
assert open("again.h5", "rb").read() == open("store.h5", "rb").read()
with meander.open_store("store.h5") as store:
    assert (store["square.off"]["points"] == meander.sample(meander.read_mesh("square.off"), n=500).points).all()
"""
TORCH = """
lines = torch.ones(300, 300) @ torch.ones(300, 300)
assert float(lines.sum()) == 300.0 ** 3
assert torch.from_numpy(samples.points).shape == (20000, 3)
"""
OPEN3D = """
cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(samples.points.astype(float)))
assert len(cloud.points) == 20000 and not cloud.compute_nearest_neighbor_distance() == []
"""
OTHERS = {"h5py": STORE, "torch": TORCH, "open3d": OPEN3D}


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.holder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.holder.cleanup)
        cls.folder = Path(cls.holder.name)
        cls.wheel = distribution.make_wheel(BUILD, cls.folder)
        cls.archive = zipfile.ZipFile(cls.wheel)
        cls.python = cls.folder / "venv/bin/python"
        cls.run_it(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", cls.folder / "venv")
        cls.run_it(cls.python, "-m", "pip", "install", "--no-index", "--no-deps", cls.wheel)
        (cls.folder / "square.off").write_text("OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n")

    @classmethod
    def run_it(cls, *command):
        environment = {**os.environ, "PIP_DISABLE_PIP_VERSION_CHECK": "1", "PIP_NO_CACHE_DIR": "1",
                       "MEANDER_BUILD": str(BUILD)}
        environment.pop("PYTHONPATH", None)
        done = subprocess.run([str(word) for word in command], env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, cwd=cls.folder)
        assert done.returncode == 0, "%s\n%s" % (command, done.stdout)
        return done.stdout

    def test_requires_only_the_system_libraries_of_its_tag(self):
        problems, report = distribution.check_wheel(self.wheel)
        self.assertEqual(problems, [])
        print("\n".join(report))

    def test_the_check_finds_missing_libraries_and_exported_symbols(self):
        library = elf.Elf(BUILD / "python/meander/libmeander.so")
        problems = "\n".join(elf.problems_of([library], "meander_s"))
        self.assertIn("libmeander.so needs libtbb.so.12", problems)
        self.assertIn("libmeander.so exports meander_about", problems)
        self.assertNotIn("libc.so.6", problems)
        problems = elf.problems_of([library, elf.Elf(SYSTEM_TBB)], "meander_")
        self.assertIn("libmeander.so does not find libtbb.so.12", problems)
        self.assertTrue(any("libtbb.so.12 shares the name _ZN3tbb" in problem for problem in problems))
        self.assertEqual([elf.min_glibc(version) for version in
                          ("GLIBC_2.2.5", "GLIBC_2.36", "GLIBCXX_3.4.21", "GLIBCXX_3.4.30", "GLIBCXX_3.4.99", "GCC_3.0")],
                         [2, 36, 0, 35, 999, 0])

    def test_pip_builds_identical_bytes_from_the_sources(self):
        sources = distribution.make_sources(self.folder)
        self.run_it(sys.executable, "-m", "pip", "wheel", "--no-index", "--no-deps", "-w", "again", sources)
        self.assertEqual((self.folder / "again" / self.wheel.name).read_bytes(), self.wheel.read_bytes())
        with tarfile.open(sources) as archive:
            archive.extractall(self.folder)
        unpacked = self.folder / sources.name.removesuffix(".tar.gz")
        self.assertIn("Name: meander-sampling\n", (unpacked / "PKG-INFO").read_text())
        self.run_it("cmake", "-S", unpacked, "-B", self.folder / "configured", "-G", "Ninja", "-DMEANDER_TESTS=OFF")

    def test_lists_every_file_with_its_hash_and_all_licenses(self):
        names = self.archive.namelist()
        [information] = {name.split("/")[0] for name in names if ".dist-info/" in name}
        lines = self.archive.read(information + "/RECORD").decode().splitlines()
        self.assertEqual([line.split(",")[0] for line in lines], names)
        self.assertEqual(names[:-1], sorted(names[:-1]))
        for line in lines[:-1]:
            name, digest, size = line.split(",")
            data = self.archive.read(name)
            sha256 = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).decode().rstrip("=")
            self.assertEqual((digest, int(size)), ("sha256=" + sha256, len(data)))
        metadata = self.archive.read(information + "/METADATA").decode()
        self.assertIn("\nName: meander-sampling\n", metadata)
        self.assertIn("\nRequires-Dist: numpy\n", metadata)
        licenses = {Path(name).name for name in names if "/licenses/" in name}
        for package in ("LICENSE", "PACKAGES", "onetbb", "embree", "hdf5", "eigen3", "cli11", "nlohmann-json3",
                        "Apache-2.0"):
            self.assertIn(package, licenses)
        self.assertEqual({entry.date_time for entry in self.archive.infolist()}, {(1980, 1, 1, 0, 0, 0)})

    def test_contains_the_program_and_package_of_the_build(self):
        version = self.run_it(BUILD / "jobs/meander", "--version")
        self.assertEqual(self.run_it(self.folder / "venv/bin/meander", "--version"), version)
        self.run_it(self.python, "-c", "import sys, meander\nassert meander.__file__.startswith(sys.prefix)\n"
                    "assert meander.__version__ in %r" % version + SAMPLE)
        maps = self.run_it(self.python, "-c", "import meander; print(open('/proc/self/maps').read())")
        for library in ("libtbb", "libembree"):
            loaded = {line.split()[-1] for line in maps.splitlines() if library in line}
            self.assertEqual(len(loaded), 1, loaded)
            self.assertIn("/venv/lib/python3", loaded.pop())

    def test_a_globally_loaded_library_does_not_replace_its_own(self):
        trace = self.folder / "bindings"
        self.run_it("env", "LD_DEBUG=bindings", "LD_DEBUG_OUTPUT=%s" % trace, self.python, "-c",
                    "import ctypes, meander\nctypes.CDLL(%r, ctypes.RTLD_GLOBAL)\n" % str(SYSTEM_TBB) + SAMPLE)
        self.run_it("env", "LD_DEBUG=bindings", "LD_DEBUG_OUTPUT=%s" % trace, self.python, "-c",
                    "import ctypes\nctypes.CDLL(%r, ctypes.RTLD_GLOBAL)\nimport meander" % str(SYSTEM_TBB) + SAMPLE)
        for process in self.folder.glob("bindings.*"):
            bound = [line.split() for line in process.read_text(errors="replace").splitlines()
                     if "/libmeander.so" in line]
            targets = {words[words.index("to") + 1] for words in bound if "to" in words}
            self.assertTrue(any("/libtbb-" in target for target in targets), targets)
            self.assertNotIn(str(SYSTEM_TBB), targets)

    def test_works_with_other_packages_in_any_import_order(self):
        for name, use in OTHERS.items():
            if importlib.util.find_spec(name) is None:
                continue
            for order in ("import meander, %s", "import %s, meander"):
                with self.subTest(order % name):
                    self.run_it(self.python, "-c", order % name + SAMPLE + use + SAMPLE)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
