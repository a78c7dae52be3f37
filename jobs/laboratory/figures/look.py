"""How plots look, and everything that touches matplotlib."""
import functools
import io

import numpy

_COLORS, PALETTE = [], []  # of io/plot/color.h, told to use_colors: all, and those that all readers can tell apart
MARKERS = "os^Dv<>pXP"
NEUTRAL = "#6e6e6e"
DOT = (196, 62, 28)
SKIN = (232, 196, 158)


def color(number):
    """The color of a curve: those of the palette, then further ones that are harder to tell apart."""
    return _COLORS[number % len(_COLORS)]


def use_colors(colors):
    """The first colors of the palette, as "#0072b2". Called once, before anything is drawn."""
    _COLORS[:], PALETTE[:] = colors, colors[:len(MARKERS)]


@functools.lru_cache
def available():
    try:
        import matplotlib  # noqa: F401
        return True
    except ImportError:
        return False


@functools.lru_cache
def _pyplot():
    import matplotlib
    matplotlib.use("Agg")
    matplotlib.rcParams.update({
        "font.size": 9, "axes.titlesize": 10, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
        "grid.color": "#e4e4e4", "grid.linewidth": 0.6, "axes.axisbelow": True, "legend.frameon": False,
        "svg.hashsalt": "meander", "svg.fonttype": "none", "savefig.dpi": 160,
        "axes.prop_cycle": matplotlib.cycler(color=PALETTE)})
    import matplotlib.pyplot
    return matplotlib.pyplot


def subplots(width, height, **grid):
    """A figure of so many inches and its axes."""
    return _pyplot().subplots(figsize=(width, height), constrained_layout=True, **grid)


def save(figure, file, kind):
    """Writes svg or png to an open file; the same figure gives the same bytes, which say nothing of date and program."""
    nothing = {"svg": ("Date", "Creator", "Format", "Type"), "png": ("Software",)}[kind]
    for axis in (axes.yaxis for axes in figure.axes):
        if axis.get_scale() == "log":  # of two decades and less, one label would not tell the scale
            axis.set_minor_formatter(_pyplot().matplotlib.ticker.LogFormatterSciNotation(minor_thresholds=(2, 0.5)))
    figure.savefig(file, format=kind, metadata=dict.fromkeys(nothing), bbox_inches="tight")


def saved(figure):
    """(suffix, bytes) of the SVG and the PNG file."""
    result = []
    for kind in ("svg", "png"):
        file = io.BytesIO()
        save(figure, file, kind)
        result.append(("." + kind, file.getvalue()))
    _pyplot().close(figure)
    return result


def panels(images, columns):
    """PNG of (pixels, title, note) beside each other, pixel for pixel."""
    rows = -(-len(images) // columns)
    high, wide = (max(pixels.shape[axis] for pixels, _, _ in images) for axis in (0, 1))
    dpi, gap = 160, 14
    text = max(1, columns * (wide + gap) / 1650)  # of a wide sheet larger: it is printed as small as any other
    room = round(64 * text)
    width, height = columns * (wide + gap) + gap, rows * (high + room) + gap
    figure = _pyplot().figure(figsize=(width / dpi, height / dpi), dpi=dpi)
    for number, (pixels, title, note) in enumerate(images):
        left = gap + (number % columns) * (wide + gap) + (wide - pixels.shape[1]) // 2
        top = gap + (number // columns) * (high + room)
        figure.figimage(pixels, left, height - top - pixels.shape[0], origin="upper")
        middle, below = (left + pixels.shape[1] / 2) / width, top + pixels.shape[0]
        for words, size, down, color in ((title, 9, 6, "black"), (note, 7.5, 32, NEUTRAL)):
            size = min(size * text, 0.85 * wide / max(1, len(words)))  # as wide as the picture at most
            figure.text(middle, 1 - (below + down * text) / height, words, ha="center", va="top", fontsize=size, color=color)
    file = io.BytesIO()
    figure.savefig(file, format="png", dpi=dpi, metadata={"Software": None})
    _pyplot().close(figure)
    return file.getvalue()


def map_color(t):
    """(n, 3) uint8 of t in [0, 1]: dark violet over blue and green to yellow, in even steps of lightness (OKLab, Ottosson
    2020; lightness 0.28 + 0.64 t, hue 305 to 108 degrees)."""
    t = numpy.clip(numpy.atleast_1d(numpy.asarray(t, float)), 0, 1)
    s = 2 * t - 1
    chroma, hue, light = 0.094 + s * s * (0.065 + 0.025 * s), numpy.radians(305 - 197 * t), 0.28 + 0.64 * t
    a, b = chroma * numpy.cos(hue), chroma * numpy.sin(hue)
    lms = numpy.stack([light + 0.3963377774 * a + 0.2158037573 * b, light - 0.1055613458 * a - 0.0638541728 * b,
                       light - 0.0894841775 * a - 1.2914855480 * b]) ** 3
    linear = numpy.array([[4.0767416621, -3.3077115913, 0.2309699292], [-1.2684380046, 2.6097574011, -0.3413193965],
                          [-0.0041960863, -0.7034186147, 1.7076147010]]) @ lms
    linear = numpy.clip(linear, 0, 1)
    encoded = numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return numpy.round(255 * encoded.T).astype(numpy.uint8)


def gray_map(values, upper, cell=1):
    """(h, w, 3) uint8 of (h, w) values, black 0, white `upper`; the first row is the bottom one."""
    gray = numpy.round(255 * numpy.clip(values / upper, 0, 1)).astype(numpy.uint8)[::-1]
    return numpy.repeat(numpy.repeat(numpy.repeat(gray[:, :, None], 3, axis=2), cell, axis=0), cell, axis=1)


def plain_ticks(axes):
    """Numbers such as 0.5, 1, 2 at logarithmic axes, once the curves are drawn."""
    for axis, limits in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
        if axis.get_scale() != "log":
            continue
        low, high = numpy.log10(limits)
        steps = ((1, 1.2, 1.4, 1.6, 1.8, 2, 2.5, 3, 3.5, 4, 5, 6, 7, 8, 9) if high - low < 0.4 else
                 (1, 2, 3, 4, 6, 8) if high - low < 0.8 else (1, 2, 5) if high - low < 2.5 else (1,))
        ticks = [step * 10.0 ** decade for decade in range(int(low) - 2, int(high) + 2) for step in steps]
        ticks = [tick for tick in ticks if limits[0] <= tick <= limits[1]]
        axis.set_ticks(ticks, labels=[numpy.format_float_positional(float("%g" % tick), trim="-") for tick in ticks])
        axis.set_ticks([], minor=True)


def legend_below(axes, columns):
    """One for all of several axes."""
    entries = {}
    for one in numpy.ravel(axes):
        entries.update({label: handle for handle, label in zip(*one.get_legend_handles_labels())})
    numpy.ravel(axes)[0].figure.legend(entries.values(), entries, loc="upper center", bbox_to_anchor=(0.5, 0), ncol=columns)
