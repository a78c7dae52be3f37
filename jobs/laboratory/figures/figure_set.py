"""What the figures share: where their files go, and the page that shows them."""
import contextlib
import csv
import html
import io
import os
import re
import struct
import subprocess
import sys
import urllib.parse
import zlib

import numpy

from .. import SamplingError, laboratory
from . import look

STYLE = """
:root{color-scheme:light dark}body{font:16px/1.5 system-ui,sans-serif;margin:2rem auto;max-width:70rem;padding:0 1rem}
h2{margin-top:3rem}figure{margin:1rem 0}img{max-width:100%;background:#fff}figcaption{font-size:.9em;opacity:.8}
table{border-collapse:collapse;font-size:.85em;display:block;overflow-x:auto}td,th{padding:.2em .7em;text-align:right}
td:first-child,th:first-child{text-align:left}tr:nth-child(even){background:#8881}
nav ul{columns:19rem;column-gap:2.5rem;list-style:none;margin:1.5rem 0;padding:0}
nav li{break-inside:avoid;line-height:1.3;padding:.25em 0 .25em 1em;text-indent:-1em}
"""


# Names of the files that figures are written to; what else stands in the folder is left alone.
OWN_NAMES = re.compile(r"(figure\d\d|table1|histogram_floors|limit|metro|point_sets|spaced).*\.(svg|png|csv|json|ply)|index\.html")
# How files of each kind begin.
HEADS = {".svg": (b"<?xml", b"<svg"), ".png": (b"\x89PNG",), ".ply": (b"ply",), ".json": (b"{", b"["),
         ".html": (b"<!DOCTYPE html>",)}


def refuse_others(folder):
    """Raises ValueError where a file that figures would replace is of another kind: then it is not theirs."""
    for name in sorted(os.listdir(folder)):
        path, kind = os.path.join(folder, name), os.path.splitext(name)[1]
        if not OWN_NAMES.fullmatch(name):
            continue
        with open(path, "rb") as file:
            head = file.read(4096)
        if kind == ".csv" and b"," in head.partition(b"\n")[0]:
            continue
        if head and not head.startswith(HEADS.get(kind, ())):
            raise ValueError("`%s` would be replaced, and is no %s file of figures: remove it, or give another folder"
                             % (path, kind[1:].upper()))


def png_bytes(pixels):
    """The PNG file of (height, width, 3) uint8."""
    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)), (b"IDAT", zlib.compress(rows, 9)),
              (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)) for kind, data in chunks)


def _cell(value):
    if value is None:
        return ""
    if isinstance(value, (float, numpy.floating)):
        return "%.6g" % value
    return str(value)


