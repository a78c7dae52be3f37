"""Figures 6 to 8: a parametric surface, a model from its mesh to splats, and the curve on a mesh."""
import numpy

from .. import laboratory
from . import look
from .models import grid_faces, subjects, view_of

EDGE = (70, 80, 95)


def picture(figures, **given):
    """(size, size, 3) of what laboratory.picture takes."""
    return laboratory.picture(size=figures.size, **given).image.reshape(figures.size, figures.size, 3)


def model_picture(figures, model, **marks):
    return picture(figures, **model.arrays, **view_of(figures, model), **marks)


def lines(segments, colors, width):
    """As `picture` takes them: segments (L, 6), one color or as many."""
    return dict(lines=numpy.ascontiguousarray(segments, float), line_widths=numpy.array([float(width)]),
                line_colors=numpy.atleast_2d(numpy.asarray(colors, numpy.uint8)))


def joined(points, part=None):
    """(L, 6) segments between points that follow each other in one part, and which points they begin at."""
    first = numpy.arange(len(points) - 1)
    if part is not None:
        first = first[part[:-1] == part[1:]]
    return numpy.hstack([points[first], points[first + 1]]), first


def discs(points, normals, radius, color=look.DOT):
    """As `picture` takes them: of one radius, in the tangent planes."""
    axis = numpy.eye(3)[numpy.abs(normals).argmin(axis=1)]
    first = numpy.cross(normals, axis)
    first *= radius / numpy.linalg.norm(first, axis=1, keepdims=True)
    return dict(discs=numpy.hstack([points, first, numpy.cross(normals, first)]),
                disc_colors=numpy.array([color], numpy.uint8))


def with_edges(figures, model, **marks):
    """Picture of a model and its edges, paler where there are many, and none where they would hide it."""
    apart = figures.size / (len(model.faces) / 4) ** 0.5  # pixels, of vertices that are seen
    share = numpy.clip((apart - 4) / 6, 0, 1)
    color = (1 - share) * numpy.array([150, 156, 166]) + share * numpy.array(EDGE)
    if apart > 4:
        marks.update(lines(model.edge_lines(), color, 0.5 + 0.4 * share))
    return model_picture(figures, model, **marks)


def along_curve(curve, width):
    """The curve on the surface from dark to light, as `picture` takes it."""
    segments, first = joined(curve.points, curve.chain)
    return lines(segments, look.map_color(0.75 * curve.along[first]), width)


# ---- figure 6

def draw_6(figures):
    name, across = "eight", 256
    v, u = numpy.meshgrid(numpy.arange(across + 1) / across, numpy.arange(across) / across, indexing="ij")
    at = lambda u, v: laboratory.surface_points(surface=name, uv=numpy.stack([u.ravel(), v.ravel()], axis=1)).points
    # One closed mesh below all that is painted: it hides the far side however far apart samples are.
    faces = grid_faces(across + 1, across + 1)
    faces = faces // (across + 1) * across + faces % (across + 1) % across
    body = dict(vertices=at(u, v), faces=faces.astype(numpy.uint32), up=numpy.array([0, 0, 1.0]),
                view=figures.view if figures.view_given else numpy.array([1, 0.6, 0.55]))
    steps = numpy.arange(across + 1) / across
    grid = []
    for k in range(32):
        # Every other line of constant u ends before all meet.
        ends = [(0, 1)] if k % 2 == 0 else [(1 / 16, 7 / 16), (9 / 16, 15 / 16)]
        grid += [(joined(at(0 * steps + k / 32, a + (b - a) * steps))[0], (0, 114, 178)) for a, b in ends]
        grid.append((joined(at(steps, 0 * steps + k / 32))[0], (213, 94, 0)))
    colors = numpy.vstack([numpy.broadcast_to(color, (len(part), 3)) for part, color in grid])
    shown = [(picture(figures, **body, **lines(numpy.vstack([part for part, _ in grid]), colors, 1.5)), "parameterization",
              "lines of constant u (blue) and v (red)")]
    curve = laboratory.surface_curve(surface=name, leaves=1024, steps=16, seed=figures.seed)
    segments, first = joined(curve.positions)
    shown.append((picture(figures, **body, **lines(segments, look.map_color(0.75 * curve.along[first]), 1.8)),
                  "adaptive curve", "%d leaves" % len(curve.mass)))
    n, rows = 10000, []
    for density in ("uniform", "mean"):
        samples = laboratory.surface_samples(surface=name, n=n, density=density, density_floor=0.05, seed=figures.seed)
        marks = discs(samples.points, samples.normals, 0.24 * (samples.area / n) ** 0.5)
        shown.append((picture(figures, **body, **marks),
                      "uniform samples" if density == "uniform" else "samples by mean curvature", "%d samples" % n))
        rows.append([density, n, samples.area, float(samples.density.max() / samples.density.min())])
    figures.panels("figure06_eight", "The eight surface, two closed halves that touch in a point", shown, columns=2)
    figures.table("figure06_eight", "Samples", ["density", "samples", "area", "densest / sparsest"], rows)
    figures.measured("Each of the %d leaves of the adaptive curve holds between %.2f and %.2f of their mean area; by mean "
                     "curvature samples lie up to %.0f times as densely as where they are sparsest."
                     % (len(curve.mass), curve.mass.min() * len(curve.mass), curve.mass.max() * len(curve.mass), rows[1][3]))


# ---- figures 7 and 8: the curve on a mesh

