#!/usr/bin/env python3
"""Makes the distributions of the Python package: a wheel that brings all its libraries and the program, and the sources.

    distribution.py [--build FOLDER] OUT

makes both in OUT, checks the wheel, and says its size and which symbols keep it from older systems. FOLDER is one in which
the targets meander and meander_python are built; without it they are built in build/wheel. pip uses the same functions
(pyproject.toml: PEP 517), with MEANDER_BUILD for the folder. The same build gives the same bytes.

Needs cmake, readelf, strip and patchelf, and the files of dpkg, which say what belongs to which package.
"""
import argparse
import base64
import gzip
import hashlib
import io
import os
import platform
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
import tomllib
import zipfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
import elf  # noqa: E402

SOURCE = Path(__file__).resolve().parents[2]
HERE = "jobs/python"
TIME = int(os.environ.get("SOURCE_DATE_EPOCH", 315532800))  # of all files: 1980, where the time of zip files begins
PROGRAM, LIBRARY, LIBRARIES = "meander/bin/meander", "meander/libmeander.so", "meander/lib"
INTERFACE = "meander_"
# Names all that the build reads: the sources, for those who build them.
OF_SOURCES = ("CMakeLists.txt", "CMakePresets.json", "LICENSE", "README.md", "pyproject.toml", "cmake", "docs/PYTHON.md",
              "io", "jobs", "kernels", "pipeline")


def run(*command, **options):
    return subprocess.run([str(word) for word in command], check=True, **options)


# ---- what the distributions are

class Project:
    def __init__(self):
        told = tomllib.loads((SOURCE / "pyproject.toml").read_text())["project"]
        self.name, self.told = told["name"], told
        self.version = re.search(r"project\(meander VERSION ([0-9.]+)", (SOURCE / "CMakeLists.txt").read_text()).group(1)
        self.stem = "%s-%s" % (self.name.replace("-", "_"), self.version)

    def metadata(self, licenses):
        lines = ["Metadata-Version: 2.1", "Name: " + self.name, "Version: " + self.version,
                 "Summary: " + self.told["description"], "License: " + self.told["license"]["text"],
                 "Requires-Python: " + self.told["requires-python"]]
        lines += ["Classifier: " + text for text in self.told["classifiers"]]
        lines += ["Requires-Dist: " + text for text in self.told["dependencies"]]
        for extra, needed in self.told["optional-dependencies"].items():
            lines += ["Provides-Extra: " + extra]
            lines += ['Requires-Dist: %s; extra == "%s"' % (text, extra) for text in needed]
        lines += ["License-File: " + name for name in licenses]
        lines += ["Description-Content-Type: text/markdown", "", (SOURCE / self.told["readme"]).read_text()]
        return "\n".join(lines)

    def entry_points(self):
        return "[console_scripts]\n" + "".join("%s = %s\n" % item for item in sorted(self.told["scripts"].items()))


# ---- whose files they are

class Packages:
    """The Debian packages that files come from."""

    def __init__(self):
        self.owner = {}
        for listing in Path("/var/lib/dpkg/info").glob("*.list"):
            for path in listing.read_text().splitlines():
                self.owner[path] = listing.stem.partition(":")[0]

    def of(self, path):
        path = os.path.realpath(path)
        for name in (path, path.removeprefix("/usr")):
            if name in self.owner:
                return self.owner[name]
        sys.exit("no package has `%s`: its license is not known" % path)


def compiled_in(build):
    """Headers and archives of the system that a build folder's program and library were made of."""
    # A cross compiler's lie below a folder, where they have the places of those of this system.
    told = re.search(r"^MEANDER_SYSROOT:\w+=(.+)$", (Path(build) / "CMakeCache.txt").read_text(), re.MULTILINE)
    below = told.group(1) if told else ""
    listed = run("ninja", "-C", build, "-t", "deps", stdout=subprocess.PIPE, text=True).stdout
    found, of_product = set(), False
    for line in listed.splitlines():
        if not line.startswith(" "):
            of_product = line.split("/")[0] in ("io", "jobs", "kernels", "pipeline")
        elif of_product and line.strip().startswith(below + "/usr/include/"):
            found.add(line.strip().removeprefix(below))
    for target in ("jobs/meander", "python/meander/libmeander.so"):
        linked = run("ninja", "-C", build, "-t", "query", target, stdout=subprocess.PIPE, text=True).stdout
        found |= set(re.findall(r"\s%s(/usr/lib/\S+\.a)$" % re.escape(below), linked, re.MULTILINE))
    return found


# Only headers of the C library and the compiler are compiled in; their licenses let that pass.
OF_THE_COMPILER = re.compile(r"libc6-dev|linux-libc-dev|libgcc-.*|libstdc\+\+-.*|g\+\+.*|gcc.*|cpp.*")


# ---- the wheel

