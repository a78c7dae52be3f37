"""Draws one plot of a JSON object from standard input to standard output: the plots of `meander retrieve` and `measure`.

{"kind": "curves", "title", "x", "y", "limits": [x0, x1, y0, y1], "series": [{"name", "x", "y", "thin"}], "format"}
{"kind": "matrix", "title", "x", "y", "rows", "columns", "values": shares row by row, "format"}
{"kind": "map", "title", "x", "y", "side", "extent": half of the width, "upper": white, "values" row by row, "format"}

format: svg or png. The only argument is the palette, "#0072b2,#d55e00,...". Ends with 3 where matplotlib is missing. A program
of its own, which imports nothing of the package: it also runs where the library of the package cannot be loaded.
"""
import io
import json
import logging
import sys
import warnings

try:
    import look
    import matplotlib  # noqa: F401
except ImportError:
    sys.exit(3)


def plain(text):
    """Names of users: no mathematics, and no names that legends leave out."""
    return ("\u200b" if text.startswith("_") else "") + text.replace("$", r"\$")


def curves(plot):
    names = [plain(series["name"]) for series in plot["series"]]
    columns = 1 + (len(names) - 1) // 28
    figure, axes = look.subplots(5.2 + 1.8 * columns, 4.6)
    for number, series in enumerate(plot["series"]):
        thin = series.get("thin", False)
        axes.plot(series["x"], series["y"], label=names[number], color=look.color(number), linewidth=0.9 if thin else 1.6,
                  marker="" if thin else look.MARKERS[number % 10], markersize=3.5)
    left, right, bottom, top = plot["limits"]
    axes.set(title=plain(plot["title"]), xlabel=plot["x"], ylabel=plot["y"], xlim=(left, right), ylim=(bottom, top))
    axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5), ncols=columns)
    return figure


def matrix(plot):
    rows, columns = [[plain(name) for name in plot[side]] for side in ("rows", "columns")]
    shares = [plot["values"][i:i + len(columns)] for i in range(0, len(plot["values"]), len(columns))]
    cell = max(0.07, min(0.34, 40 / max(len(rows), len(columns), 1)))
    figure, axes = look.subplots(1.8 + cell * len(columns), 1.6 + cell * len(rows))
    axes.imshow(shares, cmap="Blues", vmin=0, vmax=1, aspect="equal")
    axes.grid(False)
    axes.set(title=plain(plot["title"]), xlabel=plot["x"], ylabel=plot["y"])
    axes.tick_params(length=0)
    named = cell > 0.1
    for side, names in ((axes.set_xticks, columns), (axes.set_yticks, rows)):
        side(range(len(names)) if named else [], labels=names if named else [], fontsize=7)
    axes.tick_params(axis="x", rotation=90)
    for i, row in enumerate(shares if cell > 0.25 else []):
        for j, share in enumerate(row):
            if share >= 0.005:
                axes.text(j, i, "%.0f" % (100 * share), ha="center", va="center", fontsize=7,
                          color="white" if share > 0.55 else "black")
    return figure


def gray(plot):
    side, extent = plot["side"], plot["extent"]
    figure, axes = look.subplots(4.8, 4.2)
    rows = [plot["values"][i:i + side] for i in range(0, side * side, side)]
    image = axes.imshow([[0 if value is None else value for value in row] for row in rows], cmap="gray", vmin=0,
                        vmax=plot["upper"], origin="lower", extent=[-extent, extent, -extent, extent])
    axes.grid(False)
    axes.set(title=plain(plot["title"]), xlabel=plot["x"], ylabel=plot["y"])
    figure.colorbar(image, ax=axes, shrink=0.85, extend="max")
    return figure


def main():
    look.use_colors(sys.argv[1].split(","))
    plot = json.load(sys.stdin)
    figure = {"curves": curves, "matrix": matrix, "map": gray}[plot["kind"]](plot)
    file = io.BytesIO()
    look.save(figure, file, plot["format"])
    sys.stdout.buffer.write(file.getvalue())


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # of glyphs that the font lacks
    logging.disable(logging.WARNING)
    main()
