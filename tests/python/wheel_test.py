#!/usr/bin/env python3
"""The wheel, made of a build folder without network, in a virtual environment of its own.

    wheel_test.py SOURCE BUILD       exit status 77: pip, setuptools or wheel is not installed
"""
import importlib.util
import os
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

for needed in ("pip", "setuptools", "wheel", "numpy", "venv"):
    if importlib.util.find_spec(needed) is None:
        print("skipped: %s is not installed" % needed)
        sys.exit(77)

CHECK = """
import meander, sys
assert meander.__file__.startswith(sys.prefix), meander.__file__
assert meander.__version__ == VERSION
square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
samples = meander.sample(square, [[0, 1, 2, 3]], n=100)
assert samples.points.shape == (100, 3) and abs(samples.area - 1) < 1e-12
"""


def main():
    source, build = map(Path, sys.argv[1:])
    before = {path.name for path in source.iterdir()}
    environment = {**os.environ, "MEANDER_BUILD": str(build), "PIP_DISABLE_PIP_VERSION_CHECK": "1"}
    environment.pop("PYTHONPATH", None)

    def run(*command, **options):
        done = subprocess.run([str(word) for word in command], env=environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, **options)
        assert done.returncode == 0, "%s\n%s" % (command, done.stdout)

    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        run(sys.executable, "-m", "pip", "wheel", "--no-build-isolation", "--no-index", "--no-deps", "-w", folder, source)
        [wheel] = folder.glob("meander-*.whl")
        names = zipfile.ZipFile(wheel).namelist()
        for name in ("__init__.py", "__init__.pyi", "py.typed", "store.py"):
            assert "meander/" + name in names, names
        assert any(name.startswith("meander/_core.") for name in names), names
        assert "none-any" not in wheel.name, wheel.name
        run(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", folder / "venv")
        python = folder / "venv/bin/python"
        run(python, "-m", "pip", "install", "--no-index", "--no-deps", wheel)
        run(python, "-c", CHECK.replace("VERSION", repr(wheel.name.split("-")[1])), cwd=folder)
    assert {path.name for path in source.iterdir()} <= before | {"build"}, "the wheel leaves files in the source"


main()
