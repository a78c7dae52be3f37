"""The stub of the Python package, from stub.pyi.in and the settings that the library names.

    PYTHONPATH=build/release/python python3 jobs/python/make_stub.py           writes jobs/python/meander/__init__.pyi
    PYTHONPATH=build/release/python python3 jobs/python/make_stub.py --check   exit status 1 where it is another
"""
import inspect
import os
import re
import sys
import textwrap

import numpy

sys.path.pop(0)  # this folder has the package's sources, without its library
import meander  # noqa: E402
from meander import _core  # noqa: E402

FOLDER = os.path.dirname(os.path.abspath(__file__))
STUB = os.path.join(FOLDER, "meander", "__init__.pyi")


def alias(keyword):
    return "".join(part.capitalize() for part in keyword.split("_")) + "Word"


def parameter(row):
    if "option" in row:  # of the program, which has the defaults
        return "%s: %s" % (row["keyword"], "bool = False" if row["type"] == "bool" and not row["truth"] else "Optional[%s] = None" % (
            "Literal[%s]" % ", ".join('"%s"' % word for word in row["words"]) if row["words"] and not row["list"] else
            "Value" if row["type"] == "str" else "Union[int, str]" if row["type"] == "int" else row["type"]))
    if row["list"]:
        return "%s: Union[str, Sequence[str]] = ()" % row["keyword"]
    optional = row["default"] is None
    kind = alias(row["keyword"]) if row["words"] else row["type"]
    default = float(row["default"]) if row["type"] == "float" else row["default"]
    return "%s: %s = %s" % (row["keyword"], "Optional[%s]" % kind if optional else kind,
                            '"%s"' % default if isinstance(default, str) else default)


def column(row):
    kind = "NDArray[numpy.%s]" % numpy.dtype(row["type"])
    return "    %s: %s" % (row["array"], kind if row["always"] else "Optional[%s]" % kind)


def wrapped(line):
    if len(line) <= 120 or not line.startswith("def "):
        return line
    for whole in (" = ", ": ", " -> "):  # no line ends within a parameter
        line = line.replace(whole, whole.replace(" ", "\xa0"))
    depth = 0
    characters = list(line)
    for at, character in enumerate(line):
        depth += (character == "[") - (character == "]")
        if character == " " and depth > 0:
            characters[at] = "\xa0"
    line = "".join(characters)
    return textwrap.fill(line, 120, subsequent_indent=" " * (line.index("(") + 1), break_long_words=False,
                         break_on_hyphens=False).replace("\xa0", " ")


def stub():
    rows = {kind: _core.settings(kind) for kind in ("mesh", "file", "surface", "remesh", "run")}
    aliases = {row["keyword"]: "%s = Literal[%s]" % (alias(row["keyword"]), ", ".join('"%s"' % w for w in row["words"]))
               for row in rows["mesh"] if row["words"]}
    lines = []
    for line in open(os.path.join(FOLDER, "stub.pyi.in")):
        line = line.rstrip("\n")
        if line == "    {columns}":
            lines += (column(row) for row in _core.columns())
            continue
        if line == "{aliases}":
            lines += aliases.values()
            continue
        own = set(re.findall(r"(\w+): ", line))
        function = re.match(r"def (\w+)\(.*{", line)
        taken = inspect.signature(getattr(meander, function[1])).parameters if function else ()
        for kind, settings in rows.items():
            line = line.replace("{%s}" % kind, ", ".join(parameter(row) for row in settings
                                                         if row["keyword"] in taken and row["keyword"] not in own))
        lines.append(wrapped(line))
    return "\n".join(lines) + "\n"


def main():
    if "--check" not in sys.argv:
        with open(STUB, "w") as file:
            file.write(stub())
    elif open(STUB).read() != stub():
        sys.exit("%s is not what jobs/python/make_stub.py makes: run it" % STUB)


if __name__ == "__main__":
    main()