def shared_libraries(files):
    """{name: path} of the libraries that files need and no system must have, and of those that these need."""
    found, open_files = {}, list(files)
    while open_files:
        file = open_files.pop()
        where = dict(re.findall(r"^\s*(\S+) => (/\S+)", run("ldd", file, stdout=subprocess.PIPE, text=True).stdout,
                                re.MULTILINE))
        for name in elf.Elf(file).needed:
            if name in elf.OF_THE_SYSTEM or name in found:
                continue
            if name not in where:
                sys.exit("%s needs %s, which is not there" % (file, name))
            found[name] = Path(where[name])
            open_files.append(found[name])
    return found


def own_name(name, path):
    """Of a library in the wheel: no other one in the process is taken for it, nor it for another."""
    stem, _, rest = name.partition(".")
    return "%s-%s.%s" % (stem, hashlib.sha256(path.read_bytes()).hexdigest()[:8], rest)


# Beginnings of names of TBB and of Embree, which others in the process may have too, and bind to theirs, or ours to theirs,
# where a library was loaded for all to see. The new ones have the same length and the same hash, 33 a + b being
# 33 (a + 1) + (b - 33), so that no table of the file changes.
OWN_SYMBOLS = {b"3tbb": b"3uAb", b"\0rtc": b"\0sSc"}


def rename_symbols(path):
    data = bytearray(path.read_bytes())
    begin, size = elf.string_table(path)
    names = bytes(data[begin:begin + size])
    for name, own in OWN_SYMBOLS.items():
        names = names.replace(name, own)
    data[begin:begin + size] = names
    path.write_bytes(data)


def put_files(build, root):
    """Puts the package, the program and the libraries below root. Returns the sources of those that are others'."""
    package = build / "python/meander"
    (root / LIBRARIES).mkdir(parents=True)
    (root / PROGRAM).parent.mkdir()
    for path in sorted((SOURCE / HERE / "meander").iterdir()):
        if path.is_file():
            shutil.copy(path, root / "meander" / path.name)
    shutil.copy(SOURCE / HERE / "_meander_program.py", root)
    own = {root / PROGRAM: build / "jobs/meander", root / LIBRARY: package / "libmeander.so"}
    for source in own.values():
        if not source.exists():
            sys.exit("there is no %s: build the targets meander and meander_python there" % source)
    libraries = shared_libraries(own.values())
    names = {name: own_name(name, path) for name, path in libraries.items()}
    placed = dict(own)
    placed.update({root / LIBRARIES / names[name]: path for name, path in libraries.items()})
    for target, source in placed.items():
        shutil.copyfile(source, target)
        run("strip", "--strip-unneeded", target)
        up = os.path.relpath(root / LIBRARIES, target.parent)
        changes = [("--force-rpath", "--set-rpath", "$ORIGIN" if up == "." else "$ORIGIN/" + up)]
        if source not in own.values():
            changes.append(("--set-soname", target.name))
        changes += [("--replace-needed", name, names[name]) for name in elf.Elf(target).needed if name in names]
        for change in changes:  # one at a time: several at once spoil each other's texts (patchelf 0.14)
            run("patchelf", *change, target)
        rename_symbols(target)
        target.chmod(0o755)
    return libraries.values()


def put_licenses(folder, files):
    """The licenses of ours and of the packages that the files come from, the texts that those refer to, and a list."""
    packages = Packages()
    names = {packages.of(file) for file in files}
    folder.mkdir(parents=True)
    shutil.copy(SOURCE / "LICENSE", folder / "LICENSE")
    inside, texts = {}, set()
    for name in sorted(name for name in names if not OF_THE_COMPILER.fullmatch(name)):
        source, version = run("dpkg-query", "-W", "-f", "${source:Package} ${source:Version}", name,
                              stdout=subprocess.PIPE, text=True).stdout.split()
        inside[source] = version
        said = (Path("/usr/share/doc") / name / "copyright").read_text()
        (folder / source).write_text(said)
        texts |= set(re.findall(r"/usr/share/common-licenses/([A-Za-z0-9.-]*[A-Za-z0-9])", said))
    for text in texts:
        shutil.copyfile(Path("/usr/share/common-licenses") / text, folder / text)
    (folder / "PACKAGES").write_text(
        "Libraries, or compiled headers, of these source packages of Debian are in the wheel. The names of the libraries,\n"
        "and of some of their symbols, are changed; nothing else is.\n\n"
        + "".join("%s %s\n" % item for item in sorted(inside.items())))
    return sorted(path.name for path in folder.iterdir())


