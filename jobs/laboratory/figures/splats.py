"""Figures 9 to 11 and 17: samples as splats, as vertices of meshes, chosen for a view, and along a tensor."""
import numpy

from .. import laboratory
from . import look
from .meshes import distances, percent_of, remeshed
from .models import subjects, unit_sphere, view_of
from .surfaces import discs, model_picture, picture, with_edges

SMALL = 0.7  # the area of small splats over that of the surface that their samples stand for
COVERS = (4, 5, 6, 7, 8)
CLOSED_SHARE = 1e-5  # of the surface: a pixel of a picture


def splats(figures, model, run, n, cover, views=None, staged=None, **options):
    """Pictures (K, size, size, 3), None where options say `measured`, and the share of the surface that each leaves open,
    from the model's view or from those given. staged: the model with its charts, of another cover."""
    looks, size = view_of(figures, model), options.setdefault("size", figures.size)
    views = numpy.array([looks["view"]] if views is None else views)
    found = laboratory.splats(run=run, n=n, seed=figures.seed, views=views, up=looks["up"][None], cover=float(cover),
                              staged=staged, **({} if staged else model.arrays), **options)
    return None if options.get("measured") else found.images.reshape(-1, size, size, 3), found.white


def closed_splats(figures, model, run, n):
    """The picture with the smallest of COVERS that closes the surface, else with the largest; and it in words."""
    staged = laboratory.stage(run=run, n=n, seed=figures.seed, **model.arrays)
    for cover in COVERS:
        images, white = splats(figures, model, run, n, cover, staged=staged)
        if white[0] <= CLOSED_SHARE:
            return images[0], "cover %g" % cover
    return images[0], "cover %g, %.3f %% open" % (cover, 100 * white[0])


def skin(model):
    return dict(face_colors=numpy.repeat(numpy.array([look.SKIN], numpy.uint8), len(model.faces), axis=0))


def turned(direction, axis, angle):
    """A direction turned about an axis of length 1, by Rodrigues' formula."""
    along = (direction @ axis) * axis
    return along + numpy.cos(angle) * (direction - along) + numpy.sin(angle) * numpy.cross(axis, direction)


def trimmed(shown):
    """(pixels, title, note) without the rows and columns that are white in all of them, but for a margin."""
    inked = numpy.any([(pixels < 255).any(axis=2) for pixels, _, _ in shown], axis=0)
    if not inked.any():
        return shown
    margin = len(inked) // 32
    rows, columns = (slice(max(0, at[0] - margin), at[-1] + 1 + margin) for at in map(numpy.unique, inked.nonzero()))
    return [(pixels[rows, columns], title, note) for pixels, title, note in shown]


# ---- figure 9

def draw_9(figures):
    n, few, said = 5000 if figures.quick else 40000, 2000 if figures.quick else 8000, []
    for model in subjects(figures, "chineselion"):
        with figures.attempt(model.name):
            shown, covers = [[], []], []
            for title, run in (("uniform", []), ("by mean curvature", ["--density", "mean"])):
                run = ["--method", "conformal", "--sequence", "spaced"] + run
                image, cover = closed_splats(figures, model, run, n)
                shown[0].append((image, title, "%d splats, %s" % (n, cover)))
                shown[1].append((splats(figures, model, run, few, SMALL)[0][0], title, "%d splats, cover %g" % (few, SMALL)))
                covers.append(cover)
            shown[0].append((model_picture(figures, model, **skin(model)), "rendered",
                             "%d triangles" % len(model.faces)))
            shown[1].append((with_edges(figures, model), "the mesh", "%d vertices" % len(model.vertices)))
            figures.panels("figure09_" + model.name, model.name + ": splatted with uniform samples and with samples by mean "
                           "curvature, and rendered from its triangles", trimmed(shown[0] + shown[1]), columns=3)
            said.append("%s with %s and %s" % (model.name, *covers))
    if said:
        figures.measured("%d splats at samples spaced along the curve: %s. Cover is the area of a splat over that of the "
                         "surface which its sample stands for, the smallest of %s that leaves at most %g %% of the surface "
                         "open. What the mesh hides has no splat." % (
                             n, "; ".join(said), ", ".join("%g" % cover for cover in COVERS), 100 * CLOSED_SHARE))


# ---- figure 10

