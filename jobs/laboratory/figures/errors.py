"""Errors over the number of points: tables, slopes and plots of several methods."""
import numpy

from . import look


class ErrorSeries:
    """Values of a measure by number of points, several runs each."""

    def __init__(self, name):
        self.name, self.runs = name, {}

    def add(self, count, value):
        self.runs.setdefault(count, []).append(value)

    def means(self):
        """Counts, means and standard errors of the means, each (k,)."""
        counts = sorted(self.runs)
        runs = [numpy.array(self.runs[count]) for count in counts]
        spread = [r.std(ddof=1) / len(r) ** 0.5 if len(r) > 1 else 0.0 for r in runs]
        return numpy.array(counts, float), numpy.array([r.mean() for r in runs]), numpy.array(spread)

    def slope(self, least):
        """(slope, standard error) of a line through the logarithms, over counts of at least `least`; None for fewer than
        three."""
        counts, means, _ = self.means()
        keep = (counts >= least) & (means > 0)
        if keep.sum() < 3:
            return None
        x, y = numpy.log(counts[keep]), numpy.log(means[keep])
        slope, offset = numpy.polyfit(x, y, 1)
        rest = y - slope * x - offset
        return slope, (rest @ rest / (len(x) - 2) / ((x - x.mean()) ** 2).sum()) ** 0.5


def survey_counts(most, least=1):
    """2^l and 1.5 x 2^l from `least` to `most`, as the survey took them."""
    counts = {int(factor * 2 ** level) for level in range(1, 31) for factor in (1, 1.5)}
    return [count for count in sorted(counts) if least <= count <= most]


def draw_errors(figures, stem, title, series, measure, caption, least=16, shown=(1024,)):
    """The plot, its data, and the slopes from `least` points."""
    rows = [(s.name, int(n), mean, error) for s in series for n, mean, error in zip(*s.means())]
    figures.table(stem, title, ["method", "points", measure, "standard error"], rows, shown=False)

    def draw(axes):
        for number, s in enumerate(series):
            axes.errorbar(*s.means()[:2], yerr=s.means()[2], label=s.name, marker=look.MARKERS[number % 10], markersize=3,
                          linewidth=1.1, color=look.PALETTE[number % 10])
        axes.set(xscale="log", yscale="log", xlabel="points", ylabel=measure, title=title)
        axes.legend(loc="center left", bbox_to_anchor=(1.01, 0.5))

    figures.plot(stem, caption, draw)
    rows = []
    for s in series:
        slope, error = s.slope(least) or (None, None)
        rows.append([s.name, slope, error] + [float(numpy.mean(s.runs[n])) if n in s.runs else None for n in shown])
    figures.table(stem + "_slopes", "%s: slopes from %d points" % (title, least),
                  ["method", "slope", "its error"] + ["at %d" % n for n in shown], rows)
