"""Figures 22 to 26 and table 1: histograms of the distances between samples, and their errors."""
import functools
import itertools
import math
from typing import NamedTuple

import numpy

from .. import laboratory
from . import look
from .errors import ErrorSeries
from .models import subjects, torus, unit_sphere

BINS = 32  # the survey's
CHARTS = {"conformal": ["--method", "conformal"], "isotropic tensor": ["--method", "anisotropic", "--tensor", "isotropic"]}
CHARTS["isotropic tensor by gradient"] = [*CHARTS["isotropic tensor"], "--parameterization", "gradient", "--segments", "16"]
TRUTHS = ALIKE, BY_AREA, CURVED = "all vertices", "vertices by area", "curved surface"
SINGLE, FLAT = ", no duplicates", ", flat"  # after the name of a method
LINES = {"": "-", SINGLE: "--", FLAT: "--", ", curved": "-.", ", curved by area": "-"}
# Both readings of the survey's relative error, and what they are shown in parts of.
MEASURES = {"relative": ("relative error, %", 100), "norm": ("root of the sum of squares, %", 100),
            "largest": ("largest error of a bin", 1)}
POINTS = (100, 500)
# Table 1 of the survey at 100, then 500 points: relative error in % of low-discrepancy and random samples, then the largest.
PUBLISHED = {"bunny": ((1.997, 2.250, 0.0086, 0.0090), (1.068, 1.492, 0.0053, 0.0063)),
             "maxplanck": ((4.481, 5.485, 0.0159, 0.0177), (4.024, 4.390, 0.0133, 0.0142)),
             "fandisk": ((1.463, 2.260, 0.0080, 0.0117), (0.629, 1.121, 0.0033, 0.0036)),
             "hand": ((1.974, 2.543, 0.0073, 0.0087), (1.316, 1.436, 0.0042, 0.0057))}


def published_name(model):
    return next((name for name in PUBLISHED if model.name.lower().startswith(name)), None)


class Method(NamedTuple):
    name: str
    charts: str
    sequence: str
    stream: int  # of randomness: methods share none


LOW, RANDOM, SPACED = (Method("low discrepancy", "conformal", "shifted", 0), Method("random", "conformal", "random", 2),
                       Method("spaced", "conformal", "spaced", 5))
ON_CHARTS = (LOW, *(Method(name, name, "shifted", 2 + k) for k, name in enumerate(CHARTS) if k))
METHODS = (LOW, RANDOM, Method("stratified", "conformal", "stratified", 1), *ON_CHARTS[1:], SPACED)


def counts_to(most):
    return [step * 10 ** decade for decade in range(2, 7) for step in (1, 2, 5) if step * 10 ** decade <= most]


class ChartedModel:
    """A model with its charts. Points are in working units of its prepared mesh."""

    def __init__(self, model, seed, charts=("conformal",)):
        self.seed = seed
        self.staged = {name: laboratory.stage(**model.arrays, run=CHARTS[name], n=100000, seed=seed) for name in charts}
        self.surface = laboratory.working_surface(staged=self.staged["conformal"])

    def samples(self, method, count, run, *options, staged=None):
        return laboratory.samples(staged=staged or self.staged[method.charts], n=count,
                                  run=[*CHARTS[method.charts], "--sequence", method.sequence, *options],
                                  seed=(self.seed + (method.stream << 32) + (run << 40)) % 2 ** 53)

    def points(self, samples, curved=False):
        return laboratory.points_of_samples(
            staged=self.staged["conformal"], triangle=samples.triangle, barycentric=samples.barycentric,
            normals=self.surface.normals if curved else None).points

    def nearest(self, sets):
        """The numbers of the vertices nearest to the samples of each set."""
        queries = numpy.vstack([self.points(samples) for samples in sets])
        nearest = laboratory.nearest_of_points(points=self.surface.vertices, queries=queries).nearest
        return numpy.split(nearest, numpy.cumsum([len(samples.triangle) for samples in sets])[:-1])


