"""The error of every sequence, and of point sets of other programs, against the least that is known to be possible."""
import itertools
import json

import numpy

from .. import laboratory
from . import look
from .spaced import ALONG, ELIMINATED, ComparedModel

# Names of curves, with those of ComparedModel, whose samples are of the method `auto`. CHARTED has the charts of Quinn et al.
# 2013.
SEQUENCES = {"random": "random", "stratified": "stratified", "shifted (default)": "shifted",
             "spaced progressive": "spaced progressive", "spaced": "spaced", "spaced best": "spaced best",
             ELIMINATED: ELIMINATED}
CHARTED = "shifted (conformal)"


class ChartedModel:
    """A model staged once by the method conformal."""

    def __init__(self, model, most):
        self.staged = laboratory.stage(run=["--method", "conformal"], n=most, **model.arrays)

    def set(self, count, seed):
        return laboratory.samples(staged=self.staged, run=["--method", "conformal", *ALONG, "shifted"], n=count,
                                  seed=seed).points


def errors_of_sequences(figures, model, counts, boxes):
    """Rows of sequence, points, sets, root mean square error, limit."""
    compared, charted, rows = ComparedModel(model, counts[-1]), ChartedModel(model, counts[-1]), []
    for name, count in itertools.product([*SEQUENCES, CHARTED], counts):
        sets = 3 if figures.quick else min(max(131072 // count, 4), 32)
        seeds = range(figures.seed, figures.seed + sets)
        points = [charted.set(count, s) if name == CHARTED else compared.set(SEQUENCES[name], count, s)[0] for s in seeds]
        found = compared.measures(points, boxes, figures.seed)
        rows.append([name, count, sets, (found.ratio ** 2).mean() ** 0.5, found.limit[0]])
    return rows


def errors_of_files(figures, model, boxes):
    """The same of the point files that the user gives; the files of one name and number of points are its sets."""
    if not figures.points:
        return []
    found = json.loads(figures.run_program("measure", "boxes", *(file for _, file in figures.points), "--surface", model.path,
                                           "--shapes", boxes, "--seed", figures.seed, "--json"))["results"]
    groups = {}
    for (name, _), row in zip(figures.points, found):
        groups.setdefault((name, row["points"]), []).append(row)
    return [[name, count, len(sets), numpy.mean([row["error / random"] ** 2 for row in sets]) ** 0.5, sets[0]["limit"]]
            for (name, count), sets in sorted(groups.items())]


def draw_limit(figures):
    counts = [4 ** power for power in range(4, 7 if figures.quick else 10)]
    boxes = 200 if figures.quick else 1000
    for model in figures.models:
        with figures.attempt(model.name):
            figures.note(model.name)
            theirs = errors_of_files(figures, model, boxes)  # first: of what is not there nothing else is drawn
            draw_against_limit(figures, model, errors_of_sequences(figures, model, counts, boxes) + theirs)


def spread(heights, gap):
    """Heights in [0, 1] in their order, at least `gap` apart, as near to the given ones as labels need."""
    placed = []
    for height in heights:  # from the lowest
        placed.append(max(height, placed[-1] + gap if placed else 0))
    for k in range(len(placed) - 1, -1, -1):
        placed[k] = min(placed[k], placed[k + 1] - gap if k + 1 < len(placed) else 1)
    return placed


def draw_against_limit(figures, model, rows):
    names = list(dict.fromkeys(row[0] for row in rows))
    n, limit = (numpy.array(column) for column in zip(*sorted({(row[1], row[4]) for row in rows})))
    last = {row[0]: row for row in sorted(rows, key=lambda row: row[1])}
    over = {name: row[3] / row[4] for name, row in last.items()}
    colors = [look.NEUTRAL] + [color for color in look.PALETTE if color != "#000000"]  # black is the limit
    low, high = 0.93, 2.5

    def draw(axes):
        for one, relative in zip(axes, (False, True)):
            for number, name in enumerate(names):
                x, y = zip(*((row[1], row[3] / row[4] if relative else row[3]) for row in rows if row[0] == name))
                one.plot(x, y, color=colors[number % len(colors)], marker=look.MARKERS[number % 10], markersize=4,
                         linewidth=1.3)
            best = numpy.ones(len(n)) if relative else limit
            one.plot(n, best, color="black", linewidth=2.4)
            one.fill_between(n, best, low / 2 if relative else limit[-1] / 2, color="#e2e2e2", linewidth=0)
            one.set(xscale="log", yscale="log", xlabel="points", xlim=(n[0] / 1.12, n[-1] * 1.12))
        axes[0].set(ylim=(limit[-1] / 1.3, 1.5), ylabel="error over rotated boxes / that of random points", title=model.name)
        axes[1].set(ylim=(low, high), ylabel="error / limit", title="the same over the limit")
        axes[0].text(n[0], limit[-1] / 1.2, "  No set is known below the limit,\n  and the error of none falls faster.", va="bottom")
        at = lambda value: min(numpy.log(value / low) / numpy.log(high / low), 1)
        lines = sorted([(value, name) for name, value in over.items()] + [(1, "limit")])
        for (value, name), height in zip(lines, spread([at(value) for value, _ in lines], 0.062)):
            color = "black" if name == "limit" else colors[names.index(name) % len(colors)]
            axes[1].text(1.03, height, name if name == "limit" else "%.2f  %s" % (value, name), color=color, va="center",
                         transform=axes[1].transAxes)
        look.plain_ticks(axes[0])
        axes[1].set_yticks([1, 1.2, 1.4, 1.6, 1.8, 2, 2.5], labels=["1", "1.2", "1.4", "1.6", "1.8", "2", "2.5"])
        for one in axes:
            one.minorticks_off()
            ticks = [count for count in n if numpy.log2(count) % 2 == 0] or list(n)
            one.set_xticks(ticks, labels=["{:,}".format(count) for count in ticks])

    stem = "limit_" + model.name
    figures.plot(stem, "Root mean square over rotated boxes and sets; at the right the error of the largest set over the limit, "
                 "which a triangular lattice would have", draw, 11, 4.4, ncols=2)
    figures.table(stem, "", ["samples", "points", "sets", "error", "limit", "over_limit"],
                  [[*row, row[3] / row[4]] for row in rows], shown=False)
    figures.measured("%s, error over the limit at the most points: %s." % (model.name, ", ".join(
        "%s %.2f (%d points)" % (name, over[name], last[name][1]) for name in names)))
