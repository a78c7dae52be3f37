"""Figures 4 (meshes) and 21, and meshes of samples beside simplified ones."""
import os
import tempfile

import numpy

from .. import laboratory, read_mesh
from . import look
from .errors import ErrorSeries, draw_errors, survey_counts
from .models import Model, unit_sphere
from .surfaces import model_picture, with_edges


# ---- figure 4

# Method, options of the stages, and of the samples beside these.
_MESH_METHODS = [("random", ["--method", "conformal"], ["--sequence", "random"]),
                 ("conformal", ["--method", "conformal"], []), ("direct", ["--method", "direct"], []),
                 ("curve vertices, first hit", ["--method", "conformal", "--locate", "first-hit"], [])]


def draw_4_mesh(figures):
    most, runs = 1536 if figures.quick else 24576, 3
    shapes = dict(boxes=200, rings=32) if figures.quick else dict(boxes=1000, rings=256)
    counts, said = survey_counts(most, 32), []
    for model in figures.models:
        with figures.attempt(model.name):
            series = {"boxes": [], "rings": []}
            for name, run, more in _MESH_METHODS:
                figures.note("%s: %s" % (model.name, name))
                staged = laboratory.stage(run=run, n=most, **model.arrays)
                sets = [laboratory.samples(staged=staged, run=run + more, n=count, seed=figures.seed + k)
                        for count in counts for k in range(runs)]
                found = laboratory.set_errors(
                    staged=staged, points=numpy.vstack([s.points for s in sets]), seed=figures.seed,
                    triangle=numpy.concatenate([s.triangle for s in sets]),
                    counts=numpy.array([len(s.points) for s in sets], numpy.uint32), **shapes)
                for measure in series:
                    series[measure].append(ErrorSeries(name))
                    for count, error in zip(numpy.repeat(counts, runs), getattr(found, measure)):
                        series[measure][-1].add(int(count), float(error))
            stem = "figure04_mesh_" + model.name
            draw_errors(figures, stem + "_boxes", model.name + ": rotated boxes", series["boxes"], "RMS error of the share",
                        "%d boxes with exactly clipped areas, means of %d runs" % (shapes["boxes"], runs), least=32)
            draw_errors(figures, stem + "_rings", model.name + ": rings of triangles", series["rings"], "discrepancy",
                        "Patches that grow ring by ring from %d vertices, means of %d runs" % (shapes["rings"], runs),
                        least=32)
            said.append("%s: conformal %.2f in boxes and %.2f in rings (random %.2f and %.2f)" % (
                model.name, *(series[m][k].slope(32)[0] for k in (1, 0) for m in ("boxes", "rings"))))
    if said:
        figures.measured("Slopes from 32 points: " + "; ".join(said) + ". Rings have borders as ragged as the triangles are "
                         "large, which flattens their slopes on coarse meshes.")


# ---- figure 21

def percent_of(found, name):
    return 100 * getattr(found, name) / found.diagonal


def distances(model, other, figures, **options):
    """laboratory.mesh_distances of two models; its numbers do not depend on where they are."""
    center = model.vertices.mean(axis=0)
    return laboratory.mesh_distances(vertices=model.vertices - center, faces=model.faces, seed=figures.seed,
                                     other_vertices=other.vertices - center, other_faces=other.faces, **options)


def draw_21(figures):
    shown = []
    chosen = [model for prefix in ("bunny", "maxplanck", "fandisk", "hand")
              for model in [m for m in figures.models if m.name.lower().startswith(prefix)][:1]] or figures.models
    for model in chosen:
        with figures.attempt(model.name):
            shown.append((model_picture(figures, model, crease=0.95), model.name, "%d triangles" % len(model.faces)))
    figures.panels("figure21_meshes", "The meshes", shown, columns=min(len(shown), 4))
    fine, rows = unit_sphere(256 if figures.quick else 512), []
    for rings in (8, 16, 32, 64):
        coarse = unit_sphere(rings)
        found = distances(coarse, fine, figures, samples=20000 if figures.quick else 200000)
        rows.append([len(coarse.faces), percent_of(found, "mean"), percent_of(found, "rms"),
                     max(percent_of(found, "largest"), percent_of(found, "largest_back"))])
    columns = ["triangles", "mean", "RMS", "largest"]
    figures.table("figure21_mesh_distance", "Distance from a triangulated sphere to a fine one, % of the diagonal; the "
                  "largest of both directions", columns, rows)
    values = numpy.array(rows)

    def draw(axes):
        for k in (1, 2, 3):
            axes.loglog(values[:, 0], values[:, k], label=columns[k], marker=look.MARKERS[k - 1], markersize=4)
        axes.set(xlabel="triangles", ylabel="distance, % of the diagonal", title="Triangulated sphere against a fine one")
        axes.legend()

    figures.plot("figure21_mesh_distance", "Sampled distances with exact nearest points", draw, height=3.6)
    slopes = [numpy.polyfit(numpy.log(values[:, 0]), numpy.log(values[:, k]), 1)[0] for k in (1, 2, 3)]
    figures.measured("Distances between a surface and its approximation fall as triangles to the power %.2f (mean), "
                     "%.2f (RMS) and %.2f (largest)." % tuple(slopes))