class Measured:
    """Errors of sets over their number of points: errors[truth, name of the method][measure] is a series."""

    def __init__(self, truths, largest_distance, vertices):
        self.truths, self.range, self.vertices = truths, largest_distance, vertices
        self.errors, self.shown, self.charts = {}, {}, []
        self.floor = laboratory.histogram_errors(bins=BINS, shares=truths.get(BY_AREA, truths[ALIKE])[None],
                                                 truth=truths[ALIKE])

    def add(self, truth, method, count, shares):
        found = laboratory.histogram_errors(bins=BINS, shares=numpy.vstack(shares), truth=self.truths[truth])
        series = self.errors.setdefault((truth, method), {measure: ErrorSeries(method) for measure in MEASURES})
        for measure, value in ((m, v) for m in MEASURES for v in getattr(found, m)):
            series[measure].add(count, value)

    def spread(self, truth, method, measure, count):
        """Mean, deviation and standard error of the mean over the runs."""
        runs = numpy.array(self.errors[truth, method][measure].runs[count])
        deviation = runs.std(ddof=1) if len(runs) > 1 else 0.0
        return numpy.array([runs.mean(), deviation, deviation / len(runs) ** 0.5])

    def last(self, truth, method):
        """The largest number of points, and its mean relative error in %."""
        count = max(self.errors[truth, method]["relative"].runs)
        return count, 100 * self.spread(truth, method, "relative", count)[0]


@functools.lru_cache(maxsize=None)
def euclidean(figures, model):
    """Figures 22 to 25 and table 1 of one model, measured once."""
    charted = ChartedModel(model, figures.seed, CHARTS)
    vertices = charted.surface.vertices
    alike = laboratory.distance_shares(points=vertices, bins=BINS)
    shares = lambda points, **weights: laboratory.distance_shares(
        points=points, bins=BINS, range=alike.range, **weights).shares
    many = charted.samples(LOW, 20000 if figures.quick else 400000, 1000)
    result = Measured({ALIKE: alike.shares, BY_AREA: shares(vertices, weights=charted.surface.areas),
                       CURVED: shares(charted.points(many, True))}, alike.range * charted.surface.unit, len(vertices))
    for method in METHODS:
        figures.note("%s: %s" % (model.name, method.name))
        for count in counts_to(2000 if figures.quick else 100000):
            runs = 5 if figures.quick else 40 if count <= 1000 else 5 if count <= 20000 else 3
            sets = [charted.samples(method, count, run) for run in range(runs)]
            result.add(CURVED, method.name, count, [shares(charted.points(s, True)) for s in sets])
            if method is LOW:
                result.add(CURVED, method.name + FLAT, count, [shares(charted.points(s)) for s in sets])
            if count > 20000:  # snapped samples have reached their floor long before
                continue
            nearest = charted.nearest(sets)
            snapped = [shares(vertices[of_set]) for of_set in nearest]
            for truth in (ALIKE, BY_AREA):
                result.add(truth, method.name, count, snapped)
            result.shown.setdefault(method.name, snapped[0])
            single = [vertices[unique] for unique in map(numpy.unique, nearest) if len(unique) > 1]
            if method.charts == "conformal" and single:
                result.add(ALIKE, method.name + SINGLE, count, [shares(points) for points in single])
    for name in list(CHARTS)[1:]:
        found = laboratory.working_surface(staged=charted.staged[name])
        result.charts.append([name, found.segments, found.accepted_share, found.chart_ratio, found.overlap, found.flips])
    return result


@functools.lru_cache(maxsize=None)
def geodesic(figures, model):
    """Figure 26 of one model, distances by the heat method."""
    charted = ChartedModel(model, figures.seed)
    vertices = len(charted.surface.vertices)
    # All vertices where time allows it, else one of every so many.
    sources = min(256 if figures.quick else 8192, vertices)
    within = numpy.random.default_rng(figures.seed).random(sources) if sources < vertices else 0.5
    source = numpy.minimum((numpy.arange(sources) + within) * vertices / sources, vertices - 1).astype(numpy.uint32)
    sets = {}
    for method, count in itertools.product((LOW, RANDOM, SPACED), counts_to(500 if figures.quick else 1000)):
        runs = 5 if figures.quick else 10 if count <= 500 else 3
        sets[method.name, count] = charted.nearest([charted.samples(method, count, run) for run in range(runs)])
    figures.note("%s: geodesic distances from %d of %d vertices" % (model.name, sources, vertices))
    every = [one for of in sets.values() for one in of]
    found = laboratory.geodesic_shares(
        staged=charted.staged["conformal"], bins=BINS, sources=source, areas=charted.surface.areas,
        points=numpy.concatenate(every), sizes=numpy.array([len(one) for one in every]))
    result = Measured({ALIKE: found.alike, BY_AREA: found.by_area}, found.range, vertices)
    rows = iter(found.shares)
    for (name, count), of in sets.items():
        shares = list(itertools.islice(rows, len(of)))
        result.shown.setdefault(name, shares[0])
        for truth in result.truths:
            result.add(truth, name, count, shares)
    return result


# ---- plots

