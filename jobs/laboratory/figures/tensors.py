"""Figures 12 to 15, and 16 of anisotropic samples: fields, segments, charts and curves, and samples in the metric."""
import math

import numpy

from .. import SamplingError, laboratory
from . import look, models
from .errors import ErrorSeries, survey_counts
from .surfaces import joined, model_picture, picture

MOST_RATIO = 8  # of s1 / s2, unless --tensor-ratio says otherwise
RUN = ["--method", "anisotropic"]
SMOOTH = ["--tensor-smoothing", "64"]  # where charts along the field are looked at: on scans they are small otherwise
INK, FAINT, PLAIN = (28, 28, 34), (150, 150, 150), (236, 236, 236)
FLAT = {"view": numpy.array([0.0, 0, 1]), "up": numpy.array([0.0, 1, 0])}
SCALE = "bar: s1/s2 from 1 to %d" % MOST_RATIO


# ---- what figures share

def ply_text(names, values, faces=None, colors=None):
    """A PLY file: columns of the vertices by name, triangles with colors (T, 3)."""
    parts = ["red", "green", "blue"]
    head = ["ply", "format ascii 1.0", "element vertex %d" % len(values)]
    head += ["property %s %s" % ("uchar" if name in parts else "double", name) for name in names.split()]
    lines = [" ".join("%.12g" % number for number in row) for row in values]
    if faces is not None:
        head += ["element face %d" % len(faces), "property list uchar int vertex_indices"]
        head += ["property uchar " + name for name in parts]
        lines += ["3 %d %d %d %d %d %d" % (*face, *color) for face, color in zip(faces, colors)]
    return "\n".join([*head, "end_header", *lines, ""])


def rgb(colors):
    """(n, 3) uint8 of colors like #d55e00."""
    return numpy.array([list(bytes.fromhex(color[1:])) for color in colors], numpy.uint8).reshape(-1, 3)


def paler(colors, share):
    return (colors + (255 - colors.astype(float)) * share).astype(numpy.uint8)


PALE = paler(rgb(color for color in look.PALETTE if color != "#000000"), 0.4)  # no shading shows on black


def ratios(samples):
    return (samples.tensor_spacing[:, 0] / samples.tensor_spacing[:, 1]).astype(float)


def ratio_colors(ratio):
    """Pale green at 1, dark violet at the largest."""
    return look.map_color(0.86 * (1 - numpy.log(ratio) / math.log(MOST_RATIO)))


