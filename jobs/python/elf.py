"""What programs and shared libraries ask of the system that they run on, read with readelf."""
import re
import subprocess
from pathlib import Path

# Every system for Python has these; all else has to be in the wheel.
OF_THE_SYSTEM = {"ld-linux-x86-64.so.2", "ld-linux-aarch64.so.1", "libc.so.6", "libm.so.6", "libgcc_s.so.1",
                 "libstdc++.so.6"}

# Symbols of TBB and Embree, which others bring too: a library that was loaded for all to see would take the place of ours.
SHARED_NAME = re.compile(r"_Z.*3tbb|rtc[A-Z]")

# Minor version of glibc that a system has with which that of libstdc++ came: AlmaLinux 9, Ubuntu 22.04, Ubuntu 23.10,
# Ubuntu 24.04, Ubuntu 25.04. Older ones do not matter, for threads moved into libc.so with glibc 2.34.
MIN_GLIBC = 34
GLIBC_OF_LIBSTDCXX = {29: 34, 30: 35, 31: 38, 32: 38, 33: 39, 34: 41}


def readelf(path, what):
    return subprocess.run(["readelf", "--wide", what, str(path)], check=True, stdout=subprocess.PIPE, text=True,
                          env={"LC_ALL": "C", "PATH": "/usr/bin:/bin"}).stdout


def string_table(path):
    """(begin, size) of the names of dynamic symbols and libraries in the file."""
    place = re.search(r"\.dynstr +STRTAB +[0-9a-f]+ ([0-9a-f]+) ([0-9a-f]+) ", readelf(path, "--sections"))
    return int(place.group(1), 16), int(place.group(2), 16)


class Elf:
    """path, soname, needed: names of libraries; paths: where it looks for them; wants: {(symbol, version)} that the system
    must have; versions: all that are named, those without a symbol too; exports: names of symbols."""

    def __init__(self, path):
        self.path = Path(path)
        dynamic = readelf(path, "--dynamic")
        self.needed = re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic)
        self.soname = next(iter(re.findall(r"\(SONAME\).*\[(.*)\]", dynamic)), None)
        self.paths = [path for entry in re.findall(r"\((?:RPATH|RUNPATH)\).*\[(.*)\]", dynamic)
                      for path in entry.split(":")]
        self.versions = set(re.findall(r"Name: (\S+)  Flags", readelf(path, "--version-info")))
        self.wants, self.exports = set(), set()
        for line in readelf(path, "--dyn-syms").splitlines():
            words = line.split()
            if len(words) < 8 or words[4] == "LOCAL" or not words[0].endswith(":"):
                continue
            name, _, version = words[7].partition("@")
            if words[6] == "UND":
                self.wants.add((name, version))
            elif words[6] != "ABS" and words[5] in ("DEFAULT", "PROTECTED"):
                self.exports.add(name)



def min_glibc(version):
    """The minor version of glibc of the first systems that have a version of their libraries; 0 for what all have."""
    numbers = re.fullmatch(r"(GLIBC|GLIBCXX)_([0-9.]+)", version)
    if version.startswith("GLIBC_ABI_"):
        return 36
    if not numbers:
        return 0
    minor = [int(number) for number in numbers.group(2).split(".")]
    if numbers.group(1) == "GLIBC":
        return minor[1]
    if minor[:2] != [3, 4] or minor[-1] not in GLIBC_OF_LIBSTDCXX:
        return 0 if minor[:2] == [3, 4] and minor[-1] < min(GLIBC_OF_LIBSTDCXX) else 999
    return GLIBC_OF_LIBSTDCXX[minor[-1]]


def system_of(files):
    """(minor version of glibc, {file name: symbols that need it}) of the oldest systems that have all that is wanted."""
    by_minor = {}
    for elf in files:
        without_symbols = elf.versions - {version for _, version in elf.wants}
        for name, version in [("%s@%s" % want, want[1]) for want in elf.wants] + [(name, name) for name in without_symbols]:
            by_minor.setdefault(min_glibc(version), {}).setdefault(elf.path.name, set()).add(name)
    minor = max(MIN_GLIBC, *by_minor)
    return minor, {name: sorted(symbols) for name, symbols in sorted(by_minor.get(minor, {}).items())}


def problems_of(files, interface):
    """What keeps a set of files, which bring each other, from being loaded on a bare system, and what could disturb
    others that are loaded beside them. interface: prefix of the names that the library may export."""
    brought = {elf.soname or elf.path.name for elf in files}
    problems = []
    for elf in files:
        name = elf.path.name
        problems += ["%s needs %s" % (name, needed) for needed in elf.needed
                     if needed not in OF_THE_SYSTEM | brought]
        problems += ["%s looks in `%s`" % (name, path) for path in elf.paths if not path.startswith("$ORIGIN")]
        for needed in set(elf.needed) & brought:
            at = [elf.path.parent / path.replace("$ORIGIN", ".") / needed for path in elf.paths]
            if not any(path.exists() for path in at):
                problems.append("%s does not find %s" % (name, needed))
        problems += ["%s shares the name %s with others" % (name, symbol)
                     for symbol in sorted(elf.exports | {symbol for symbol, _ in elf.wants}) if SHARED_NAME.match(symbol)]
        if name == "libmeander.so":
            problems += ["%s exports %s" % (name, symbol) for symbol in sorted(elf.exports)
                         if not symbol.startswith(interface)]
    return problems
