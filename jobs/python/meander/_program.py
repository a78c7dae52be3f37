"""The program `meander` beside the package, and runs of it."""
import functools
import json
import os
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy

from ._core import __version__

DONE, SOME_FAILED, USAGE, STOPPED = 0, 3, 2, 75  # exit statuses (jobs/cli/exit_status.h)


class RunStopped(RuntimeError):
    """A run that stopped early, as after a full disk, too many failures or a signal from outside. The same call continues
    it."""


class RunResult:
    """What a finished run did.

    store: the path. items: rows of the store. samples: points a row. done_now: models that this call worked on; the others
    were there before. status: counts of rows by status, "ok" among them. failed: a list of dicts (id, status, reason) of the
    rows that are not ok. notes: what files ask for and did not get, counted by name. seconds: of this call.
    exit_status: of `meander run`, 0, or 3 where items failed or no model has an attribute that was asked for.
    All other members of `meander run --json` are attributes too.
    """

    def __init__(self, summary, exit_status):
        self.__dict__.update(summary)
        self.exit_status = exit_status

    def __repr__(self):
        return "<meander.RunResult %s: %d rows, %d ok, %d failed>" % (
            self.store, self.items, self.status.get("ok", 0), self.items - self.status.get("ok", 0))


@functools.lru_cache(maxsize=1)
def program():
    """The path of the program of this package: in the wheel, the build folder, or the installation that it is in. RuntimeError
    where there is none of this version."""
    package = Path(__file__).resolve().parent
    places = [package / "bin/meander", package.parent.parent / "jobs/meander"]
    places += [folder / "bin/meander" for folder in package.parents]
    found = next((place for place in places if os.access(place, os.X_OK) and place.is_file()), shutil.which("meander"))
    if found is None:
        raise RuntimeError("there is no program `meander` beside the package in %s: install the wheel, or build the target "
                           "`meander`" % package)
    told = subprocess.run([found, "--version"], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True).stdout
    if told.split("\n")[0] != "meander " + __version__:
        raise RuntimeError("`%s` is of another version than the package, %s" % (found, __version__))
    return str(found)


def arguments_of(row, value):
    """The words of the command line that give an option of the library's list this value."""
    if isinstance(value, numpy.generic):
        value = value.item()
    if value is None or value is False and not row["truth"]:
        return []
    if row["type"] == "bool":
        if not isinstance(value, bool):
            raise TypeError("%s cannot be %r: True or False" % (row["keyword"], value))
        return [row["option"] + ("=" + row["truth"][0 if value else 1] if row["truth"] else "")]
    if isinstance(value, bool) or not isinstance(value, (str, int, float, os.PathLike, list, tuple)):
        raise TypeError("%s cannot be %r" % (row["keyword"], value))
    values = [str(one) for one in (value if isinstance(value, (list, tuple)) else [value])]
    return ["%s=%s" % (row["option"], one) for one in (values if row["list"] else [",".join(values)])]


def run(arguments, progress):
    """Runs `meander run` with these arguments, calls progress(done, total, item) after each model, and returns a RunResult.
    Whatever is raised meanwhile ends the program first, as Ctrl-C does."""
    command = [program(), "run", *arguments, "--json", "--progress=json"]
    # The program is in a session of its own: it takes a second signal, as from a terminal and from here, for the wish to stop
    # at once.
    with tempfile.TemporaryFile() as output, subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.PIPE, text=True, encoding="utf-8",
            errors="replace", start_new_session=True) as process:
        try:
            said = _follow(process.stderr, progress)
            status = process.wait()
        except BaseException:
            process.terminate()
            _drain(process)
            raise
        output.seek(0)
        summary = output.read().decode()
    text = "\n".join(said).replace("meander: ", "", 1) or "`meander run` ended with the status %d" % status
    if status in (DONE, SOME_FAILED):
        return RunResult(json.loads(summary), status)
    raise (ValueError if status == USAGE else RunStopped if status == STOPPED else RuntimeError)(text)


def _follow(lines, progress):
    """Hands each finished model to `progress`; returns the lines that are about none."""
    said = []
    for line in lines:
        item = None
        if line.startswith("{"):
            try:
                item = json.loads(line)
            except ValueError:
                pass
        if item is None:
            said.append(line.rstrip("\n"))
        elif progress is not None:
            done, total = item.pop("done"), item.pop("items")
            progress(done, total, item)
    return said


def _drain(process):
    """Waits for the end of a program that was told to stop. Interrupted again, ends it at once: its store continues all the
    same."""
    try:
        for _ in process.stderr:
            pass
        process.wait()
    except BaseException:
        process.kill()
        raise
