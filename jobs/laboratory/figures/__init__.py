"""The figures of the survey, measured and drawn again: `python3 -m meander.figures -o FOLDER`.

Each figure is a function that measures, writes what it measured as CSV, and draws it. Numbers and pictures of surfaces come
from meander.laboratory and from the program; plots are those of matplotlib, and where that is missing the CSV files stand
alone.
"""
from .. import laboratory
from . import look

try:
    look.use_colors(["#%02x%02x%02x" % tuple(color) for color in laboratory.palette().colors.tolist()])
except RuntimeError:  # a build without the laboratory, of which __main__ tells
    pass