def draw_10(figures):
    columns, rows, share = ["mesh", "density", "method", "vertices", "faces", "mean %", "mean back %", "largest %"], [], 0.25
    for model in subjects(figures, "igea"):
        with figures.attempt(model.name):
            n, shown, found = max(4, round(share * len(model.faces) / 2)), [], []
            for title, density in (("remeshed uniformly", []), ("remeshed by mean curvature", ["--density", "mean"])):
                for method, fit in (("plain", []), ("fitted", ["--fit"])):
                    made = remeshed(figures, model, n, density + fit)
                    d = distances(model, made, figures, samples=10000 if figures.quick else 0)
                    rows.append([model.name, "mean curvature" if density else "uniform", method, len(made.vertices),
                                 len(made.faces)] + [percent_of(d, key) for key in ("mean", "mean_back", "largest")])
                    figures.note("%s, %s, %s: %.4f %%" % (model.name, title, method, rows[-1][5]))
                shown.append((with_edges(figures, made, crease=2.0), title, "%d vertices, mean distance %.4f %%"
                              % (len(made.vertices), (rows[-1][5] + rows[-1][6]) / 2)))
                # Each triangle in one shade: as it is.
                found.append((model_picture(figures, made, crease=2.0, **skin(made)), title, "without edges"))
            shown.append((model_picture(figures, model, **skin(model)), "rendered",
                          "%d vertices" % len(model.vertices)))
            found.append((model_picture(figures, model, crease=2.0, **skin(model)), "the model",
                          "each triangle in one shade, as beside"))
            figures.panels("figure10_" + model.name, model.name + ": meshes of a quarter of the triangles, fitted, and the "
                           "model", trimmed(shown + found), columns=3)
    figures.table("figure10_distances", "Mean distance from the model to the mesh and back, and the largest, % of the "
                  "diagonal: vertices where samples lie (plain), and moved towards the surface (fitted)",
                  columns, rows)
    if rows:
        means = {(row[0], row[1], row[2]): (row[5] + row[6]) / 2 for row in rows}
        figures.measured("Mean distance with 25 %% of the triangles, both ways: %s." % "; ".join(
            "%s, %s density, %s, %.4f %%" % (*key, mean) for key, mean in means.items()))


# ---- figure 11

def draw_11(figures):
    some, most = (4000, 10000) if figures.quick else (20000, 150000)
    rows, steps = [], 30 if figures.quick else 180
    for model in [unit_sphere(64 if figures.quick else 128)] + subjects(figures, "bunny"):
        with figures.attempt(model.name):
            towards, up = view_of(figures, model).values()
            run = dict(run=["--method", "auto"], seed=figures.seed, **model.arrays)
            views = lambda step, count: numpy.array([turned(towards, up, numpy.radians(step * k)) for k in range(count)])
            kept = laboratory.view_detail(n=some, views=towards[None], **run).kept
            samples = laboratory.samples(n=some, **run)
            marks = discs(samples.points[kept], samples.normals[kept],
                          2.6 * numpy.ptp(model.vertices, axis=0).max() / figures.size)
            shown = [(picture(figures, **model.arrays, view=view, up=up, **marks),
                      "turned by %d°" % (45 * k) if k else "the view", "" if k else "%d of %d samples" % (len(kept), some))
                     for k, view in enumerate(views(45, 5))]
            turn = laboratory.view_detail(n=most, views=views(2, steps + 1), up=up[None], size=figures.size, cover=8.0,
                                          **run)
            shown.append((turn.image.reshape(figures.size, figures.size, 3), "splats for the view",
                          "%d of %d" % (turn.counts[0], most)))
            figures.panels("figure11_" + model.name, "%s: samples for one view, seen from it and after turns; and as splats"
                           % model.name, trimmed(shown), columns=3)
            rows.append([model.name, most, int(turn.counts.min()), int(turn.counts.max()), 100 * turn.behind.mean(),
                         100 * numpy.median(turn.stays), 100 * turn.stays.min()])
    figures.table("figure11_turning", "A turn in steps of two degrees: samples of a view, the share of them that faces "
                  "away, and the share that the next view keeps (median and least)",
                  ["mesh", "samples", "fewest", "most", "behind %", "stay %", "worst %"], rows)
    if rows:
        figures.measured("Every view keeps the samples of one progressive set whose place in it lies below their weight, "
                         "0.1 + 0.9 (1 - |n.v|)^4 and on the back of a closed model a margin, so that none moves when the "
                         "view does; of a view the next keeps %s." % ", ".join(
                             "%.1f %% (%s)" % (row[5], row[0]) for row in rows))