def draw_curves(axes, errors, measure, title, floor=None, vertices=None):
    """errors: by the name of a method, and what follows a comma has a line of its own."""
    label, scale = MEASURES[measure]
    names = [method.name for method in METHODS]
    for name, series in errors.items():
        method, comma, rest = name.partition(",")
        number, line = names.index(method), LINES[comma + rest]
        counts, means, spread = series[measure].means()
        axes.errorbar(counts, scale * means, yerr=scale * spread, label=name, color=look.PALETTE[number], markersize=3.5,
                      marker=look.MARKERS[number], linewidth=1.2, linestyle=line,
                      markerfacecolor=None if line == "-" else "white")
    if floor is not None:
        axes.axhline(scale * floor, color=look.NEUTRAL, linewidth=1.4, linestyle=":", label=BY_AREA)
        axes.axvline(vertices, color=look.NEUTRAL, linewidth=1, label="number of vertices")
    axes.set(xscale="log", yscale="log", xlabel="points", ylabel=label, title=title)
    look.plain_ticks(axes)


def draw_model(figures, stem, model, measured, distance):
    """Histogram, relative and largest error in a row, as published; and the errors against all ground truths."""
    edges = numpy.linspace(0, measured.range, BINS + 1)
    of = lambda truth: {name: series for (one, name), series in measured.errors.items() if one == truth}

    def draw_row(axes):
        axes[0].stairs(measured.truths[ALIKE], edges, fill=True, color="#d8d8d8", label="ground truth: " + ALIKE)
        axes[0].stairs(measured.truths[BY_AREA], edges, color=look.NEUTRAL, linestyle=":", linewidth=1.4, label=BY_AREA)
        for number, method in enumerate((LOW, RANDOM)):
            axes[0].stairs(measured.shown[method.name], edges, color=look.PALETTE[number], linewidth=1.3)
        axes[0].set(xlabel=distance + ", units of the model", ylabel="share of the pairs", xlim=(0, measured.range),
                    title="%s: %ss of 100 samples" % (model.name, distance))
        published = {name: series for name, series in of(ALIKE).items() if "," not in name and name != "stratified"}
        draw_curves(axes[1], published, "relative", "relative error", measured.floor.relative[0], measured.vertices)
        draw_curves(axes[2], published, "largest", "largest error", measured.floor.largest[0], measured.vertices)
        look.legend_below(axes, 4)

    def draw_truths(axes):
        for (row, measure), (column, truth) in itertools.product(enumerate(("relative", "largest")),
                                                                 enumerate(measured.truths)):
            draw_curves(axes[row, column], of(truth), measure,
                        "against " + truth.replace("curved", "the curved"))
        axes[0, 0].figure.suptitle(model.name, fontsize=10)
        look.legend_below(axes, 5)

    name = "%s_%s" % (stem, model.name)
    figures.plot(name, "Histograms of vertices and of sets of samples snapped to vertices; errors against all vertices: "
                 "means of 40 runs to 1,000 points, 5 to 20,000, 3 above (geodesic distances: 10 to 500, 3 above; quick: 5)",
                 draw_row, 12.6, 3.6, ncols=3)
    figures.plot(name + "_truths", "The same against every ground truth; those of the curved surface lifted, not snapped",
                 draw_truths, 4.2 * len(measured.truths), 6.4, nrows=2, ncols=len(measured.truths))
    figures.table(name + "_histograms", "", ["from", "to", *measured.truths, *measured.shown], zip(
        edges, edges[1:], *measured.truths.values(), *measured.shown.values()), shown=False)
    figures.table(name + "_errors", "", ["ground truth", "samples", "points", "runs"] + [
        word + measure for measure in MEASURES for word in ("", "deviation of ", "error of ")], [
            [truth, method, count, len(runs), *numpy.ravel([measured.spread(truth, method, m, count) for m in MEASURES])]
            for (truth, method), series in measured.errors.items()
            for count, runs in sorted(series["relative"].runs.items())], shown=False)
    figures.measured("%s: relative error of low-discrepancy and of random samples %s; with many points it goes to that of "
                     "the histogram of the vertices by area, %.2f %%." % (model.name, ", ".join(
                         "%.2f and %.2f %% at %d points" % (*(100 * measured.spread(ALIKE, method.name, "relative", count)[0]
                                                              for method in (LOW, RANDOM)), count) for count in POINTS),
                                                                      100 * measured.floor.relative[0]))


def draw_euclidean(figures, prefix):
    number = 22 + list(PUBLISHED).index(prefix)
    models = [model for model in figures.models if published_name(model) == prefix or
              number == 22 and not published_name(model)]
    if not models:
        figures.not_drawn("no model is given whose name starts with `%s`" % prefix)
    for model in models:
        with figures.attempt(model.name):
            draw_model(figures, "figure%d" % number, model, euclidean(figures, model), "distance")