class FigureSet:
    """quick, seed, models: as asked for. points: (name, file) of point sets on the model. view, up: (3,) directions. size: pixels
    of a picture of a model."""

    def __init__(self, options, models):
        self.quick, self.seed, self.models, self.points = options.quick, options.seed, models, options.points
        self.up = numpy.eye(3)["xyz".index(options.up)]
        self.view = numpy.array(options.view or laboratory.default_view(up=options.up).view)
        self.view_given = options.view is not None
        self.size = options.size or (280 if self.quick else 800)
        self.folder = options.output
        os.makedirs(self.folder, exist_ok=True)
        refuse_others(self.folder)
        self._parts = []
        self._contents = []

    # ---- the page

    def begin(self, name, caption):
        """A section of the page: the caption of the figure, and what the survey says of it."""
        anchor = urllib.parse.quote("figure-" + name)
        self._contents.append('<li><a href="#%s">%s</a></li>' % (anchor, html.escape(caption.title)))
        self._parts.append('<h2 id="%s">%s</h2>' % (anchor, html.escape(caption.title)))
        self._claim, self._measured = caption.claim, False

    def measured(self, text):
        """The line that stands beside the survey's claim: what was measured here."""
        if self._claim and not self._measured:
            self.text("The survey says", self._claim)
        self._measured = True
        self.text("Measured here", text)

    def text(self, label, text):
        self._parts.append("<p><b>%s.</b> %s</p>" % (html.escape(label), html.escape(text)))

    def note(self, text):
        """Progress, on standard error."""
        print("           " + text, file=sys.stderr, flush=True)

    def not_drawn(self, reason):
        self.note("not drawn: " + reason)
        self.text("Not drawn", reason)

    @contextlib.contextmanager
    def attempt(self, name):
        """A model that cannot be sampled is said on the page, and the others go on."""
        try:
            yield
        except SamplingError as error:
            self.not_drawn("%s: %s" % (name, error))

    # ---- files

    def write(self, name, data):
        """Bytes or text, whole or not at all."""
        if not OWN_NAMES.fullmatch(name):
            raise RuntimeError("`%s` is no name of a figure" % name)
        path = os.path.join(self.folder, name)
        with open(path + ".part", "wb") as file:
            file.write(data.encode() if isinstance(data, str) else data)
        os.replace(path + ".part", path)

    def _link(self, name):
        self._parts.append('<p><a href="%s">%s</a></p>' % (urllib.parse.quote(name), html.escape(name)))

    def _image(self, name, caption):
        self._parts.append('<figure><img src="%s" alt="%s"><figcaption>%s</figcaption></figure>'
                           % (urllib.parse.quote(name), html.escape(caption), html.escape(caption)))

    def table(self, stem, caption, columns, rows, shown=True):
        """CSV, and on the page where it is `shown`."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(columns)
        writer.writerows([_cell(value) for value in row] for row in rows)
        self.write(stem + ".csv", text.getvalue())
        if shown:
            line = lambda tag, values: "<tr>%s</tr>" % "".join(
                "<%s>%s</%s>" % (tag, html.escape(_cell(value)), tag) for value in values)
            self._parts.append("<p>%s</p><table>%s%s</table>" % (
                html.escape(caption), line("th", columns), "".join(line("td", row) for row in rows)))
        self._link(stem + ".csv")

    def plot(self, stem, caption, draw, width=7.2, height=4.6, **grid):
        """draw(axes) on axes of matplotlib, as SVG and PNG; **grid of plt.subplots (then axes is an array). The data
        stands in a table of its own."""
        if not look.available():
            self.text("No plot", "matplotlib is missing (package python3-matplotlib): the CSV files have the data.")
            return
        figure, axes = look.subplots(width, height, **grid)
        draw(axes)
        for suffix, data in look.saved(figure):
            self.write(stem + suffix, data)
        self._image(stem + ".svg", caption)

    def panels(self, stem, caption, images, columns=None):
        """Pictures beside each other: images are (pixels, title, note) with pixels (h, w, 3) uint8."""
        if look.available():
            self.write(stem + ".png", look.panels(images, columns or len(images)))
            self._image(stem + ".png", caption)
            return
        for number, (pixels, title, _) in enumerate(images):
            name = "%s_%d.png" % (stem, number)
            self.write(name, png_bytes(pixels))
            self._image(name, title)

    def data(self, name, data):
        """Another file, linked from the page."""
        self.write(name, data)
        self._link(name)

    def run_program(self, *words):
        """Runs the program with these arguments and returns what it printed."""
        program = os.environ.get("MEANDER_PROGRAM", "meander")
        done = subprocess.run([program, *map(str, words)], capture_output=True, text=True)
        if done.returncode:
            raise SamplingError("unreadable", done.stderr.strip().removeprefix("meander: "))
        return done.stdout

    def write_page(self, footer):
        page = os.path.join(self.folder, "index.html")
        self.write("index.html", "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
                   "content=\"width=device-width\"><title>The survey, figure by figure</title><style>%s</style></head><body>"
                   "<h1>The survey, figure by figure</h1><p>Figures of the survey \"Fast Low-discrepancy Sampling of "
                   "Parametric Surfaces and Meshes\", made again from its description, under its numbers. The data behind "
                   "each picture is in the CSV files.</p><nav><ul>%s</ul></nav>%s<hr><p>%s</p></body></html>\n"
                   % (STYLE, "".join(self._contents), "\n".join(self._parts), html.escape(footer)))
        return page
