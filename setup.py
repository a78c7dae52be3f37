"""Builds the wheel of the Python package with CMake; pyproject.toml says what it is.

MEANDER_BUILD names a build folder whose module is taken as it is (the target meander_python must be built); without it
the library is built for this interpreter in build/wheel.
"""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

SOURCE = Path(__file__).resolve().parent
GIVEN = os.environ.get("MEANDER_BUILD")
BASE = (Path(GIVEN) if GIVEN else SOURCE / "build").resolve() / "wheel"


class BuildWithCMake(build_ext):
    def build_extension(self, extension):
        name = Path(self.get_ext_fullpath(extension.name))
        built = Path(GIVEN).resolve() if GIVEN else self.build_module()
        module = built / "python/meander" / name.name
        if not module.exists():
            sys.exit("there is no %s: build the target meander_python there with this interpreter" % module)
        name.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(module, name)

    def build_module(self):
        folder = BASE / "cmake"
        subprocess.run(["cmake", "-S", SOURCE, "-B", folder, "-DCMAKE_BUILD_TYPE=Release", "-DMEANDER_TESTS=OFF",
                        "-DMEANDER_PYTHON_MODULE=ON", "-DMEANDER_PYTHON=" + sys.executable], check=True)
        subprocess.run(["cmake", "--build", folder, "--target", "meander_python", "--parallel", str(os.cpu_count())],
                       check=True)
        return folder


version = re.search(r"project\(meander VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text()).group(1)
BASE.mkdir(parents=True, exist_ok=True)
setup(version=version, packages=["meander"], package_dir={"meander": "jobs/python/meander"},
      package_data={"meander": ["*.pyi", "py.typed"]}, ext_modules=[Extension("meander._core", [])],
      cmdclass={"build_ext": BuildWithCMake},
      options={"build": {"build_base": str(BASE)}, "egg_info": {"egg_base": str(BASE)},
               "bdist_wheel": {"bdist_dir": str(BASE / "bdist")}})
