"""Figure 16: differences between samples in units of their local spacing, and the spectra that they make."""
from typing import Callable, NamedTuple

import numpy

from .. import laboratory
from . import look, models, plane

RANGE, CELLS = 4.0, 128             # of maps of differences, in spacings
CELL = 2 * RANGE / CELLS
FREQUENCIES, STEP = 2.5, 0.05       # of spectra, times the spacing


class Subject(NamedTuple):
    name: str
    n: int
    draw: Callable  # draw(sequence, seed): samples with points, normals, density, area and measure
    show: Callable  # show(axes): a set of them
    frames: dict    # the axis of maps of differences; empty: any

    def pairs(self, sequence, seed):
        """The map of differences of one set, over the number of its points."""
        samples = self.draw(sequence, seed)
        # Beyond 8 times the mean, each pair of a nearly empty region would be neighbors.
        spacing = numpy.minimum((samples.measure / (self.n * numpy.maximum(samples.density, 1e-30))) ** 0.5,
                                8 * (samples.area / self.n) ** 0.5)
        return laboratory.differences(points=samples.points, normals=samples.normals, spacing=spacing, range=RANGE,
                                      cells=CELLS, seed=seed, **self.frames).pairs


def planar_subject(name, expression, n, figures):
    def draw(sequence, seed):
        return laboratory.surface_samples(surface="plane", density=expression, n=n, sequence=sequence, seed=seed)

    def show(axes):
        plane.square_axes(axes, "")
        plane.dots(axes, draw("shifted", figures.seed).uv, 40 / n ** 0.5)

    return Subject(name, n, draw, show, {"frames": numpy.tile([1.0, 0, 0], (n, 1))})


def mesh_subject(name, model, n, density, figures):
    staged = laboratory.stage(run=["--method", "conformal", "--density", density], n=n, **model.arrays)

    def draw(sequence, seed):
        return laboratory.samples(staged=staged, n=n, seed=seed,
                                  run=["--method", "conformal", "--density", density, "--sequence", sequence])

    def show(axes):
        size = max(figures.size, 600)
        points = draw("shifted", figures.seed).points
        axes.imshow(laboratory.picture(
            size=size, margin=0.01, dots=points, dot_colors=numpy.zeros((1, 3), numpy.uint8),
            dot_radii=numpy.array([size / 230]), face_colors=numpy.full(model.faces.shape, 250, numpy.uint8),
            **models.view_of(figures, model), **model.arrays).image.reshape(size, size, 3))
        axes.set_axis_off()

    return Subject(name, n, draw, show, {})


def spectrum(ratio):
    """1 + the cosine transform of ratio - 1 under a window, over frequencies times the spacing; white noise is 1. The
    blur of the maps (a Gaussian of one cell) is taken off."""
    q = (numpy.arange(CELLS) + 0.5) * CELL - RANGE
    f = numpy.arange(-FREQUENCIES, FREQUENCIES + STEP / 2, STEP)
    radius = numpy.hypot(q[:, None], q)
    window = numpy.cos(numpy.pi / 2 * numpy.clip(2 * radius / RANGE - 1, 0, 1)) ** 2
    h = (ratio - 1) * window * CELL * CELL
    waves = numpy.exp(2j * numpy.pi * f[:, None] * q)
    blur = numpy.exp(-2 * (numpy.pi * CELL) ** 2 * (f[:, None] ** 2 + f ** 2))
    # Not @, whose sums depend on the number of threads.
    return 1 + numpy.einsum("fj,gj->fg", numpy.einsum("fi,ij->fj", waves, h), waves).real / blur


def plain(subject):
    return subject.name.replace("\n", " ")


def rings(image, cell):
    """Radius, mean and anisotropy of a map."""
    found = laboratory.radial(map=image.ravel(), width=2)
    return found.radius * cell, found.mean, found.anisotropy


def show_map(axes, image, half):
    axes.imshow(image, cmap="gray", vmin=0, vmax=2, origin="lower", extent=(-half, half, -half, half))
    axes.grid(False)


def analyse(figures, subject):
    """(ratio, spectrum, control): maps of differences of stratified sets over independent ones of the same density, and
    of further independent sets over these."""
    figures.note(plain(subject))
    sets = 2 if figures.quick else 10
    over = lambda pairs: numpy.divide(pairs, reference, out=numpy.ones_like(pairs), where=reference > 0)
    mean = lambda sequence, seeds: sum(subject.pairs(sequence, figures.seed + k) for k in seeds) / len(seeds)
    reference = mean("random", range(4 * sets))
    ratio = over(mean("shifted", range(sets)))
    return ratio, spectrum(ratio), over(mean("random", range(4 * sets, 5 * sets)))


