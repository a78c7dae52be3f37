"""Samples that keep their distance, beside others: error, spacing, differences, spectra, bias and time."""
import itertools
import time

import numpy

from .. import laboratory
from . import look
from .models import unit_cube, unit_sphere, unit_square
from .surfaces import discs, model_picture

ELIMINATED, CANDIDATES = "sample elimination", 5  # Yuksel's choice
ALONG = ["--order", "curve", "--sequence"]
METHODS = {"random": [*ALONG, "random"], "stratified": [*ALONG, "stratified"], "shifted": [*ALONG, "shifted"],
           ELIMINATED: [*ALONG, "random"], "spaced fast": [*ALONG, "spaced", "--spacing", "fast"],
           "spaced": [*ALONG, "spaced"], "spaced best": [*ALONG, "spaced", "--spacing", "best"],
           "spaced progressive": ["--sequence", "spaced"]}
MAPPED = [name for name in METHODS if name != "spaced fast"]
LOOKS = {name: dict(label=name, color=look.PALETTE[k], linewidth=2.2 if name == "spaced" else 1.1, markersize=3.5)
         for k, name in enumerate(METHODS)}


class ComparedModel:
    """A model staged once for sets of at most so many points, by the method auto."""

    def __init__(self, model, most):
        self.staged = laboratory.stage(**model.arrays, n=CANDIDATES * most)

    def set(self, name, count, seed):
        """Points and normals, (count, 3) each."""
        found = laboratory.samples(staged=self.staged, run=METHODS[name], seed=seed,
                                   n=CANDIDATES * count if name == ELIMINATED else count)
        if name != ELIMINATED:
            return found.points, found.normals
        kept = laboratory.kept_by_elimination(staged=self.staged, points=found.points, n=count).kept
        return found.points[kept], found.normals[kept]

    def measures(self, points, boxes, seed):
        """Of a list of sets of points."""
        return laboratory.measures_of_sets(staged=self.staged, points=numpy.vstack(points), boxes=boxes, seed=seed,
                                           sizes=numpy.array([len(p) for p in points]))