def with_scale(image):
    """The colors of ratios in the lower left corner, the least one left."""
    size = len(image)
    high, wide, left = max(6, size // 45), size // 4, size // 40
    image[size - left - high:size - left, left:left + wide] = ratio_colors(
        MOST_RATIO ** ((numpy.arange(wide) + 0.5) / wide))
    return image


def drawn(*parts):
    """Lines as `picture` takes them, of (segments (L, 6), one color or as many, width), later ones on top."""
    return dict(lines=numpy.vstack([part[0] for part in parts]), line_widths=numpy.concatenate(
        [numpy.full(len(part[0]), float(part[2])) for part in parts]), line_colors=numpy.vstack(
            [numpy.broadcast_to(numpy.asarray(part[1], numpy.uint8), (len(part[0]), 3)) for part in parts]))


def ellipses(samples, share, colors):
    """Ellipses of the spacings as `picture` takes them, `share` of a half of each to either side."""
    across = numpy.cross(samples.normals, samples.tensor_direction)
    across /= numpy.maximum(numpy.linalg.norm(across, axis=1, keepdims=True), 1e-12)
    half = 0.5 * share * samples.tensor_spacing
    return dict(discs=numpy.hstack([samples.points, half[:, :1] * samples.tensor_direction, half[:, 1:] * across]),
                disc_colors=numpy.atleast_2d(numpy.asarray(colors, numpy.uint8)))


def edge_lines(corners, edges):
    """(L, 6): the edges of triangles (T, 3, 3) that are marked (T, 3)."""
    return numpy.concatenate([corners, numpy.roll(corners, -1, axis=1)], axis=2)[edges]


def soup(triangles):
    return {"vertices": triangles.reshape(-1, 3), "faces": numpy.arange(triangles.size // 3).reshape(-1, 3)}


def curves_of(staged, run, n):
    """The curves of about n leaves, clipped to their charts."""
    curves = laboratory.segment_curves(staged=staged, run=run, n=n, leaves_per_sample=1.0)
    if len(curves.points) == 0:
        raise SamplingError("empty", "none of its charts has a curve")
    return curves


class Charts:
    """What laboratory.segment_charts returns, with triangles as (T, 3, 3), those of charts in the plane z = 0."""

    def __init__(self, staged, run):
        self.__dict__.update(laboratory.segment_charts(staged=staged, run=run).__dict__)
        self.corners, self.share = self.corners.reshape(-1, 3, 3), self.area / self.area.sum()
        self.uv = numpy.pad(self.uv.reshape(-1, 3, 2), [(0, 0), (0, 0), (0, 1)])
        self.normals = numpy.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0]) / 2
        self.flat = numpy.isfinite(self.uv[:, 0, 0])

    def colors(self):
        """(S, 3): different between neighbors while there are enough, each about equally often."""
        border = (self.edges == 2).any(axis=1)
        _, place = numpy.unique(self.vertices[border], return_inverse=True)
        touch = numpy.zeros((len(self.area), place.size and place.max() + 1), numpy.float32)
        touch[numpy.repeat(self.segment[border], 3), place.ravel()] = 1
        chosen = numpy.zeros(len(self.area), int)
        for segment in range(len(chosen)):
            beside = touch[:segment] @ touch[segment] > 0
            chosen[segment] = numpy.argmin(numpy.bincount(chosen[:segment], 1 + 1e6 * beside, len(PALE)))
        return PALE[chosen]

    def laid_out(self):
        """uv of the charts beside each other, each in its true size, high ones first."""
        boxes = {}
        for segment in numpy.unique(self.segment[self.flat]):
            uv = self.uv[self.segment == segment]
            area = numpy.abs(numpy.cross(uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0])[:, 2]).sum() / 2
            low, scale = uv.min(axis=(0, 1)), (self.share[segment] / max(area, 1e-30)) ** 0.5
            boxes[segment] = low, scale, scale * (uv.max(axis=(0, 1)) - low)
        gap, x, y, high, result = 0.12 / max(1, len(boxes)) ** 0.5, 0, 0, 0, self.uv.copy()
        most = 1.25 * sum((size[0] + gap) * (size[1] + gap) for _, _, size in boxes.values()) ** 0.5
        for segment, (low, scale, size) in sorted(boxes.items(), key=lambda box: -box[1][2][1]):
            if x > 0 and x + size[0] > most:
                x, y, high = 0, y - high - gap, 0
            own = self.segment == segment
            result[own] = scale * (self.uv[own] - low) + (x, y - size[1], 0)
            x, high = x + size[0] + gap, max(high, size[1])
        return result


# ---- figure 12: curves and fields

def draw_12(figures):
    rows, angles = [], []
    for model in figures.models:
        with figures.attempt(model.name):
            angles.append("%s %.1f along the parameterization, %.1f along the field" % (
                model.name, *aligned(figures, model, rows)))
    figures.table("figure12_curves", "The curve over charts of the surface, and over charts along the field",
                  ["model", "aligned to", "segments", "leaves", "chains", "mean angle to the field, degrees"], rows)
    figures.measured("Mean angle between the axes of the charts and the field, at most 45 and by chance 22.5 degrees: %s."
                     % "; ".join(angles))
    body = models.unit_sphere(32 if figures.quick else 64, (1.6, 0.8, 1.2))  # poles far from the umbilics
    body = models.Model("ellipsoid", body.vertices[:, [0, 2, 1]], body.faces[:, ::-1])
    for model in [body] + figures.models:
        with figures.attempt(model.name):
            draw_field(figures, model)
    figures.text("The field", "Lines along the direction of least absolute curvature, colored by the ratio of the spacings "
                 "s1 and s2 that are wanted along and across. Dots: its singularities, blue where on a way around the lines "
                 "turn by half a turn with it, vermilion where against it. An isotropic region has one at most.")