def draw_subjects(figures, stem, subjects):
    maps = [analyse(figures, subject) for subject in subjects]
    profiles = [(rings(ratio, CELL), rings(power, STEP), rings(control, CELL)) for ratio, power, control in maps]
    kinds = ("differences", "spectrum", "independent")
    rows = [(plain(subject), kind, *values) for subject, profile in zip(subjects, profiles)
            for kind, lines in zip(kinds, profile) for values in zip(*lines) if values[0] <= RANGE]
    figures.table(stem, "Radial means and anisotropy", ["samples", "of", "distance / spacing or frequency x spacing", "mean",
                                                        "anisotropy dB"], rows, shown=False)

    def draw(axes):
        for row, (subject, (ratio, power, _), profile) in enumerate(zip(subjects, maps, profiles)):
            subject.show(axes[row, 0])
            for ax, image, half in ((axes[row, 1], ratio, RANGE), (axes[row, 2], power, FREQUENCIES)):
                show_map(ax, image, half)
            for kind, (radius, mean, anisotropy), color, style in zip(kinds, profile, look.PALETTE, ("-", "--", ":")):
                if kind != "independent":
                    axes[row, 3].plot(radius, mean, style, color=color, label=kind)
                if kind != "spectrum":
                    axes[row, 4].plot(radius, anisotropy, style, color=color, label=kind)
            axes[row, 3].axhline(1, color=look.NEUTRAL, linewidth=0.7)
            axes[row, 3].set(xlim=(0, 2.5), ylim=(0, 1.25))
            axes[row, 4].set(xlim=(0, 2.5), ylim=(-45, 5))
            axes[row, 0].set_title(subject.name)
        for ax, title in zip(axes[0, 1:], ("Differences", "Spectrum", "Radial mean", "Anisotropy, dB")):
            ax.set_title(title)
        labels = ("difference / spacing", "frequency x spacing", "distance / spacing,\nfrequency x spacing",
                  "distance / spacing")
        for ax, label in zip(axes[-1, 1:], labels):
            ax.set_xlabel(label)
        axes[0, 3].legend(loc="lower right", fontsize=8)
        axes[0, 4].legend(loc="upper right", fontsize=8)

    figures.plot(stem, "Differences between samples over those of independent samples of the same density, in units of the "
                 "local spacing, and their cosine transform: white noise is 1, black 0, white 2", draw, 11.5,
                 2.35 * len(subjects), nrows=len(subjects), ncols=5, squeeze=False)
    words = []
    for subject, (differences, _, control) in zip(subjects, profiles):
        band = lambda lines, low, high, k: lines[k][(lines[0] >= low) & (lines[0] < high)].mean()
        words.append("%s: %.2f, %.2f, %+.1f dB" % (
            plain(subject), band(differences, 0, 0.3, 1), band(differences, 1.5, 2.5, 1),
            band(differences, 1, 2.5, 2) - band(control, 1, 2.5, 2)))
    return words


def draw_16(figures):
    flat = [planar_subject("Gaussian blob,\n2,500", "blob", 2500, figures),
            planar_subject("Balzer's function,\n10,000", "balzer", 10000, figures)]
    words = []
    for model in models.subjects(figures, "bunny"):
        with figures.attempt(model.name):
            subjects = [] if words else flat
            subjects = subjects + [mesh_subject("%s, 3,000\n%s" % (model.name, title), model, 3000, density, figures)
                                   for density, title in (("uniform", "uniform"), ("mean", "by mean curvature"))]
            words += draw_subjects(figures, "figure16_" + model.name, subjects)
    draw_uniform(figures)
    figures.measured("share of pairs nearer than 0.3 spacings and from 1.5 to 2.5, where independent samples have 1, and "
                     "anisotropy above that of independent samples: %s." % "; ".join(words))


def draw_uniform(figures):
    """Periodograms of uniform sets in the square."""
    n, sets = 1024, 3 if figures.quick else 10
    methods = "random jittered hilbert-stratified hilbert-shifted hilbert-regular poisson-disk".split()
    power = {}
    for method in methods:
        made = [laboratory.points_in_square(method=method, n=n, seed=figures.seed + k) for k in range(sets)]
        made = made[:1] if made[0].deterministic else made
        power[method] = sum(laboratory.power_spectrum(points=m.points, radius=80).power for m in made) / len(made)
        power[method][80, 80] = 0  # the number of points
    lines = {method: laboratory.radial(map=image.ravel(), first=0.5) for method, image in power.items()}
    figures.table("figure16_power", "Power spectra", ["method", "frequency / root of n", "power", "anisotropy dB"], [
        (m, r / n ** 0.5, p, a) for m, l in lines.items() for r, p, a in zip(l.radius, l.mean, l.anisotropy)], shown=False)

    def draw(axes):
        for ax, method in zip(axes[:, :3].flat, methods):
            show_map(ax, power[method], 80.5 / n ** 0.5)
            ax.set(title=method.capitalize(), xlabel="frequency / $\\sqrt{n}$" if ax in axes[1] else "")
        for ax, name in zip(axes[:, 3], ("mean", "anisotropy")):
            for number, (method, line) in enumerate(lines.items()):
                ax.plot(line.radius / n ** 0.5, getattr(line, name), color=look.PALETTE[number], linewidth=0.9, label=method)
        axes[0, 3].set(ylim=(0, 2.5), title="Radial mean")
        axes[1, 3].set(ylim=(-15, 25), title="Anisotropy, dB", xlabel="frequency / $\\sqrt{n}$")
        axes[0, 3].legend(loc="center left", bbox_to_anchor=(1, 0.5))

    figures.plot("figure16_power", "Power spectra of uniform sets of %d points in the square, means of %d (the regular set: "
                 "one): white noise is 1, black 0, white 2" % (n, sets), draw, 12, 5.2, nrows=2, ncols=4)