def digest_of(data):
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def zip_folder(root, record, target):
    """All files below root, in the order of their names, and `record` with their digests as the last."""
    files = sorted(path for path in root.rglob("*") if path.is_file())
    lines = []
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        def add(name, data, mode):
            entry = zipfile.ZipInfo(name, time.gmtime(max(TIME, 315532800))[:6])
            entry.compress_type, entry.create_system = zipfile.ZIP_DEFLATED, 3
            entry.external_attr = (0o100000 | mode) << 16
            archive.writestr(entry, data)
        for path in files:
            name, data = path.relative_to(root).as_posix(), path.read_bytes()
            lines.append("%s,%s,%d" % (name, digest_of(data), len(data)))
            add(name, data, 0o755 if os.access(path, os.X_OK) else 0o644)
        add(record, "\n".join(lines + [record + ",,"]) + "\n", 0o644)


def elf_files(root):
    return [elf.Elf(path) for path in sorted(root.rglob("*"))
            if path.is_file() and path.read_bytes()[:4] == b"\x7fELF"]


def make_wheel(build, out):
    """The path of the wheel of a build folder."""
    project = Project()
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        files = list(put_files(build, root)) + list(compiled_in(build))
        minor, _ = elf.system_of(elf_files(root))
        tag = "py3-none-manylinux_2_%d_%s" % (minor, platform.machine())
        information = root / (project.stem + ".dist-info")
        licenses = put_licenses(information / "licenses", files)
        (information / "METADATA").write_text(project.metadata(licenses))
        (information / "entry_points.txt").write_text(project.entry_points())
        (information / "WHEEL").write_text(
            "Wheel-Version: 1.0\nGenerator: meander\nRoot-Is-Purelib: false\nTag: %s\n" % tag)
        wheel = Path(out) / ("%s-%s.whl" % (project.stem, tag))
        wheel.parent.mkdir(parents=True, exist_ok=True)
        zip_folder(root, information.name + "/RECORD", wheel)
    return wheel


def check_wheel(wheel):
    """(problems, report): what would keep the wheel from bare systems of its tag; and what it is."""
    with tempfile.TemporaryDirectory() as folder:
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(folder)
            unpacked = sum(entry.file_size for entry in archive.infolist())
        files = elf_files(Path(folder))
        problems = elf.problems_of(files, INTERFACE)
        minor, symbols = elf.system_of(files)
        if "manylinux_2_%d_" % minor not in wheel.name:
            problems.append("%s needs glibc 2.%d" % (wheel.name, minor))
        report = ["%s: %.1f MB, %.1f MB unpacked" % (wheel.name, wheel.stat().st_size / 1e6, unpacked / 1e6)]
        report += ["%s: %.1f MB" % (file.path.relative_to(folder), file.path.stat().st_size / 1e6) for file in files]
        report += ["%s: %s" % (name, ", ".join(of_it)) for name, of_it in symbols.items() if minor > elf.MIN_GLIBC]
    return problems, report


# ---- the sources

def make_sources(out):
    """The path of the archive of the sources."""
    project = Project()
    files = [path for name in OF_SOURCES for path in
             ([SOURCE / name] if (SOURCE / name).is_file() else sorted((SOURCE / name).rglob("*"))) if path.is_file()]
    target = Path(out) / (project.stem + ".tar.gz")
    target.parent.mkdir(parents=True, exist_ok=True)
    with open(target, "wb") as file, gzip.GzipFile("", "wb", 9, file, TIME) as packed, \
            tarfile.open(fileobj=packed, mode="w", format=tarfile.PAX_FORMAT) as archive:
        def add(name, data, mode):
            entry = tarfile.TarInfo("%s/%s" % (project.stem, name))
            entry.size, entry.mode, entry.mtime = len(data), mode, TIME
            archive.addfile(entry, io.BytesIO(data))
        for path in files:
            if "__pycache__" not in path.parts:
                add(path.relative_to(SOURCE).as_posix(), path.read_bytes(), 0o755 if os.access(path, os.X_OK) else 0o644)
        add("PKG-INFO", project.metadata(["LICENSE"]).encode(), 0o644)
    return target


# ---- PEP 517, and the command

def built(given):
    if given:
        return Path(given).resolve()
    build = SOURCE / "build/wheel"
    run("cmake", "-S", SOURCE, "-B", build, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON",
        "-DMEANDER_TESTS=OFF", "-DMEANDER_PYTHON_PACKAGE=ON")
    run("cmake", "--build", build, "--target", "meander", "meander_python")
    return build


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    return make_wheel(built(os.environ.get("MEANDER_BUILD")), wheel_directory).name


def build_sdist(sdist_directory, config_settings=None):
    return make_sources(sdist_directory).name


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", metavar="FOLDER", help="where the program and the library are built")
    parser.add_argument("out", metavar="OUT")
    arguments = parser.parse_args()
    wheel = make_wheel(built(arguments.build), arguments.out)
    sources = make_sources(arguments.out)
    problems, report = check_wheel(wheel)
    print("\n".join(report))
    print("%s: %.1f MB" % (sources.name, sources.stat().st_size / 1e6))
    if problems:
        sys.exit("\n".join(problems))


if __name__ == "__main__":
    main()
