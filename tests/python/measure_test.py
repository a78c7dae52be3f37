#!/usr/bin/env python3
"""Every measured number of the documents has its command, date and commit, and docs/measure --check finds those that have none.

    measure_test.py SOURCES       exit status 77: Python is older than 3.11, which docs/measure needs
"""
import os
import re
import runpy
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

if sys.version_info < (3, 11):
    print("skipped: Python is older than 3.11")
    sys.exit(77)
SOURCES = Path(sys.argv[1]).resolve()
for name in [name for name in os.environ if name.startswith("GIT_")]:
    del os.environ[name]  # of a hook, say: they name another repository
failed = 0


def measure(root, *words, **environment):
    """Exit status and lines."""
    done = subprocess.run([sys.executable, root / "docs/measure", *words], capture_output=True, text=True,
                          env={**os.environ, **environment})
    return done.returncode, (done.stdout + done.stderr).splitlines()


def expect(what, found, wanted):
    global failed
    if found != wanted:
        failed += 1
        print("%s:\n  found  %s\n  wanted %s" % (what, found, wanted))


def commit(root, **files):
    """Writes files, commits them, and returns the hash."""
    for name, text in files.items():
        path = root / name.replace("__", "/").replace("_", ".")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    git = ["git", "-C", root, "-c", "user.name=test", "-c", "user.email=test@example.org", "-c", "commit.gpgsign=false"]
    for words in (["init", "-q"], ["add", "-A"], ["commit", "-q", "-m", "test"]):
        subprocess.run([*git, *words], check=True)
    return subprocess.run([*git, "rev-parse", "--short", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()


# ---- the documents as they are

status, lines = measure(SOURCES, "--check")
expect("the documents", (status, lines), (0, ["every number has its command, date and commit"]))
spec = subprocess.run([sys.executable, "-c", "import sys, tomllib; print(*tomllib.load(open(sys.argv[1], 'rb')))",
                       SOURCES / "docs/measurements.toml"], check=True, capture_output=True, text=True)
listed = [line.split()[0] for line in measure(SOURCES, "--list")[1]]
expect("--list", listed, spec.stdout.split())

# ---- a copy of them in which something is wrong, without the history

DOCUMENTS = runpy.run_path(str(SOURCES / "docs/measure"), run_name="measure")["DOCUMENTS"]
TABLE = re.compile(r"<!-- measured (\S+) (\S+) (\S+) -->\n(?=\|)")  # a mark directly above a table
text = (SOURCES / "README.md").read_text()
mark = TABLE.search(text)
at = text[:mark.start()].count("\n") + 1
with tempfile.TemporaryDirectory() as folder:
    copy = Path(folder).resolve()
    (copy / "docs").mkdir()
    for name in ["docs/measure", "docs/measurements.toml", *DOCUMENTS]:
        shutil.copy(SOURCES / name, copy / name)

    def check_with(what, changed, wanted, document="README.md"):
        """One line is wanted, which begins so."""
        kept = (copy / document).read_text()
        assert changed != kept, what
        (copy / document).write_text(changed)
        status, lines = check()
        (copy / document).write_text(kept)
        expect(what, (status, [line[:len(w)] for line, w in zip(lines, wanted)], len(lines)), (1, wanted, len(wanted)))

    def replaced(part, new):
        return text[:mark.start(part)] + new + text[mark.end(part):]

    def check():
        return measure(copy, "--check", GIT_CEILING_DIRECTORIES=str(copy.parent))

    expect("a copy", check()[0], 0)
    page = copy / "docs/LABORATORY.md"
    page.write_text(re.sub(r"<!-- (not )?measured.*?-->\n", "", page.read_text(), flags=re.DOTALL))
    lines = [line for line in check()[1] if not line.startswith("docs/measurements.toml")]
    expect("no mark at all", (len(lines) > 5, {re.sub(r":\d+: \w+", "", line) for line in lines}),
           (True, {"docs/LABORATORY.md with a number, without a mark"}))
    shutil.copy(SOURCES / "docs/LABORATORY.md", page)
    check_with("an unknown name", text.replace(mark[0], mark[0] + mark[0].replace(mark[1], "no-entry"), 1),
               ["README.md:%d: `no-entry` is no entry" % (at + 1)])
    check_with("a date that is none", replaced(2, "2026-02-30"), ["README.md:%d: `2026-02-30` is no date" % at])
    check_with("a date of another form", replaced(2, "1/2/2026"), ["README.md:%d: `1/2/2026` is no date" % at])
    check_with("a commit that is none", replaced(3, "yesterday"), ["README.md:%d: `yesterday` is no commit" % at])
    check_with("no commit", replaced(3, ""), ["README.md:%d: `` is no commit" % at])
    count, end = text.count("\n") + 1, text.rstrip("\n")
    for number in ("takes 0.25 of it", "takes 17 ms", "takes 3 %", "found 40 models a second", "needs 2 GiB", "is .02"):
        check_with("a paragraph, " + number, end + "\n\n# More\n\nIt\n%s.\n" % number,
                   ["README.md:%d: paragraph with a number, without a mark" % (count + 4)])
    check_with("an item", end + "\n\n# More\n\n* It\n* takes 5 s\n",
               ["README.md:%d: item with a number, without a mark" % (count + 4)])
    check_with("a table", end + "\n\n# More\n\n| a | b |\n|---|---|\n| `4` | 4 |\n",
               ["README.md:%d: table with a number, without a mark" % (count + 5)])
    check_with("a heading ends a mark", end + "\n\n# More\n\n<!-- not measured: a test -->\n0.5\n\n## Then\n\n0.5\n",
               ["README.md:%d: paragraph with" % (count + 8)])
    check_with("no reason", end + "\n\n# More\n\n<!-- not measured: -->\n0.5\n", ["README.md:%d: `not measured`" % (count + 3)])
    entries = (copy / "docs/measurements.toml").read_text()
    check_with("an entry without command or numbers", entries + "\n[unused]\nminutes = 1\n",
               ["docs/measurements.toml:%d: `unused` has no command" % (entries.count("\n") + 2),
                "docs/measurements.toml:%d: no document" % (entries.count("\n") + 2)], "docs/measurements.toml")
    quiet = end + "\n\n# 0.5\n\n    0.5 s\n\n`0.5 s` in [0.5 s](a.md#1.5) of METHODS 6.5\n\n```\n0.5 s\n```\n\n12 models\n"
    (copy / "README.md").write_text(quiet)
    expect("what is no number", check()[0], 0)
    expect("a name that is none", measure(copy, "no-entry")[0], 2)
    measured = measure(copy, mark[1], "--build", str(copy))
    expect("a build that is missing", (measured[0], "build it, or give --build" in measured[1][0]), (2, True))

# ---- a repository of its own: commits, and the method version

with tempfile.TemporaryDirectory() as folder:
    root = Path(folder).resolve()
    if not shutil.which("git"):
        print("left out: git is not installed")
        sys.exit(1 if failed else 0)
    (root / "docs").mkdir()
    shutil.copy(SOURCES / "docs/measure", root / "docs/measure")
    version = "inline constexpr std::uint32_t store_method_version = %d;\n"
    entries = '[one]\ncommand = "echo measured"\nminutes = 1\n[two]\ncommand = "false"\nminutes = 1\n'
    old = commit(root, io__store__store_h=version % 1, docs__measurements_toml=entries)
    new = commit(root, io__store__store_h=version % 2)
    newest = commit(root, io__store__store_h="// more\n" + version % 2, build__release__jobs__meander="")
    for name in DOCUMENTS[1:]:
        (root / name).write_text("No number.\n")
    page = "<!-- measured one 2026-01-01 %s -->\n0.5\n\n<!-- measured two 2026-01-02 %s -->\n0.5\n" % (new, old)
    (root / "README.md").write_text(page)
    expect("known commits", measure(root, "--check")[0], 0)
    expect("stale", measure(root, "--stale"), (0, ["2026-01-02  README.md:4: two (%s)" % old,
                                                  "1 of 2 marks are older than %s of %s, the last change of the method version"
                                                  % (new, subprocess.run(["git", "-C", root, "log", "-1", "--format=%cs"], check=True,
                                                                         capture_output=True, text=True).stdout.strip())]))
    (root / "README.md").write_text(page.replace(old, "0123456789ab"))
    expect("an unknown commit", measure(root, "--check"), (1, ["README.md:4: `0123456789ab` is no commit"]))
    status, lines = measure(root, "one")
    expect("a mark", (status, lines[:2], bool(re.fullmatch(r"<!-- measured one \d{4}-\d\d-\d\d %s -->" % newest, lines[2]))),
           (0, ["$ echo measured", "measured"], True))
    expect("a command that fails", measure(root, "two"), (1, ["$ false", "measure: no mark for `two`: its command ended with 1"]))
    (root / "io/store/store.h").write_text(version % 3)
    expect("no mark of what no commit has", measure(root, "one"), (1, [
        "$ echo measured", "measured", "measure: no mark for `one`: what was measured is no commit: io/store/store.h changed"]))
sys.exit(1 if failed else 0)
