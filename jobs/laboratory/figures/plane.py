"""Figures 1 to 5 but for meshes: shapes, point sets and curves of the plane and the sphere, and their discrepancy."""
import numpy

from .. import laboratory
from . import look, models
from .errors import ErrorSeries, draw_errors, survey_counts

SHAPES = ["boxes", "triangles", "quarter circles"]
CURVES = ["hilbert", "peano", "peano-meander"]
DETERMINISTIC = {"halton", "hammersley", "sobol", "fibonacci", "spiral"}


def square_axes(axes, title, below=""):
    """The unit square without ticks."""
    axes.set(xlim=(0, 1), ylim=(0, 1), xticks=[], yticks=[], aspect="equal")
    axes.set_title(title)
    axes.set_xlabel(below, color=look.NEUTRAL)
    axes.spines[["top", "right"]].set_visible(True)
    axes.set_facecolor("#fff")


def dots(axes, points, size=1.2, color="#000"):
    axes.plot(points[:, 0], points[:, 1], "o", color=color, markersize=size, markeredgewidth=0, clip_on=False, zorder=3)


def line_along(axes, points, along, width=0.9):
    """A polyline, dark where it begins and light where it ends."""
    from matplotlib.collections import LineCollection
    axes.add_collection(LineCollection(numpy.stack([points[:-1], points[1:]], axis=1), linewidths=width, capstyle="round",
                                       colors=look.map_color(0.9 * along[:-1]) / 255.0))


def ratio_of(logarithms):
    """(geometric mean, standard error) of ratios, given their logarithms."""
    values = numpy.asarray(logarithms, float)
    mean = numpy.exp(values.mean())
    return mean, mean * values.std(ddof=1) / len(values) ** 0.5 if len(values) > 1 else 0.0


def error_series(figures, name, counts, runs, make, measure):
    """An ErrorSeries for each of the values of measure(points), points = make(n, seed)."""
    figures.note("%s to %d points" % (name, counts[-1]))
    found = {n: [measure(make(n, figures.seed + run)) for run in range(runs)] for n in counts}
    series = [ErrorSeries(name) for _ in found[counts[0]][0]]
    for k, s in enumerate(series):
        s.runs = {n: [values[k] for values in runs] for n, runs in found.items()}
    return series


def in_square(method, **options):
    return lambda n, seed: laboratory.points_in_square(method=method, n=n, seed=seed, **options).points


def square_errors(figures, shapes):
    """Of points: the largest errors over boxes, triangles and quarter circles."""
    def measure(points):
        found = laboratory.square_discrepancy(points=points, shapes=shapes, seed=figures.seed)
        return found.boxes, found.triangles, found.circles
    return measure


def compared(series, other, least=64):
    """The geometric mean of the errors of a series over those of another, over the counts of both."""
    means, others = ({n: m for n, m, _ in zip(*s.means())} for s in (series, other))
    return ratio_of([numpy.log(means[n] / others[n]) for n in means if n in others and n >= least])[0]


# ---- shapes, sets and curves

def draw_1(figures):
    points = in_square("hilbert-stratified")(256, figures.seed)
    x, y = points.T
    corners = numpy.array([[0.86, 0.3], [0.38, 0.92]])
    weights = numpy.linalg.solve(corners.T, points.T)
    arc = numpy.linspace(0, numpy.pi / 2, 181)
    shapes = [("rectangle", numpy.array([[0, 0], [0.72, 0], [0.72, 0.58], [0, 0.58]]), 0.72 * 0.58, (x < 0.72) & (y < 0.58)),
              ("triangle", numpy.vstack([[[0, 0]], corners]), numpy.linalg.det(corners) / 2,
               (weights > 0).all(axis=0) & (weights.sum(axis=0) < 1)),
              ("quarter circle", numpy.vstack([[[0, 0]], 0.8 * numpy.stack([numpy.cos(arc), numpy.sin(arc)], axis=1)]),
               numpy.pi * 0.16, numpy.hypot(x, y) < 0.8)]
    figures.table("figure01_shapes", "256 points, stratified along a Hilbert curve, in the shapes drawn",
                  ["shape", "area", "share of the points", "error"],
                  [(name, area, inside.mean(), inside.mean() - area) for name, _, area, inside in shapes])

    def draw(axes):
        for ax, (name, outline, area, inside) in zip(axes, shapes):
            square_axes(ax, name, "area %.4f\npoints inside %d / 256 = %.4f" % (area, inside.sum(), inside.mean()))
            ax.fill(*outline.T, facecolor="#cfe3f1", edgecolor=look.PALETTE[0], linewidth=1.2)
            dots(ax, points[inside], 2.2)
            dots(ax, points[~inside], 2.2, "#9a9a9a")
            ax.plot(0, 0, "s", color=look.PALETTE[1], markersize=6, clip_on=False, zorder=4)

    figures.plot("figure01_shapes", "The error of a shape is the share of the points inside minus its area; the corner at "
                 "the origin is marked", draw, 7.2, 2.7, ncols=3)


