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

failed = 0
documents = [Path(name).resolve() for name in sys.argv[1:]]
folder = tempfile.TemporaryDirectory()  # where examples write files
os.chdir(folder.name)
for module in (meander, meander.neighbors, meander.store):
    result = doctest.testmod(module, extraglobs={"meander": meander, "numpy": numpy})
    print("%s: %d examples" % (module.__name__, result.attempted))
    failed += result.failed
for document in documents:
    result = doctest.testfile(str(document), module_relative=False)
    print("%s: %d examples" % (document.name, result.attempted))
    failed += result.failed + (result.attempted == 0)
os.chdir("/")
folder.cleanup()
sys.exit(1 if failed else 0)