def aligned(figures, model, rows):
    n, images, angles = (500 if figures.quick else 2500), [], []
    for name, words in (("parameterization", ["--tensor", "isotropic"]),
                        ("field", SMOOTH + ["--parameterization", "gradient", "--segments", "32"])):
        staged = laboratory.stage(**model.arrays, run=RUN + words, n=n)
        charts, curves = Charts(staged, RUN + SMOOTH), curves_of(staged, RUN + words, n)
        weight = numpy.linalg.norm(charts.normals, axis=1) * (charts.ratio > 1.5)
        if not weight.any():
            raise SamplingError("empty", "its field has no direction")
        off = numpy.degrees(numpy.minimum(charts.angle, math.pi / 2 - charts.angle))
        angles.append(numpy.average(off, weights=weight))
        leaves = int(curves.leaves.sum())
        rows.append([model.name, name, len(charts.area), leaves, int(curves.chain.max()) + 1, angles[-1]])
        line = drawn((joined(curves.points, curves.chain)[0], INK, figures.size / 450))
        images.append((model_picture(figures, model, **line), "aligned to the " + name,
                       "%d leaves, %.0f° from the field" % (leaves, angles[-1])))
    figures.panels("figure12_" + model.name, "%s: the curve aligned to the parameterization, and aligned to the field"
                   % model.name, images)
    return angles


def draw_field(figures, model):
    images, kinds = [], {1: ("wedge", look.PALETTE[0]), -1: ("trisector", look.PALETTE[1])}
    for smoothing, stem in ((3, "figure12_%s_singularities"), (64, "figure12_%s_smooth_singularities")):
        run, stem = RUN + ["--tensor-smoothing", str(smoothing)], stem % model.name
        found = laboratory.field_singularities(**model.arrays, run=run)
        places, turns = found.positions, found.half_turns
        colors = rgb(kinds[numpy.sign(turn)][1] for turn in turns)
        samples = laboratory.samples(**model.arrays, run=run, n=1200 if figures.quick else 5000, seed=figures.seed)
        half = 0.5 * samples.tensor_spacing.prod(axis=1, keepdims=True) ** 0.5 * samples.tensor_direction
        marks = drawn((numpy.hstack([samples.points - half, samples.points + half]), ratio_colors(ratios(samples)),
                       figures.size / 400))
        if len(places):
            marks.update(dots=places, dot_colors=colors, dot_radii=numpy.array([figures.size / 130]))
        images.append((with_scale(model_picture(figures, model, **marks)), "smoothed %d times" % smoothing,
                       "%d singularities; %s" % (len(places), SCALE)))
        figures.table(stem, "%s, %d rounds of smoothing: Euler characteristic %d, sum of the indices %g, mean ratio %.2f" % (
            model.name, smoothing, found.euler, sum(turns) / 2, found.mean_ratio), ["kind", "index", "x", "y", "z"],
            [[kinds[numpy.sign(turn)][0], turn / 2, *at] for turn, at in zip(turns, places)], shown=len(places) < 10)
        figures.data(stem + ".ply", ply_text(
            "x y z red green blue index", numpy.column_stack([places, colors, numpy.asarray(turns, float) / 2])))
    figures.panels("figure12_%s_field" % model.name, "%s: the tensor field and its singularities" % model.name, images)


# ---- figure 13: segments, charts and curves

STYLES = {"solid": [(0, 1)], "dashed": [(0, 0.62)], "dotted": [(0, 0.1), (0.25, 0.35), (0.5, 0.6), (0.75, 0.85)],
          "dash-dot": [(0, 0.5), (0.7, 0.8)]}