draw_22, draw_23, draw_24, draw_25 = (functools.partial(draw_euclidean, prefix=prefix) for prefix in PUBLISHED)


def draw_26(figures):
    claims = []
    for model in subjects(figures, "hand"):
        with figures.attempt(model.name):
            draw_model(figures, "figure26", model, geodesic(figures, model), "geodesic distance")
            claims += claims_of(model, geodesic(figures, model))
    figures.table("figure26_claims", "Claims, decided at two standard errors of the difference", CLAIMS, claims)


# ---- table 1

CLAIMS = ["claim", "charts", "model", "points", "ground truth", "error", "holds", "low discrepancy", "other", "gap"]


def gap(a, b):
    """Of spreads: a - b in standard errors of the difference."""
    return (a[0] - b[0]) / (math.hypot(a[2], b[2]) or math.nan)


def claims_of(model, measured):
    """Rows of CLAIMS. The deviation over runs is known to 1 / sqrt(2 (runs - 1)): no more than an order is claimed."""
    rows = []
    for truth, count, method, measure in itertools.product(measured.truths, POINTS, ON_CHARTS, MEASURES):
        if (truth, method.name) not in measured.errors:
            continue
        low, random, conformal = (measured.spread(truth, one.name, measure, count) for one in (method, RANDOM, LOW))
        where, far = [method.charts, model.name, count, truth, measure], gap(random, low)
        rows += [["smaller error", *where, "yes" if far > 2 else "no" if far < -2 else "undecided", low[0], random[0], far],
                 ["smaller deviation over runs", *where, "yes" if low[1] < random[1] else "no", low[1], random[1], None]]
        if method is not LOW:
            far = gap(low, conformal)
            rows.append(["equals conformal", *where, "yes" if abs(far) <= 2 else "no", low[0], conformal[0], far])
    return rows


def draw_table_1(figures):
    rows, claims, charts = [], [], []
    for model in figures.models:
        with figures.attempt(model.name):
            measured = euclidean(figures, model)
            claims += claims_of(model, measured)
            charts += [[model.name, *row] for row in measured.charts]
            published = PUBLISHED.get(published_name(model), ((None,) * 4,) * 2)
            for truth, (count, theirs), method in itertools.product(TRUTHS, zip(POINTS, published), ON_CHARTS):
                rows.append([truth, model.name, count, method.charts, *theirs])
                for measure, (_, scale) in MEASURES.items():
                    low, random = (scale * measured.spread(truth, one.name, measure, count) for one in (method, RANDOM))
                    rows[-1] += [low[0], low[2], random[0], random[2], gap(random, low)]
    if not rows:
        return
    missing = [name for name in PUBLISHED if name not in map(published_name, figures.models)]
    if missing:
        figures.text("Skipped", "models of the survey that --models does not name: " + ", ".join(missing))
    figures.table("table1_histograms", "Low-discrepancy and random samples: relative error as the sum of absolute errors "
                  "and as the root of the sum of squares, and the largest error; gap: in standard errors of the difference",
                  ["ground truth", "model", "points", "charts", "survey %", "survey random %", "survey largest",
                   "survey random largest"] + [
                       word + name for name in ("relative %", "root of squares %", "largest")
                       for word in ("", "error of ", "random ", "error of random ", "gap of ")], rows)
    cells = []
    for truth, on, reading in itertools.product(TRUTHS, CHARTS, ("relative", "norm")):
        gaps = numpy.array([row[9] for row in claims if [row[0], row[1], row[4]] == ["smaller error", on, truth]
                            and row[5] in (reading, "largest")])
        cells.append([truth, on, reading, len(gaps), (gaps > 0).sum(), (gaps > 2).sum(), (gaps < -2).sum(), gaps.min(),
                      gaps.max()])
    figures.table("table1_cells", "Cells in which the low-discrepancy samples have the smaller error; relative error as the "
                  "sum of absolute errors (relative) or as the root of the sum of squares (norm)",
                  ["ground truth", "charts", "relative error", "cells", "smaller", "by 2 standard errors",
                   "larger by 2 standard errors", "smallest gap", "largest gap"], cells)
    figures.table("table1_claims", "Claims, decided at two standard errors of the difference", CLAIMS, claims, shown=False)
    figures.table("table1_charts", "Charts of the isotropic tensor, by which the survey sampled",
                  ["model", "charts", "segments", "accepted share", "chart ratio", "overlap", "flips"], charts)
    figures.measured("Low-discrepancy samples have the smaller error %s." % "; ".join(
        "against %s in %d of %d cells, %d by more than two standard errors (gaps %.1f to %.1f), with the root of the sum "
        "of squares in %d, %d by two" % (one[0], one[4], one[3], one[5], *one[7:], *other[4:6])
        for one, other in zip(cells[::2], cells[1::2]) if one[1] == "conformal"))
    figures.text("Ground truths", "All vertices, as published: samples snapped to the nearest vertex, with multiplicity, "
                 "against all pairs of vertices. Vertices by area: against pairs weighted by their mixed areas. Curved "
                 "surface: samples lifted to the surface that the normals tell of, against many others. %d bins on the "
                 "largest distance of the vertices." % BINS)
    figures.text("Reading", "The largest error is at most half of the sum of absolute errors, as errors sum to 0. Three "
                 "published rows have more; the root of the sum of squares has their size.")