def draw_point_sets(figures):
    methods = "random jittered halton hammersley sobol poisson-disk hilbert-stratified hilbert-shifted".split()

    def draw(axes):
        for ax, method in zip(axes.flat, methods):
            square_axes(ax, method.capitalize())
            dots(ax, in_square(method)(1024, figures.seed))

    figures.plot("point_sets", "1,024 points each", draw, 9.6, 5.2, nrows=2, ncols=4)


def draw_2(figures):
    leaves, n, name = 256, 1024, "stretched-plane"
    curves = [(title, laboratory.surface_curve(surface=name, leaves=leaves, steps=8, seed=figures.seed, **options))
              for title, options in (("uniform", {"uniform": True}), ("adaptive", {}),
                                     ("adaptive, reparameterized", {"reparameterize": True}))]
    sets = [in_square("hilbert-shifted")(n, figures.seed) ** [8, 1]] + [laboratory.surface_samples(
        surface=name, n=n, seed=figures.seed, **options).points for options in ({}, {"reparameterize": True})]
    rows = [(title, len(c.mass), int(c.depth.min()), int(c.depth.max()), c.mass.min() * len(c.mass),
             c.mass.max() * len(c.mass)) for title, c in curves]
    figures.table("figure02_stretched_plane", "The leaves of the curves, their areas on the surface over the mean", [
        "curve", "leaves", "least depth", "greatest depth", "smallest area", "largest area"], rows)

    def draw(axes):
        for column, ((title, c), points) in enumerate(zip(curves, sets)):
            square_axes(axes[0, column], title)
            line_along(axes[0, column], c.uv, c.along)
            square_axes(axes[1, column], "")
            line_along(axes[1, column], c.positions[:, :2], c.along)
            square_axes(axes[2, column], "")
            dots(axes[2, column], points)
        for ax, label in zip(axes[:, 0], ("parameters u, v", "surface x = u$^8$, y = v", "%d samples of it" % n)):
            ax.set_ylabel(label)

    figures.plot("figure02_stretched_plane", "Curves through the centers of about %d leaves, dark at their beginning; "
                 "samples of the uniform curve are even in the parameters" % leaves, draw, 7.2, 7.4, nrows=3, ncols=3)
    figures.measured("the %d leaves of the uniform curve have from %.1g to %.3g times the mean area on the surface, those "
                     "of the adaptive one %.2g to %.2g at depths %d to %d, after reparameterization %.2g to %.2g at depths "
                     "%d to %d." % (rows[0][1], *rows[0][4:], *rows[1][4:], *rows[1][2:4], *rows[2][4:], *rows[2][2:4]))


def curves_on_plane(figures):
    """Rows of (where, curve, comparisons, ratio, error) against Hilbert's: the same numbers along another curve."""
    shapes, runs = (256, 4) if figures.quick else (2048, 16)
    counts = survey_counts(1024 if figures.quick else 8192, 256)
    found = {curve: error_series(figures, curve, counts, runs, in_square(curve + "-stratified"),
                                 square_errors(figures, shapes)) for curve in CURVES}
    logs = {curve: [numpy.log([s.runs[n] for n in counts]).ravel() for s in found[curve]] for curve in CURVES}
    for number, shape in enumerate(SHAPES):
        for curve in CURVES[1:]:
            difference = logs[curve][number] - logs["hilbert"][number]
            yield ("plane, " + shape, curve, len(difference), *ratio_of(difference))