# ---- figure 17

WHITE_VIEWS = [tuple(laboratory.default_view(up="y").view), (-1, 0.3, 0.2), (0.3, 0.2, -1), (1, 0.5, -0.2), (0.2, 1, 0.3), (-0.3, -0.9, 0.5)]
ISOTROPIC, ANISOTROPIC = ["--method", "conformal"], ["--method", "anisotropic"]
BALANCED = ["--method", "auto"], ANISOTROPIC + ["--curve", "balanced"]
CLOSED, OPEN, BEYOND = 5, 0.0005, 0.02  # cover, and what splats that close a surface may leave and exceed


def widest_view(figures, model):
    """Of the directions about the up axis, every 15 degrees and at most 90 from the default view, that in which the model is
    widest; the view that the user chose, if any."""
    towards, up = view_of(figures, model).values()
    views = [turned(towards, up, numpy.radians(angle)) for angle in ([0] if figures.view_given else range(-90, 90, 15))]
    width = lambda view: numpy.ptp(model.vertices @ numpy.cross(up, view)) / numpy.linalg.norm(numpy.cross(up, view))
    return max(views, key=width)


def faults(figures, model, run, n, view):
    """The picture of so many splats, and the shares of the surface that they leave open and that they paint beside it."""
    images, white = splats(figures, model, run, n, CLOSED, [view])
    rendered = picture(figures, **model.arrays, view=view, up=view_of(figures, model)["up"])
    drawn, surface = ((image < 255).any(axis=2) for image in (images[0], rendered))
    return images[0], white[0], (drawn & ~surface).sum() / max(1, surface.sum())


def closes(found):
    return all(white <= OPEN and beyond <= BEYOND for _, white, beyond in found)


def closing_splats(figures, model, view, most):
    """The smallest of 1,000, 2,000 ... splats, at most `most`, of which both kinds close the surface; and faults of both."""
    n = 1000
    while True:
        found = [faults(figures, model, run, n, view) for run in BALANCED]
        if 2 * n > most or closes(found):
            return n, found
        n *= 2


def draw_17(figures):
    rows, many, few = [], 2000 if figures.quick else 20000, 1000 if figures.quick else 4000
    kinds, said = ("isotropic", "anisotropic"), []
    for model in subjects(figures, "dragon"):
        with figures.attempt(model.name):
            white = lambda run, **shape: 100 * splats(figures, model, run, many, 2, WHITE_VIEWS, measured=True,
                                                      size=200 if figures.quick else 512, **shape)[1].mean()
            for order, (even, along) in (("Hilbert", (ISOTROPIC, ANISOTROPIC)), ("balanced", BALANCED)):
                rows.append([model.name, order, many, white(even), white(along), white(along, round=True)])
            view = widest_view(figures, model)
            n, closed = closing_splats(figures, model, view, 8000 if figures.quick else 256000)
            figures.note("%s: %d splats" % (model.name, n))
            shown = [(splats(figures, model, run, few, 0.8, [view])[0][0], kind, "%d splats, cover 0.8" % few)
                     for kind, run in zip(kinds, BALANCED)]
            shown += [(image, kind, "%d splats, cover %g, %.3f %% open" % (n, CLOSED, 100 * white))
                      for kind, (image, white, _) in zip(kinds, closed)]
            figures.panels("figure17_" + model.name, model.name + ": discs, and ellipses along the curvature, of the same "
                           "number and total area; few and small, and as many as close the surface", trimmed(shown), 2)
            said.append("%s %d%s" % (model.name, n, "" if closes(closed) else " (the most tried, which do not)"))
    figures.table("figure17_white_space", "White space: pixels of the visible surface that no splat covers, mean of six "
                  "views; the total area of the splats is twice that of the surface",
                  ["mesh", "order", "splats", "isotropic %", "anisotropic %", "discs at anisotropic samples %"], rows)
    if said:
        figures.measured("White space is smaller with anisotropic splats in %d of %d rows. The survey states no number of "
                         "splats; ours is the smallest of 1,000, 2,000, 4,000 ... of which both kinds leave at most %g %% "
                         "of the surface open and paint at most %g %% beside it: %s." % (
                             sum(row[4] < row[3] for row in rows), len(rows), 100 * OPEN, 100 * BEYOND, "; ".join(said)))
        figures.text("The view", "Without --view the direction about the up axis in which the model is widest.")