# ---- floors

def draw_histogram_floors(figures):
    rows, said = [], []
    for model, tube in ((unit_sphere(12), None), (torus(32, 16, 0.5), 0.5)):
        figures.note(model.name)
        known = laboratory.known_distance_shares(shape=model.name, bins=BINS, tube=tube)
        charted = ChartedModel(model, figures.seed)
        by_area = laboratory.weighted_by_lifted_area(staged=charted.staged["conformal"], normals=charted.surface.normals)
        shares = lambda points: laboratory.distance_shares(points=points, bins=BINS,
                                                           range=known.range / charted.surface.unit).shares
        measured, kinds = Measured({ALIKE: known.shares}, known.range, None), ("flat", "curved", "curved by area")
        for method, count in itertools.product((LOW, RANDOM), counts_to(10000 if figures.quick else 100000)):
            for run in range(3 if figures.quick or count > 20000 else 5):
                samples = charted.samples(method, count, run)
                even = charted.samples(method, count, run, "--density", "face-attribute:lifted", staged=by_area)
                for kind, points in zip(kinds, (charted.points(samples), charted.points(samples, True),
                                                charted.points(even, True))):
                    measured.add(ALIKE, "%s, %s" % (method.name, kind), count, [shares(points)])
        for method in (LOW, RANDOM):
            spread = [100 * measured.spread(ALIKE, "%s, %s" % (method.name, kind), "relative", count) for kind in kinds]
            rows.append([model.name, len(model.faces), method.name, count, *numpy.ravel([s[::2] for s in spread]),
                         spread[0][0] / spread[2][0]])
        said.append("%s %.3f %% flat, %.3f %% curved, %.3f %% drawn by lifted area" % (model.name, *rows[-2][4:10:2]))

        def draw(axes):
            for one, measure in zip(axes, ("relative", "largest")):
                draw_curves(one, {name: series for (_, name), series in measured.errors.items()}, measure,
                            "%s of %d triangles" % (model.name, len(model.faces)))
            look.legend_below(axes, 3)

        figures.plot("histogram_floors_" + model.name, "Errors against the histogram of the smooth shape; means of 5 runs, "
                     "3 above 20,000 points", draw, 9, 3.8, ncols=2)
        figures.table("histogram_floors_" + model.name, "", ["samples", "points", *MEASURES], [
            [name, n, *(measured.spread(ALIKE, name, measure, n)[0] for measure in MEASURES)]
            for (_, name), series in measured.errors.items() for n in sorted(series["relative"].runs)], shown=False)
    figures.table("histogram_floors_shapes", "Relative errors at the largest number of points against the smooth shape",
                  ["shape", "triangles", "samples", "points", "flat %", "error of flat", "curved %", "error of curved",
                   "by lifted area %", "error of by area", "flat / by area"], rows)
    figures.measured("Low discrepancy at %d points: %s. Samples of the chords keep the error of the tessellation; lifted by "
                     "the normals they keep that of their density, uniform on the flat triangles." % (
                         rows[0][3], "; ".join(said)))
    columns = {"all vertices": (ALIKE, ""), "no duplicates": (ALIKE, SINGLE), "vertices by area": (BY_AREA, ""),
               "flat from curved": (CURVED, FLAT), "curved": (CURVED, "")}
    models = []
    for model in figures.models:
        with figures.attempt(model.name):
            measured = euclidean(figures, model)
            models.append([model.name, measured.vertices, 100 * measured.floor.relative[0]])
            for truth, kind in columns.values():
                models[-1] += measured.last(truth, LOW.name + kind)
    figures.table("histogram_floors_models", "Relative error of low-discrepancy samples at the largest number of points",
                  ["model", "vertices", "vertices by area from all %"] + [
                      word + name for name in columns for word in ("points of ", "% of ")], models)