def curves_on_meshes(figures):
    """The same over meshes: a row per model, and one for all, whose error is that between models."""
    n, boxes, runs = (500, 300, 4) if figures.quick else (2000, 1000, 24)
    made = [models.torus(96, 48), models.unit_sphere(40), models.unit_cube(16), models.unit_sphere(40, (1, 0.6, 0.3))]
    made[0].name, made[3].name = "made torus", "made ellipsoid"
    made[1].name, made[2].name = "made sphere", "made cube"
    logs = {curve: [] for curve in CURVES[1:]}
    for model in figures.models + made:
        figures.note(model.name)
        with figures.attempt(model.name):
            points = []
            for curve in CURVES:
                run = ["--method", "conformal", "--curve", curve, "--sequence", "stratified"]
                staged = laboratory.stage(run=run, n=n, **model.arrays)
                points += [laboratory.samples(staged=staged, run=run, n=n, seed=figures.seed + k).points
                           for k in range(runs)]
            ratios = laboratory.box_errors(points=numpy.vstack(points), sets=3 * runs, boxes=boxes, seed=figures.seed,
                                           **model.arrays).ratios.reshape(3, runs)
            for curve, ratio in zip(CURVES[1:], ratios[1:]):
                difference = numpy.log(ratio / ratios[0])
                logs[curve].append(difference.mean())
                yield (model.name, curve, runs, *ratio_of(difference))
    for curve in CURVES[1:]:
        yield ("all models", curve, len(logs[curve]), *ratio_of(logs[curve]))


def draw_3(figures):
    def draw(axes):
        for column, curve in enumerate(CURVES):
            for row in range(2):
                ax, branching = axes[row, column], 2 if curve == "hilbert" else 3
                centers = laboratory.curve_cells(curve=curve, level=row + 1).centers
                square_axes(ax, "" if row else {"hilbert": "Hilbert", "peano": "Peano"}.get(curve, "variant of Peano"))
                for k in range(1, branching ** (row + 1)):
                    ax.axhline(k / branching ** (row + 1), color="#dcdcdc", linewidth=0.6)
                    ax.axvline(k / branching ** (row + 1), color="#dcdcdc", linewidth=0.6)
                line_along(ax, centers, numpy.linspace(0, 1, len(centers)), 2.4 - row)
                ax.plot(*centers[0], "o", color=look.PALETTE[1], markersize=6 - 2 * row, zorder=4)
        for row in range(2):
            axes[row, 0].set_ylabel("iteration %d" % (row + 1))

    figures.plot("figure03_curves", "Through the centers of the cells, from the dot, dark to light", draw, 7.2, 5.0, nrows=2,
                 ncols=3)
    rows = list(curves_on_plane(figures)) + list(curves_on_meshes(figures))
    figures.table("figure03_comparison", "Errors of stratified samples along the other curves over those along Hilbert's: 1 "
                  "is equal, above 1 Hilbert is better. Plane: discrepancy; models: error over random boxes, last the "
                  "mean over models", ["where", "curve", "comparisons", "error / Hilbert", "standard error"], rows)
    words = ["%s, %s: %+.1f +- %.1f %%" % (where, curve, 100 * (ratio - 1), 100 * error)
             for where, curve, _, ratio, error in rows if where.startswith("plane, ") or where == "all models"]
    figures.measured("error of the others over Hilbert's (positive: Hilbert is better): %s." % "; ".join(words))


# ---- discrepancy

def draw_4_plane(figures):
    most, shapes, runs = (12288, 512, 3) if figures.quick else (1572864, 4096, 3)
    slow = {"poisson-disk": 1024 if figures.quick else 16384}
    slow["lloyd"] = slow["poisson-disk"]
    methods = ["random", "hilbert-stratified", "hilbert-shifted", "jittered", "halton", "hammersley", "sobol", *slow]
    found = {m: error_series(figures, m, survey_counts(slow.get(m, most)), 1 if m in DETERMINISTIC else runs, in_square(m),
                             square_errors(figures, shapes)) for m in methods}
    captions = ["Exact to 16,384 points, above that a search from 16,384 random boxes (a lower bound)",
                "%d triangles with a corner at the origin, the same for all" % shapes, "Exact over radii up to 1"]
    for number, (name, caption) in enumerate(zip(SHAPES, captions)):
        draw_errors(figures, "figure04_plane_" + name.replace("quarter ", ""), name.capitalize() + " at the origin",
                    [found[m][number] for m in methods], "discrepancy", caption, shown=(1024, 4096, 12288))
    words = []
    for number, name in enumerate(SHAPES):
        ours = found["hilbert-stratified"][number]
        ratios = ", ".join("%.2f %s" % (compared(ours, found[m][number]), m) for m in ("halton", "hammersley", "sobol"))
        words.append("%s %s (slope %.2f +- %.2f)" % (name, ratios, *ours.slope(16)))
    figures.measured("means of %d runs (one of deterministic sets) to %d points; error of Hilbert-stratified points over "
                     "those of other sets from 64 points on, as geometric means: %s." % (runs, most, "; ".join(words)))


