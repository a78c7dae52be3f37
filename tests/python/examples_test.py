#!/usr/bin/env python3
"""Runs the examples of the package's docstrings and of documents.

    examples_test.py DOCUMENT...       exit status 77: numpy or h5py is not installed
"""
import doctest
import importlib.util
import os
import sys
import tempfile
from pathlib import Path

for needed in ("numpy", "h5py"):
    if importlib.util.find_spec(needed) is None:
        print("skipped: %s is not installed" % needed)
        sys.exit(77)

import numpy

import meander
import meander.neighbors
import meander.store



def has_laboratory():
    try:
        meander.measure_boxes([[0, 0, 0]], [[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    except RuntimeError as error:
        if "no laboratory" not in str(error):
            raise
        return False
    return True


MEASURES = has_laboratory()
runner = doctest.DocTestRunner()


def run(test):
    """Its failures; without the laboratory what measures is left out, a docstring as a whole."""
    if not MEASURES:
        if test.name.endswith(".measure"):
            test.examples = []
        test.examples = [example for example in test.examples if "meander.measure(" not in example.source]
    return runner.run(test).failed


failed = 0
documents = [Path(name).resolve() for name in sys.argv[1:]]
folder = tempfile.TemporaryDirectory()  # where examples write files
os.chdir(folder.name)
for module in (meander, meander.neighbors, meander.store):
    tests = doctest.DocTestFinder().find(module, extraglobs={"meander": meander, "numpy": numpy})
    failed += sum(map(run, tests))
    print("%s: %d examples" % (module.__name__, sum(len(test.examples) for test in tests)))
for document in documents:
    test = doctest.DocTestParser().get_doctest(document.read_text(encoding="utf-8"), {"__name__": "__main__"},
                                               document.name, str(document), 0)
    failed += run(test) + (not test.examples)
    print("%s: %d examples" % (document.name, len(test.examples)))
os.chdir("/")
folder.cleanup()
if not MEASURES:
    print("left out: examples of measures, in a build without the laboratory")
sys.exit(1 if failed else 0)