def styled(points, period, style):
    """(L, 6): the parts of a chain of points (P, 3) that lie in the intervals of a style, in periods of its length."""
    length = numpy.concatenate([[0], numpy.cumsum(numpy.linalg.norm(numpy.diff(points, axis=0), axis=1))]) / period
    ends = (numpy.arange(math.ceil(length[-1]))[:, None] + numpy.ravel(style)).ravel()
    at = numpy.unique(numpy.concatenate([length, ends[ends < length[-1]]]))
    points = numpy.stack([numpy.interp(at, length, column) for column in points.T], axis=1)
    middle = (at[1:] + at[:-1]) / 2 % 1
    return joined(points)[0][numpy.any([(middle > a) & (middle < b) for a, b in style], axis=0)]


def draw_13(figures):
    said = []
    for model in figures.models:
        for form, segments in (("metric", 8), ("gradient", 16)):
            with figures.attempt(model.name):
                said.append(draw_segments(figures, model, form, segments))
    figures.measured("Pieces of the plane are charts, in the colors of their segments. The curve of a chart is clipped "
                     "to it and comes in chains: solid, dashed, dotted and dash-dotted in turn. Samples: ellipses, 0.62 of "
                     "the spacings wanted. %s." % "; ".join(said))


def draw_segments(figures, model, form, segments):
    n, stem = (250 if figures.quick else 900), "figure13_%s_%s" % (model.name, form)
    run = RUN + ["--parameterization", form, "--segments", str(segments)] + SMOOTH * (form == "gradient")
    staged = laboratory.stage(**model.arrays, run=run, n=n)
    charts, curves = Charts(staged, run), curves_of(staged, run, n)
    samples = laboratory.samples(staged=staged, run=run, n=n, seed=figures.seed)
    colors, flat, thin = charts.colors(), charts.flat, figures.size / 500
    painted = numpy.full((len(model.faces), 3), FAINT, numpy.uint8)
    painted[charts.face] = colors[charts.segment]
    laid, border, pale = charts.laid_out(), edge_lines(charts.corners, charts.edges == 2), paler(painted, 0.5)
    period = 0.02 * numpy.linalg.norm(numpy.ptp(model.vertices, axis=0))
    chains = [curves.points[curves.chain == chain] for chain in numpy.unique(curves.chain)]
    dashes = numpy.vstack([styled(points, period, list(STYLES.values())[k % 4]) for k, points in enumerate(chains)])
    form_of = "conformal in the metric" if form == "metric" else "along the field"
    figures.panels(stem, "%s, charts %s: pieces of the plane, segments, chains and samples" % (model.name, form_of), [
        (picture(figures, **soup(laid[flat]), **FLAT, face_colors=colors[charts.segment[flat]],
                 **drawn((edge_lines(laid, (charts.edges > 0) & flat[:, None]), INK, thin))),
         "pieces of the plane", "%d charts" % len(set(charts.segment[flat]))),
        (model_picture(figures, model, face_colors=painted, **drawn((border, INK, 1.5 * thin))),
         "on the surface", "%d segments" % len(charts.area)),
        (model_picture(figures, model, face_colors=pale, **drawn((border, FAINT, thin), (dashes, INK, 1.7 * thin))),
         "chains of the curves", "%d; %s" % (len(chains), ", ".join(STYLES))),
        (model_picture(figures, model, face_colors=pale, **drawn((border, FAINT, thin)), **ellipses(samples, 0.62, INK)),
         "sampling", "%d samples" % n)])
    figures.data(stem + "_segments.ply", ply_text("x y z", model.vertices, model.faces, painted))
    rows = []
    for segment in numpy.argsort(-charts.area, kind="stable"):
        own = charts.segment == segment
        kind = ("anisotropic" if charts.anisotropic[segment] else "mean-value") if flat[own].any() else "none"
        rows.append([segment, charts.share[segment], own.sum(), int(curves.leaves[segment]),
                     len(set(curves.chain[curves.segment == segment])), kind])
    figures.table(stem + "_segments", stem, ["segment", "share of the area", "triangles", "leaves", "chains", "chart"], rows,
                  shown=False)
    return "%s, charts %s: %d segments, %.0f %% of the area in charts within the limits, %d chains" % (
        model.name, form_of, len(rows), 100 * charts.accepted_share, len(chains))


# ---- figure 14: the steps of one segment