def draw_4_placement(figures):
    counts, shapes, runs = survey_counts(3072 if figures.quick else 12288, 16), 512 if figures.quick else 4096, 3
    sets = {"vertex, %s a point" % text: in_square("hilbert-vertex", leaves=leaves)
            for leaves, text in ((1, "1 leaf"), (4, "4 leaves"), (16, "16 leaves"), (64, "64 leaves"))}
    sets["inside the element"] = in_square("hilbert-stratified")
    series = [error_series(figures, name, counts, runs, make, square_errors(figures, shapes))[0]
              for name, make in sets.items()]
    draw_errors(figures, "figure04_placement", "Boxes at the origin", series, "discrepancy",
                "Stratified along the Hilbert curve", shown=(1024, counts[-1]))
    figures.measured("errors over those inside of elements, from 64 points on: %s." % ", ".join(
        "%.2f with %s" % (compared(s, series[-1]), s.name.removeprefix("vertex, ")) for s in series[:-1]))


def draw_4_sphere(figures):
    counts, triangles, runs = survey_counts(3072 if figures.quick else 196608, 16), 512 if figures.quick else 4096, 3
    on_sphere = lambda method: lambda n, seed: laboratory.points_on_sphere(method=method, n=n, seed=seed).points
    methods = {name: on_sphere(name)
               for name in "random hilbert-stratified hilbert-shifted hammersley fibonacci spiral".split()}
    methods["surface sampler"] = lambda n, seed: laboratory.surface_samples(surface="sphere", n=n, seed=seed).points

    def measure(points):
        points = points / numpy.linalg.norm(points, axis=1)[:, None]  # the sampler's are rounded
        errors = laboratory.sphere_discrepancy(points=points, axes=200, triangles=triangles, seed=figures.seed)
        return errors.caps, errors.triangles

    found = {name: error_series(figures, name, counts, 1 if name in DETERMINISTIC else runs, make, measure)
             for name, make in methods.items()}
    shown, words = (1024, min(counts[-1], 4096)), []
    for number, (stem, title, caption) in enumerate((
            ("caps", "Spherical caps", "Exact over heights, for 200 random axes, the same for all"),
            ("triangles", "Spherical triangles", "%d random triangles, the same for all" % triangles))):
        series = [both[number] for both in found.values()]
        draw_errors(figures, "figure04_sphere_" + stem, title, series, "discrepancy", caption, shown=shown)
        slopes = ["%s %.2f" % (m, found[m][number].slope(16)[0]) for m in ("surface sampler", "fibonacci", "random")]
        words.append("%s: slopes %s; error of the surface sampler over that of fibonacci points %.2f" % (
            stem, ", ".join(slopes), compared(found["surface sampler"][number], found["fibonacci"][number])))
    figures.measured("%s. The surface sampler knows only the formula of the sphere." % "; ".join(words))


def draw_5(figures):
    counts, shapes, runs = survey_counts(3072 if figures.quick else 98304, 16), 512 if figures.quick else 4096, 3
    densities = [("x2y2", "squares", "x$^2$y$^2$"), ("cos3sin3", "waves", "cos 3x sin 3y cos xy + 1"),
                 ("cos10", "product-wave", "cos 10xy + 1")]
    samples = lambda expression, n, seed, sequence: laboratory.surface_samples(
        surface="plane", density=expression, n=n, seed=seed, sequence=sequence, tolerance=1e-5).uv

    def draw(axes):
        for ax, (expression, _, title) in zip(axes, densities):
            square_axes(ax, title)
            dots(ax, samples(expression, 2048, figures.seed, "shifted"))

    figures.plot("figure05_samples", "2,048 samples each, shifted sequence", draw, 7.2, 2.7, ncols=3)
    words = []
    for expression, density, title in densities:
        series = [error_series(
            figures, name, counts, runs, lambda n, seed: samples(expression, n, seed, name.removeprefix("hilbert-")),
            lambda points: [laboratory.density_discrepancy(points=points, density=density, shapes=shapes,
                                                           seed=figures.seed).boxes])[0]
            for name in ("random", "hilbert-stratified", "hilbert-shifted")]
        draw_errors(figures, "figure05_" + expression, "Density " + title, series, "discrepancy",
                    "%d boxes at the origin against their exact measures" % shapes)
        words.append("%s %s" % (expression, ", ".join("%s %.2f" % (s.name, s.slope(16)[0]) for s in series)))
    figures.measured("slopes over boxes at the origin, from 16 points: %s." % "; ".join(words))
