"""Figures 18 to 20: anisotropic samples as brush strokes."""
import numpy

from .. import laboratory
from .models import Model, grid_faces, subjects, view_of

# Title, medium, three tones.
MEDIA = [("watercolor", "watercolor", False), ("crayon", "crayon", False), ("pencil", "pencil", False),
         ("pencil, three tones", "pencil", True), ("ink", "ink", False), ("ink, three tones", "ink", True),
         ("acrylic", "acrylic", False), ("pastel", "pastel", False), ("oil", "oil", False)]
# Directions that vary less than those of the surface: neighboring strokes go together.
RUN = ["--method", "anisotropic", "--tensor-smoothing", "16"]


def tube(name, around, across, radius, curve):
    """A tube about a closed curve of an angle that is never along y, which then takes the place of z."""
    angle = 2 * numpy.pi * numpy.arange(around) / around
    along = curve(angle + 1e-4) - curve(angle - 1e-4)
    side = numpy.cross(along, [0, 1, 0])
    above = numpy.cross(side, along)
    unit = lambda v: (v / numpy.linalg.norm(v, axis=1, keepdims=True))[:, None]
    turn = (2 * numpy.pi * numpy.arange(across) / across)[None, :, None]
    points = curve(angle)[:, None] + radius * (numpy.cos(turn) * unit(side) + numpy.sin(turn) * unit(above))
    return Model(name, points.reshape(-1, 3)[:, [0, 2, 1]], grid_faces(around, across, True)[:, ::-1])


def knot(detail):
    return tube("knot", 200 * detail, 24 * detail, 0.42, lambda t: numpy.stack(
        [numpy.sin(t) + 2 * numpy.sin(2 * t), -0.9 * numpy.sin(3 * t), numpy.cos(t) - 2 * numpy.cos(2 * t)], axis=1))


def double_torus(side):
    """Of genus 2: the surface of a board of 5 x 3 cubes without two, each of side^3 cells, made smooth."""
    solid = numpy.ones((5 * side, 3 * side, side), bool)
    solid[side:2 * side, side:2 * side] = solid[3 * side:4 * side, side:2 * side] = False
    solid = numpy.pad(solid, 1)
    corners = []
    for axis in range(3):
        along, other = numpy.eye(3, dtype=int)[[(axis + 1) % 3, (axis + 2) % 3]]
        for ahead in (1, 0):
            cells = numpy.argwhere(solid & ~numpy.roll(solid, -1 if ahead else 1, axis))
            cells[:, axis] += ahead
            quads = cells[:, None] + numpy.array([0 * along, along, along + other, other])
            corners.append(quads if ahead else quads[:, ::-1])
    points, quads = numpy.unique(numpy.vstack(corners).reshape(-1, 3), axis=0, return_inverse=True)
    quads = quads.reshape(-1, 4)
    ends, points = numpy.sort(quads[:, [0, 1, 1, 2, 2, 3, 3, 0]].reshape(-1, 2), axis=1), points.astype(float)
    one, two = numpy.unique(ends, axis=0).T
    degree = numpy.bincount(numpy.concatenate([one, two]))[:, None]
    for _ in range(side * side):  # vertices to the mean of their neighbors
        mean = numpy.zeros_like(points)
        numpy.add.at(mean, one, points[two])
        numpy.add.at(mean, two, points[one])
        points = 0.5 * (points + mean / degree)
    return Model("double-torus", points / side, quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3))


def draw_subject(figures, number, model, n):
    """All media, and the middle of each; then random beside low-discrepancy samples, a quarter as many: gaps show."""
    n, few = (n // 4, n // 16) if figures.quick else (n, n // 4)
    looks, size = view_of(figures, model), figures.size * 27 // 20  # 1,080 of 800: strokes need more than splats
    staged = laboratory.stage(run=RUN, n=n, **model.arrays)
    drawn = lambda n, medium, tones, **options: laboratory.strokes(
        staged=staged, n=n, seed=figures.seed, medium=medium, tones=tones, size=size, views=looks["view"][None],
        up=looks["up"][None], **options)
    stem = "figure%s_%s" % (number, model.name)
    pictures = [(title, drawn(n, medium, tones, run=RUN).image.reshape(size, size, 3)) for title, medium, tones in MEDIA]
    figures.panels(stem + "_media", "%s, %d samples, in all media" % (model.name, n),
                   [(pixels, title, "") for title, pixels in pictures], columns=3)
    part = slice(size // 4, size // 4 + size // 2)
    figures.panels(stem + "_crops", "The middle of each, a pixel of the picture for a pixel",
                   [(pixels[part, part], title, "") for title, pixels in pictures], columns=3)
    figures.note("%s: all media" % model.name)
    shown, rows = [], []
    for title, medium, tones in (MEDIA[k] for k in (1, 4, 6)):
        for name, sequence in (("random", "random"), ("low discrepancy", "shifted")):
            made = drawn(few, medium, tones, run=RUN + ["--sequence", sequence], coverage=True)
            rows.append([name, title, 100 * made.bare, made.spread])
            # Ink leaves the light bare on purpose.
            shown.append((made.image.reshape(size, size, 3), "%s, %s samples" % (title, name),
                          "cover varies by %.0f %% of its mean" % (100 * made.spread) if medium == "ink" else
                          "%.1f %% of the model without a stroke of the body" % (100 * made.bare)))
    figures.panels(stem + "_samples", "%d strokes from random and from low-discrepancy samples" % few, shown, columns=2)
    figures.table(stem + "_samples", "Pixels of the model that no stroke of the body covers, and standard deviation over "
                  "mean of how often one is covered", ["samples", "medium", "bare %", "spread of cover"], rows)
    return "%s %.1f and %.1f %% in %s" % (model.name, rows[0][2], rows[1][2], rows[0][1])


def draw_all(figures, number, models, n):
    said = []
    for model in models:
        with figures.attempt(model.name):
            said.append(draw_subject(figures, number, model, n))
    if said:
        figures.measured("Random and low-discrepancy samples leave bare of strokes: %s." % "; ".join(said))


def named(figures, name):
    return [model for model in figures.models if model.name.lower().startswith(name)]


def draw_18(figures):
    draw_all(figures, "18", named(figures, "knot") or [knot(1 if figures.quick else 2)], 30000)


def draw_19(figures):
    given = named(figures, "eight_11k") or named(figures, "eight")
    draw_all(figures, "19", given or [double_torus(6 if figures.quick else 12)], 20000)
    if not given:
        figures.text("The model", "A double torus made here: no model called eight was given.")


def draw_20(figures):
    draw_all(figures, "20", subjects(figures, "venus"), 35000)