def draw_14(figures):
    said = []
    for model in figures.models:
        with figures.attempt(model.name):
            said.append(draw_steps(figures, model))
    figures.measured("(a) The surface in segments; (b) the spacings that the field wants; (c) a chart conformal in the "
                     "metric, where they are round; (d) the curve over it, clipped; (e) strata along it, of the same "
                     "mass; (f) a sample in each, with its spacings. %s." % "; ".join(said))


def draw_steps(figures, model):
    n, run, looks = (800 if figures.quick else 2400), RUN + ["--segments", "8"], models.view_of(figures, model)
    staged = laboratory.stage(**model.arrays, run=run, n=n)
    charts, curves = Charts(staged, run), curves_of(staged, run, n)
    # The segment of which most is seen; one with a chart in the metric where there is any.
    seen = numpy.maximum(charts.normals @ looks["view"], 0) * charts.flat * (1 + 1e6 * charts.anisotropic[charts.segment])
    chosen = numpy.argmax(numpy.bincount(charts.segment, seen))
    own, mine = charts.segment == chosen, curves.segment == chosen
    if not charts.flat[own].all():
        raise SamplingError("empty", "what is seen has no charts")
    corners, uv = charts.corners[own], charts.uv[own]
    shape, thin, number = soup(corners), figures.size / 400, numpy.full(charts.source.max() + 1, -1)
    number[charts.source[own]] = numpy.arange(len(corners))
    border = edge_lines(corners, charts.edges[own] == 2), FAINT, thin
    outline = edge_lines(uv, charts.edges[own] > 0), FAINT, thin

    def inside(count):
        """Ellipses of as many samples of the whole: those in the segment, their triangles in it, and all samples."""
        samples = laboratory.samples(staged=staged, run=run, n=count, seed=figures.seed)
        marks, held = ellipses(samples, 0.8, ratio_colors(ratios(samples))), number[samples.triangle] >= 0
        return {name: values[held] for name, values in marks.items()}, number[samples.triangle[held]], samples

    # Ellipses in the chart are those on the surface under the Jacobians of their triangles.
    field, triangle, _ = inside(n // 3)
    first, flat_first = corners[triangle][:, :1], uv[triangle][:, :1]
    jacobian = numpy.linalg.pinv(corners[triangle][:, 1:] - first) @ (uv[triangle][:, 1:] - flat_first)
    ends = field["discs"].reshape(-1, 3, 3)
    turn, lengths, axes = numpy.linalg.svd(ends[:, 1:] @ jacobian, full_matrices=False)
    flat_ends = numpy.concatenate([flat_first + (ends[:, :1] - first) @ jacobian, lengths[:, :, None] * axes], axis=1)
    flat_field = dict(field, discs=flat_ends.reshape(-1, 9))

    pieces = laboratory.segment_pieces(staged=staged, run=run, n=n, seed=figures.seed)
    held = own[pieces.triangle]
    strata = numpy.floor(pieces.position[held]).astype(int)
    marks, triangle, samples = inside(n)
    painted = numpy.full((len(model.faces), 3), PLAIN, numpy.uint8)
    painted[charts.face[own]] = look.SKIN
    all_borders = edge_lines(charts.corners, charts.edges == 2), FAINT, thin
    curve = joined(numpy.pad(curves.uv[mine], [(0, 0), (0, 1)]), curves.chain[mine])[0]
    figures.panels("figure14_" + model.name, "%s: the steps of one segment" % model.name, [
        (model_picture(figures, model, face_colors=painted, **drawn(all_borders)), "(a) a segment",
         "%.0f %% of the area" % (100 * charts.share[chosen])),
        (with_scale(picture(figures, **shape, **looks, **field, **drawn(border))), "(b) its field", SCALE),
        (picture(figures, **soup(uv), **FLAT, **flat_field, **drawn(outline)), "(c) its chart",
         "conformal in the metric" if charts.anisotropic[chosen] else "mean value"),
        (picture(figures, **soup(uv), **FLAT, **drawn(outline, (curve, INK, thin))), "(d) the curve",
         "%d chains" % len(set(curves.chain[mine]))),
        (picture(figures, **soup(pieces.corners[held]), **looks, face_colors=PALE[strata % len(PALE)]), "(e) its strata",
         "%d of equal mass" % len(set(strata))),
        (picture(figures, **shape, **looks, **marks, **drawn(border)), "(f) samples", "%d" % len(triangle))])
    figures.data("figure14_%s_samples.ply" % model.name, ply_text(
        "x y z nx ny nz red green blue direction_x direction_y direction_z spacing_1 spacing_2", numpy.hstack([
            samples.points, samples.normals, ratio_colors(ratios(samples)), samples.tensor_direction,
            samples.tensor_spacing])))
    return "%s: %d strata and %d of %d samples in %.1f %% of the area" % (
        model.name, len(set(strata)), len(triangle), n, 100 * charts.share[chosen])


# ---- figure 15: discrepancy in the metric

RATIOS, ANGLE = (1, 2, 4, 8), math.pi / 6  # of e1: along neither the edges nor the diagonals of a square


def constant_field(ratio):
    """Options of run: S with s1 s2 = 1 and e1 at ANGLE, in the plane z = 0."""
    c, s, first, second = math.cos(ANGLE), math.sin(ANGLE), ratio ** 0.5, ratio ** -0.5
    parts = (first * c * c + second * s * s, (first - second) * c * s, 0, first * s * s + second * c * c, 0, 1)
    return RUN + ["--tensor", "constant:" + ",".join("%.17g" % part for part in parts)]


def draw_15(figures):
    square, most, runs = models.unit_square(128), 1536 if figures.quick else 12288, 3
    shapes, kinds, series = 512 if figures.quick else 1024, ("boxes", "disks", "triangles"), {}
    for ratio in RATIOS:
        run = constant_field(ratio)
        staged = laboratory.stage(**square.arrays, run=run, n=most)
        for sequence in ("shifted", "random"):
            figures.note("ratio %g, %s" % (ratio, sequence))
            own = {kind: ErrorSeries("%s, ratio %g" % (sequence, ratio)) for kind in kinds}
            series.update(((kind, ratio, sequence), one) for kind, one in own.items())
            for count in survey_counts(most, 64):
                sets = (laboratory.samples(staged=staged, run=run + ["--sequence", sequence], n=count, seed=seed)
                        for seed in range(figures.seed, figures.seed + runs))
                found = [laboratory.metric_discrepancy(points=samples.points[:, :2], ratio=ratio, angle=ANGLE, shapes=shapes,
                                                       windows=4, seed=figures.seed) for samples in sets]
                points = float(numpy.mean([each.points for each in found]))
                for kind in kinds * all(each.windows for each in found):
                    for each in found:
                        own[kind].add(points, getattr(each, kind))
    rows, data = [], []
    for key in sorted(series, key=lambda key: (key[0], key[1], key[2] == "random")):
        counts, means, errors = series[key].means()
        data += [[*key, *values] for values in zip(counts, means, errors)]
        (slope, error), kept = series[key].slope(16), counts >= 16
        fit = math.exp(numpy.log(means[kept]).mean() + slope * (math.log(1000) - numpy.log(counts[kept]).mean()))
        rows.append([*key, slope, error, counts[kept].min(), counts[kept].max(), fit])

    def draw(axes):
        for ax, kind in zip(axes, kinds):
            for number, ratio in enumerate(RATIOS):
                for sequence, style, fill in (("shifted", "-", None), ("random", "--", "white")):
                    one = series[kind, ratio, sequence]
                    counts, means, errors = one.means()
                    ax.errorbar(counts, means, yerr=errors, label=one.name, linewidth=1.1, linestyle=style, markersize=3,
                                color=look.PALETTE[number], marker=look.MARKERS[number], markerfacecolor=fill)
            ax.set(xscale="log", yscale="log", xlabel="points in the window", title=kind)
        axes[0].set_ylabel("discrepancy")
        axes[-1].legend(loc="center left", bbox_to_anchor=(1.02, 0.5))

    names = ["shapes", "ratio", "sequence"]
    figures.plot("figure15_discrepancy", "%d boxes, disks and triangles of the metric in 4 windows; means of %d runs and "
                 "their standard errors" % (shapes, runs), draw, 10.5, 3.6, ncols=3, sharey=True, sharex=True)
    figures.table("figure15_discrepancy", "Discrepancy in the metric", names + ["points in the window", "discrepancy",
                                                                                "standard error"], data, shown=False)
    figures.table("figure15_slopes", "Slopes over the points in the window, from 16, and the fit at 1,000",
                  names + ["slope", "its error", "from points", "to points", "fit at 1000 points"], rows)
    low, random = ([row for row in rows if row[2] == sequence] for sequence in ("shifted", "random"))
    figures.measured("A constant tensor on a square, shapes that are boxes, disks and triangles of its metric inside of the "
                     "largest ellipse of the field: slopes of %.2f to %.2f over all ratios, random points %.2f to %.2f; at "
                     "1,000 points %.1f times less than random." % (
                         *(end(row[3] for row in some) for some in (low, random) for end in (min, max)),
                         sum(row[7] for row in random) / sum(row[7] for row in low)))


# ---- figure 16: differences in the metric

SPAN = {"range": 3.5, "cells": 160}  # of maps of differences
EDGES, CLASSES = (1.5, 3, 5), ("1 - 1.5", "1.5 - 3", "3 - 5", "5 - 8")
COLUMNS = ["samples counted", "mean ratio", "dip ratio, area", "its angle to e1, degrees", "dip ratio, spacings",
           "depth, spacings", "signal to noise, area"]


class Dips:
    """Differences between samples in a field over those of independent ones, in units of area and of spacings, counted in
    the frames of one class of ratios, or of all."""

    def __init__(self, figures, staged, run, n, sets, classes):
        sums, self.found = {}, {}
        counted, total = dict.fromkeys(classes, 0), dict.fromkeys(classes, 0.0)
        for sequence, number in (("shifted", sets), ("random", 4 * sets)):
            for seed in range(figures.seed, figures.seed + number):
                samples = laboratory.samples(staged=staged, run=run + ["--sequence", sequence], n=n, seed=seed)
                ratio = ratios(samples)
                classed = numpy.array(CLASSES)[numpy.searchsorted(EDGES, ratio, side="right")]
                for name in classes:
                    own = (classed == name) | (name == "all")
                    if sequence == "shifted":
                        counted[name], total[name] = counted[name] + int(own.sum()), total[name] + ratio[own].sum()
                    for units in ("area", "spacings"):
                        sums[name, units, sequence] = sums.get((name, units, sequence), 0) + laboratory.tensor_differences(
                            points=samples.points, normals=samples.normals, directions=samples.tensor_direction,
                            spacings=samples.tensor_spacing, counted=own.astype(numpy.uint8), units=units, **SPAN).map
        for name in classes:
            if counted[name] >= 300:
                self.found[name] = counted[name], total[name] / counted[name], *(laboratory.difference_dip(
                    map=sums[name, units, "shifted"], reference=sums[name, units, "random"], sets=sets,
                    reference_sets=4 * sets, **SPAN) for units in ("area", "spacings"))

    def row(self, name):
        counted, wanted, area, spacings = self.found[name]
        return [counted, wanted, area.ratio if area.found else None,
                math.degrees(area.angle) if area.found and area.ratio > 1.2 else None,
                spacings.ratio if spacings.found else None, spacings.depth, area.signal_to_noise]

    def said(self, name):
        _, wanted, area, _ = self.found[name]
        return "%s for %.2f" % ("%.2f" % area.ratio if area.found else "none found", wanted)


def draw_maps(figures, stem, caption, columns):
    """columns: (title, dip in units of area, dip in units of spacings); None where there is no one shape."""
    half = SPAN["range"]

    def draw(axes):
        for column, (title, *dips) in enumerate(columns):
            for ax, units, dip in zip(axes[:, column], ("area", "spacings"), dips):
                if dip is None:
                    ax.axis("off")
                    continue
                ax.set_facecolor("#cdd4e1")  # seen where no pair of independent samples reaches
                shown = ax.imshow(dip.differences, extent=(-half, half, -half, half), origin="lower", cmap="gray", vmin=0,
                                  vmax=2, interpolation="nearest")
                if dip.found:
                    ax.plot(*numpy.vstack([dip.ellipse, dip.ellipse[:1]]).T, color=look.PALETTE[1], linewidth=1.6)
                ax.set_title("%s\n%s" % (title, "dip %.2f" % dip.ratio if dip.found else "no dip found"), fontsize=9)
                ax.grid(False)
                ax.set(xticks=(-2, 0, 2), yticks=(-2, 0, 2), xlabel="along e1" if units == "spacings" else "",
                       ylabel="" if column else "across, units of " + units)
        axes[0, 0].figure.colorbar(shown, ax=axes, label="differences over independent samples", shrink=0.6)

    figures.plot(stem, caption, draw, 1.1 + 2.1 * len(columns), 5.0, nrows=2, ncols=len(columns), squeeze=False)


def draw_16_tensor(figures):
    table, said = [], []
    sets, n = (3, 1000) if figures.quick else (10, 5000)
    for side in (128, 32):
        square, columns, words = models.unit_square(side), [], []
        for ratio in RATIOS:
            figures.note("%d triangles, ratio %g" % (len(square.faces), ratio))
            run = constant_field(ratio)
            dips = Dips(figures, laboratory.stage(**square.arrays, run=run, n=n), run, n, sets, ["all"])
            table.append([len(square.faces), *dips.row("all")])
            columns.append(("ratio %g" % ratio, *dips.found["all"][2:]))
            words.append(dips.said("all"))
        draw_maps(figures, "figure16_tensor_plane_%d" % len(square.faces), "Constant fields in the plane on %d triangles; "
                  "under each ratio that of the axes of the dip" % len(square.faces), columns)
        said.append("on %d triangles %s" % (len(square.faces), ", ".join(words)))
    figures.table("figure16_tensor_plane", "Dips in the plane, on a fine and a coarse mesh", ["triangles"] + COLUMNS, table)
    square = models.unit_square(96)
    x, y = (square.vertices[:, :2] - 0.5).T
    r = numpy.hypot(x, y)
    ratio, unit = 1 + 7 * numpy.minimum(1, 2 * r), numpy.where(r > 0, r, 1)
    swirl = numpy.stack([numpy.where(r > 0, -y / unit, 1) * ratio, x / unit * ratio, 0 * x], axis=1)
    said.append(draw_classes(figures, square, "swirl", n, sets, tensors=swirl, tensor_columns=3))
    for model in figures.models:
        with figures.attempt(model.name):
            said.append(draw_classes(figures, model, model.name, *((1000, 2) if figures.quick else (3000, 8))))
    figures.measured("Differences between samples, e1 to the right, over those of independent samples in the same field. In "
                     "units of area the dip in the middle, drawn at half its depth, is an ellipse of the ratio wanted, "
                     "in units of spacings it is round. Ratios of the axes: %s." % "; ".join(said))


def draw_classes(figures, model, name, n, sets, **field):
    figures.note(name)
    dips = Dips(figures, laboratory.stage(**model.arrays, run=RUN, n=n, **field), RUN, n, sets, [*CLASSES, "all"])
    classes = [each for each in CLASSES if each in dips.found]
    columns = [("ratio %.1f" % dips.found[each][1], *dips.found[each][2:]) for each in classes]
    draw_maps(figures, "figure16_tensor_" + name, "%s: samples by classes of s1 / s2; under the mean ratio of each that of "
              "the axes of the dip" % name, columns + [("all", None, dips.found["all"][3])])
    whole = dips.row("all")
    figures.table("figure16_tensor_" + name, name, ["ratios"] + COLUMNS,
                  [[each, *dips.row(each)] for each in classes] + [["all", *whole[:2], None, None, *whole[4:6], None]])
    return "%s %s" % (name, ", ".join(map(dips.said, classes)))