def draw_measures(figures, model, compared, most):
    rows, times = [], []
    counts = [4 ** power for power in range(3, 8) if 4 ** power <= most]
    for name, count in itertools.product(METHODS, counts):
        sets = 3 if figures.quick else min(max(32768 // count, 3), 16)
        points, stops = [], [time.perf_counter()]
        for s in range(sets):
            points.append(compared.set(name, count, figures.seed + s)[0])
            stops.append(time.perf_counter())
        times.append([name, count, 1000 * min(numpy.diff(stops))])
        found = compared.measures(points, 200 if figures.quick else 1000, figures.seed)
        rows.append([name, count, sets, (found.ratio ** 2).mean() ** 0.5, found.rho.mean(), found.rho.min(),
                     found.mean_distance.mean()])

    def draw(plots):
        def draw_all(axes):
            for one, (table, column, label, scale, title) in zip(axes.ravel(), plots):
                for number, name in enumerate(METHODS):
                    x, y = zip(*((row[1], row[column]) for row in table if row[0] == name))
                    one.plot(x, y, marker=look.MARKERS[number], **LOOKS[name])
                one.set(xscale="log", yscale=scale, xlabel="points", ylabel=label, title=title)
                look.plain_ticks(one)
            look.legend_below(axes, 4)
        return draw_all

    stem = "spaced_" + model.name
    figures.plot(stem, "Error: root mean square over rotated boxes and sets; distances: means over sets", draw([
        (rows, 3, "error / that of random points", "log", "rotated boxes"),
        (rows, 4, "smallest distance / hexagonal (rho)", "linear", model.name + ": smallest distance"),
        (rows, 6, "mean distance / hexagonal", "linear", "distance to the nearest sample")]), 12.6, 3.8, ncols=3)
    figures.table(stem + "_sets", "", ["samples", "points", "sets", "error", "rho", "least rho",
                                       "mean distance / hexagonal"], rows, shown=False)
    figures.plot(stem + "_time", "The fastest set, with the copy of the staged model; of sample elimination with its five "
                 "times as many samples", draw([(times, 2, "time of a set, ms", "log", model.name + ": time")]), 5.4, 4,
                 squeeze=False)
    figures.table(stem + "_time", "", ["samples", "points", "ms"], times, shown=False)
    last = {row[0]: row for row in rows if row[1] == counts[-1]}
    figures.measured("%s, %d points: %s." % (model.name, counts[-1], ", ".join(
        "%s error %.3f and rho %.2f" % (name, last[name][3], last[name][4])
        for name in ("spaced", "stratified", ELIMINATED))))


def draw_rings(figures, stem, caption, rings, unit, across, plots):
    """rings: radial means by method; plots: what of them, its name, limits, and what random sets have."""
    def draw(axes):
        for one, (column, label, limits, white) in zip(axes.ravel(), plots):
            for name, ring in rings.items():
                one.plot(unit * ring.radius, getattr(ring, column), **LOOKS[name])
            one.axhline(white, color=look.NEUTRAL, linewidth=1, linestyle=":", label="random points")
            one.set(xlabel=across, ylabel=label, ylim=limits)
        look.legend_below(axes, 5 if len(plots) > 1 else 3)

    figures.plot(stem, caption, draw, 5.4 * len(plots), 3.9, ncols=len(plots), squeeze=False)
    figures.table(stem, "", ["samples", across, "mean", "anisotropy dB"], [
        row for name, ring in rings.items()
        for row in zip(itertools.repeat(name), unit * ring.radius, ring.mean, ring.anisotropy)], shown=False)


def draw_differences(figures, model, compared):
    sets, count = (2, 1000) if figures.quick else (10, 3000)
    spacing = numpy.full(count, (compared.staged.area / count) ** 0.5)

    def mean_map(name, number, seed):
        drawn = (compared.set(name, count, seed + s) for s in range(number))
        return sum(laboratory.differences(points=p, normals=n, spacing=spacing, range=4.0).pairs for p, n in drawn) / number

    reference = mean_map("random", 4 * sets, figures.seed + 1000)
    ratios = {name: mean_map(name, sets, figures.seed) / reference for name in MAPPED[1:]}
    stem = "spaced_%s_differences" % model.name
    figures.panels(stem, "Differences between samples, to 4 mean spacings: black none, white twice those of random samples",
                   [(look.gray_map(ratio, 2, 2), name, "") for name, ratio in ratios.items()], 3)
    draw_rings(figures, stem + "_radial",
               "%s: %d points, %d sets against %d random ones" % (model.name, count, sets, 4 * sets),
               {name: laboratory.radial(map=ratio.ravel(), width=2) for name, ratio in ratios.items()}, 8 / len(reference),
               "geodesic distance / sqrt(area / n)", [("mean", "pairs / those of random points", (0, None), 1)])


def draw_spectra(figures):
    count, sets = 1024, 4 if figures.quick else 20
    compared, maps = ComparedModel(unit_square(16), count), {}
    for name in METHODS:
        drawn = (compared.set(name, count, figures.seed + s)[0][:, :2] for s in range(sets))
        maps[name] = sum(laboratory.power_spectrum(points=points, radius=80).power for points in drawn) / sets
    draw_rings(figures, "spaced_spectrum", "Plane: power spectra of %d points, means of %d sets" % (count, sets),
               {name: laboratory.radial(map=power.ravel(), first=0.5) for name, power in maps.items()}, count ** -0.5,
               "frequency / sqrt(n)", [("mean", "power", (0, None), 1),
                                       ("anisotropy", "anisotropy, dB", (-20, 20), -10 * numpy.log10(sets))])
    for power in maps.values():
        power[80, 80] = 0
    figures.panels("spaced_spectrum_maps", "Periodograms at whole frequencies: black 0, white twice that of random points",
                   [(look.gray_map(maps[name], 2, 2), name, "") for name in MAPPED], 4)


def border_density(points):
    """Of the unit square: the share of points at most .1 / sqrt(n) from its border over the share of that area."""
    strip = 0.1 / len(points) ** 0.5
    near = 0.5 - abs(points[:, :2] - 0.5).max(axis=1) < strip
    return near.mean() / (1 - (1 - 2 * strip) ** 2)


def draw_bias(figures):
    count, sets = 256, 20 if figures.quick else 1000
    rows = {name: [name] for name in METHODS}
    border = {}
    for model in (unit_square(12), unit_sphere(24), unit_cube(4)):
        figures.note("bias: " + model.name)
        compared = ComparedModel(model, count)
        for name in METHODS:
            points = [compared.set(name, count, figures.seed + s)[0] for s in range(sets)]
            rows[name].append(compared.measures(points, 300, figures.seed).bias)
            border.setdefault(name, numpy.mean([border_density(p) for p in points]))
    figures.table("spaced_bias", "Mean error of a box over %d sets of %d points, root mean square over 300 boxes, in parts "
                  "of the error of one set (random, stratified and shifted samples have none: theirs is noise); "
                  "samples at most .1 sqrt(area / n) from the border of the square, over their share of it" % (sets, count),
                  ["samples", "square", "sphere", "cube", "density at the border of the square"],
                  [[*row, border[name]] for name, row in rows.items()])


def draw_spaced(figures):
    sphere = unit_sphere(48)
    sphere.name = "unit-sphere"
    for model in (unit_square(32), sphere, *figures.models):
        figures.note(model.name)
        with figures.attempt(model.name):
            most = 1024 if figures.quick else 16384
            compared = ComparedModel(model, most)
            draw_measures(figures, model, compared, most)
            draw_differences(figures, model, compared)
    draw_spectra(figures)
    draw_bias(figures)


def draw_spaced_sets(figures):
    count, sets = 1500, 4 if figures.quick else 16
    for model in figures.models:
        with figures.attempt(model.name):
            compared = ComparedModel(model, count)
            images, rows = [], []
            for name, title, how in (("random", "random", "independent points"), (ELIMINATED, "Poisson disk", ELIMINATED),
                                     ("spaced", "spaced", "--sequence spaced")):
                drawn = [compared.set(name, count, figures.seed + s) for s in range(sets)]
                found = compared.measures([points for points, _ in drawn], 200 if figures.quick else 1000, figures.seed)
                rows.append([name, count, sets, found.rho.mean(), found.rho.min(), (found.ratio ** 2).mean() ** 0.5])
                marks = discs(*drawn[0], 0.22 * (compared.staged.area / count) ** 0.5)
                images.append((model_picture(figures, model, **marks), title,
                               "%s    rho %.2f    error %.2f" % (how, rows[-1][3], rows[-1][5])))
            # All cut to what is painted in any of them.
            painted = numpy.any([(image < 255).any(axis=2) for image, _, _ in images], axis=0)
            rows_, columns_ = (numpy.flatnonzero(painted.any(axis=axis)) for axis in (1, 0))
            images = [(numpy.ascontiguousarray(image[rows_[0]:rows_[-1] + 1, columns_[0]:columns_[-1] + 1]), title, note)
                      for image, title, note in images]
            stem = "spaced_sets_" + model.name
            figures.panels(stem, "%d points on %s" % (count, model.name), images)
            figures.table(stem, "Means of %d sets: the first of each is drawn. rho: smallest distance over that of the "
                          "hexagonal lattice; error: root mean square over rotated boxes, random samples having 1" % sets,
                          ["samples", "points", "sets", "rho", "least rho", "error"], rows)
