"""The commands that jobs/quickstart names at its end do what it says, on a store as it makes one.

    quickstart_test.py SOURCE BUILD PROGRAM
"""
import os
import pathlib
import subprocess
import sys
import tempfile

BUNNY = "/usr/share/glmark2/models/bunny.obj"


def main():
    source, build, program = map(os.path.abspath, sys.argv[1:])
    script = pathlib.Path(source, "jobs", "quickstart").read_text()
    named = script[script.index("To try next:\n"):script.index("\nNEXT\n", script.index("To try next:\n"))]
    commands = [line.strip() for line in named.splitlines()[1:]]
    assert len(commands) == 3, commands
    with tempfile.TemporaryDirectory() as folder:
        os.makedirs(os.path.join(folder, "build"))
        os.symlink(build, os.path.join(folder, "build", "quickstart"))
        os.makedirs(os.path.join(folder, "out"))
        pathlib.Path(folder, "corner.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        subprocess.run([program, "run", "corner.obj", "-o", "out/quickstart.h5", "-n", "64"], cwd=folder, check=True)
        for command in commands:
            if BUNNY in command and not (os.path.exists(BUNNY) and os.path.exists(os.path.join(build, "python/meander/libmeander.so"))):
                print("left out, without glmark2-data or the Python package:", command)
                continue
            done = subprocess.run(["bash", "-c", command], cwd=folder, capture_output=True, text=True)
            print(command, done.stdout, done.stderr, sep="\n")
            assert done.returncode == 0 and done.stdout, command
            assert BUNNY not in command or "2048 points" in done.stdout, done.stdout
        assert list(pathlib.Path(folder, "out", "arrays").rglob("*.npz")), "no arrays"


main()