# ---- metro

_WAYS = [("samples", []), ("fitted", ["--fit"]), ("fitted by curvature", ["--fit", "--density", "mean"])]
_SIZES = [("5 %", 0.05, 0), ("10 %", 0.1, 0), ("25 %", 0.25, 0), ("50 %", 0.5, 0), ("300 vertices", 0, 300)]


def min_angles(model):
    """(T,) degrees."""
    corner = model.vertices[model.faces]
    angles = []
    for k in range(3):
        u, v = corner[:, (k + 1) % 3] - corner[:, k], corner[:, (k + 2) % 3] - corner[:, k]
        angles.append(numpy.arctan2(numpy.linalg.norm(numpy.cross(u, v), axis=1), (u * v).sum(axis=1)))
    return numpy.degrees(numpy.min(angles, axis=0))


def remeshed(figures, model, n, options):
    """The mesh of n samples that the program makes."""
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, model.name + ".off")
        with open(path, "w") as file:
            file.write("OFF\n%d %d 0\n" % (len(model.vertices), len(model.faces)))
            numpy.savetxt(file, model.vertices, "%.17g")
            numpy.savetxt(file, numpy.pad(model.faces, [(0, 0), (1, 0)], constant_values=3), "%d")
        figures.run_program("remesh", path, "-o", os.path.join(folder, "made"), "-n", n, "--seed", figures.seed,
                            "--progress", "plain", *options)
        made = read_mesh(os.path.join(folder, "made", model.name + ".ply"))
    return Model(model.name, made.vertices, made.faces)


def draw_metro(figures):
    columns = ["mesh", "size", "method", "vertices", "faces", "mean", "mean back", "rms", "rms back", "largest",
               "largest back", "median angle", "1 % angle", "crossings"]
    said = []
    for model in figures.models:
        with figures.attempt(model.name):
            rows, shown = [], [(with_edges(figures, model), model.name, "%d triangles" % len(model.faces))]
            for size, share, n in _SIZES:
                vertices = 0
                for name, options in _WAYS + [("quadric edge collapse", None)]:
                    if options is None:
                        found = laboratory.simplified(target=vertices, **model.arrays)
                        made = Model(model.name, found.vertices, found.faces)
                    else:
                        made = remeshed(figures, model, n or max(4, round(share * len(model.faces) / 2)), options)
                    vertices = vertices or len(made.vertices)
                    d = distances(model, made, figures, samples=10000 if figures.quick else 0)
                    angles = numpy.sort(min_angles(made))
                    measures = [percent_of(d, key + way) for key in ("mean", "rms", "largest") for way in ("", "_back")]
                    rows.append([model.name, size, name, len(made.vertices), len(made.faces), *measures,
                                 angles[len(angles) // 2], angles[len(angles) // 100], int(d.crossings)])
                    if n:
                        shown.append((with_edges(figures, made, crease=2), name, "%d vertices, mean distance %.3f %%" % (
                            len(made.vertices), (rows[-1][5] + rows[-1][6]) / 2)))
                figures.note("%s, %s: %d vertices" % (model.name, size, vertices))
            figures.table("metro_" + model.name, "Distances from the surface to the mesh and back, % of the diagonal; least "
                          "angles of the triangles, degrees; pairs of triangles that cross", columns, rows)
            figures.panels("metro_%s_meshes" % model.name, model.name + ": the model, meshes of 300 samples, and the "
                           "simplified one", shown, columns=3)

            def draw(axes):
                for k, name in enumerate([name for name, _ in _WAYS] + ["quadric edge collapse"]):
                    of = numpy.array(sorted((row[3], (row[5] + row[6]) / 2) for row in rows if row[2] == name))
                    axes.loglog(of[:, 0], of[:, 1], label=name, marker=look.MARKERS[k], markersize=4)
                axes.set(xlabel="vertices", ylabel="mean distance, % of the diagonal", title=model.name)
                axes.legend()

            figures.plot("metro_%s_mean" % model.name, "Mean distances, both ways", draw, height=3.6)
            quarter = {row[2]: (row[5] + row[6]) / 2 for row in rows if row[1] == "25 %"}
            said.append("%s %.4f %% (fitted %.4f %%, simplified %.4f %%)" % (
                model.name, quarter["samples"], quarter["fitted"], quarter["quadric edge collapse"]))
    if said:
        figures.measured("Mean distance with 25 % of the triangles: " + "; ".join(said) + ".")