def flat_chart(figures, curve, marks, edges):
    """Picture of the largest chart in its plane, with its border."""
    flat = numpy.pad(curve.chart_uv, [(0, 0), (0, 1)])
    pairs = curve.chart_faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2) if edges else numpy.empty((0, 2), int)
    drawn = lambda ends: flat[ends].reshape(-1, 6)
    parts = [(drawn(pairs), EDGE, 0.6), (marks.get("lines", drawn(pairs[:0])), marks.get("line_colors"), 2),
             (drawn(curve.chart_border), (30, 34, 40), 1.6)]
    parts = [(segments, numpy.broadcast_to(color, (len(segments), 3)), width) for segments, color, width in parts
             if len(segments)]
    return picture(figures, vertices=flat, faces=curve.chart_faces, view=numpy.array([0, 0, 1.0]),
                   up=numpy.array([0, 1.0, 0]), lines=numpy.vstack([part[0] for part in parts]),
                   line_colors=numpy.vstack([part[1] for part in parts]).astype(numpy.uint8),
                   line_widths=numpy.concatenate([numpy.full(len(part[0]), part[2]) for part in parts]))


def in_plane(curve):
    """The curve over the largest chart."""
    here = curve.chart == curve.largest
    points = numpy.pad(curve.uv, [(0, 0), (0, 1)])[here]
    segments, first = joined(points, curve.chain[here])
    return lines(segments, look.map_color(0.75 * curve.along[here][first]), 1.5)


def draw_7(figures):
    leaves, most = 1024, 16384 if figures.quick else 65536
    run = ["--method", "conformal"]
    rows = []
    for model in subjects(figures, "squirrel"):
        with figures.attempt(model.name):
            staged = laboratory.stage(run=run, n=leaves, **model.arrays)
            curve = laboratory.mesh_curve(staged=staged, leaves=leaves, seed=figures.seed)
            samples = laboratory.samples(staged=staged, run=run, n=leaves, seed=figures.seed)
            radius = 0.25 * (staged.area / leaves) ** 0.5
            count = "%d leaves" % curve.leaves
            shown = [(with_edges(figures, model), "(a) mesh", "%d triangles" % len(model.faces)),
                     (flat_chart(figures, curve, {}, True), "(b) chart", "%d triangles" % len(curve.chart_faces)),
                     (flat_chart(figures, curve, in_plane(curve), False), "(c) curve in the plane", count),
                     (model_picture(figures, model, **along_curve(curve, 2.2)),
                      "(d) curve on the surface", count),
                     (model_picture(figures, model, **discs(samples.points, samples.normals, radius)),
                      "(e) samples", "%d samples" % leaves)]
            looks = view_of(figures, model)
            for letter, n in (("f", most // 4), ("g", most)):
                splats = laboratory.splats(run=run, n=n, seed=figures.seed, size=figures.size, views=looks["view"][None],
                                           up=looks["up"][None], **model.arrays)
                shown.append((splats.images.reshape(figures.size, figures.size, 3), "(%s) splats" % letter, "%d splats" % n))
            figures.panels("figure07_" + model.name, "%s: mesh, chart, curve, samples, and splats of more and more samples"
                           % model.name, shown, columns=4)
            rows.append([model.name, len(model.faces), len(curve.chart_faces), int(curve.leaves), int(curve.chain[-1]) + 1])
    figures.table("figure07_curves", "The curves", ["mesh", "triangles", "of the largest chart", "leaves", "chains"], rows)
    figures.measured("Splats are discs of four times the area that their samples stand for, blended where they overlap.")


def draw_8(figures):
    rows, said = [], []
    for model in subjects(figures, "bunny"):
        with figures.attempt(model.name):
            staged = laboratory.stage(run=["--method", "conformal"], n=1024, **model.arrays)
            uniform = laboratory.mesh_curve(staged=staged, level=6, steps=64, seed=figures.seed)
            adaptive = laboratory.mesh_curve(staged=staged, leaves=int(uniform.leaves), steps=64, seed=figures.seed)
            shown = []
            for name, curve in (("uniform", uniform), ("adaptive", adaptive)):
                # In units of the distance between leaves that share the area evenly.
                gaps = curve.gaps / (staged.area / curve.leaves) ** 0.5
                rows.append([model.name, name, int(curve.leaves), float(gaps.mean()), float(numpy.quantile(gaps, 0.99)),
                             float(gaps.max())])
                note = "mean distance to it %.2f, largest %.2f \u221a(area / leaf)" % tuple(rows[-1][3::2])
                shown += [(flat_chart(figures, curve, in_plane(curve), False), name + " curve in the plane",
                           "%d leaves" % curve.leaves),
                          (model_picture(figures, model, **along_curve(curve, 2.2)), name + " curve on the surface", note)]
            figures.panels("figure08_" + model.name, "%s: curves of equal numbers of leaves" % model.name, shown, columns=2)
            said.append("%s: from places of the surface to the curve %.2f on the mean and %.2f at most for the uniform one, "
                        "%.2f and %.2f for the adaptive one" % (model.name, *rows[-2][3::2], *rows[-1][3::2]))
    figures.table("figure08_gaps", "Distances from places of the surface to the curve, in units of the root of the area for "
                  "each leaf", ["mesh", "curve", "leaves", "mean", "99 %", "largest"], rows)
    figures.measured("; ".join(said) + " (in roots of the area for each leaf).")
