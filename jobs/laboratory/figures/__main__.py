"""python3 -m meander.figures: what `meander figures` runs."""
import argparse
import os
import sys
import time

from .. import SamplingError, __version__, laboratory

if __name__ == "__main__":
    laboratory.require()  # before the figures take their colors from it

from . import registry  # noqa: E402
from .claims import CAPTIONS  # noqa: E402
from .figure_set import FigureSet  # noqa: E402
from .models import chosen_models  # noqa: E402


def numbers(count):
    def parse(text):
        values = [float(part) for part in text.split(",")]
        if len(values) != count:
            raise argparse.ArgumentTypeError("%d numbers separated by commas are needed" % count)
        return values
    return parse


def whole(low, high):
    def parse(text):
        value = int(text)
        if not low <= value <= high:
            raise argparse.ArgumentTypeError("a whole number from %d to %d is needed" % (low, high))
        return value
    return parse


def named_file(text):
    name, equals, file = text.partition("=")
    if not (name and equals and file):
        raise argparse.ArgumentTypeError("NAME=FILE is needed, and `%s` is none" % text)
    return name, file


def arguments(program):
    parser = argparse.ArgumentParser(prog=program, description="Remakes the survey's figures: pictures, data and a page.")
    parser.add_argument("-o", "--output", required=True, metavar="FOLDER", help="output folder, created if missing")
    parser.add_argument("--model", "--models", dest="models", action="extend", nargs="+", default=[], metavar="MESH",
                        help="meshes for the figures that show models (default: the bunny of the package glmark2-data, "
                             "where it is installed)")
    parser.add_argument("--points", action="extend", nargs="+", type=named_file, default=[], metavar="NAME=FILE",
                        help="point sets of other programs on the model, for the figure `limit`: the files of one NAME are "
                             "one curve")
    parser.add_argument("--only", default="", metavar="NAME,...",
                        help="these figures only, by number or name: " + ", ".join(registry.names()))
    parser.add_argument("--view", type=numbers(3), metavar="X,Y,Z", help="direction from the models towards the eye")
    parser.add_argument("--up", choices=["x", "y", "z"], default="y", help="the axis of the models that points up")
    parser.add_argument("--size", type=whole(64, 4096), metavar="PIXELS", help="of a picture of a model")
    parser.add_argument("--seed", type=whole(0, 2 ** 53), default=1)
    parser.add_argument("-j", "--threads", type=whole(0, 1024), default=0, help="0: all available")
    parser.add_argument("--quick", action="store_true", help="fewer points, shapes and sets")
    return parser


def main():
    parser = arguments(os.environ.get("MEANDER_COMMAND", "python3 -m meander.figures"))
    options = parser.parse_args()
    only = [name for name in options.only.split(",") if name]
    unknown = [name for name in only if not registry.drawn_with(name)]
    if unknown:
        parser.error("--only: there is no figure `%s`; there are %s" % (unknown[0], ", ".join(registry.names())))
    try:
        models = chosen_models(options.models)
    except (OSError, ValueError) as error:
        parser.error("--models: %s" % error)
    try:
        figures = FigureSet(options, models)
    except (OSError, ValueError) as error:
        parser.error("-o: %s" % error)
    if options.threads:
        laboratory.limit_threads(threads=options.threads)
    chosen = registry.chosen(only)
    if (options.view or options.size) and not any(figure.has_models for figure in chosen):
        parser.error("--view, --size: none of these figures shows a model")
    if options.points and (len(options.models) != 1 or "limit" not in (figure.name for figure in chosen)):
        parser.error("--points: they lie on one mesh, which --models gives, and only the figure `limit` shows them")
    for _, file in options.points:
        if not os.path.isfile(file.partition("::")[0]):  # FILE.h5::ITEM
            parser.error("--points: there is no file `%s`" % file)
    start = time.monotonic()
    for figure in chosen:
        print("%7.1f s  %s" % (time.monotonic() - start, figure.name), file=sys.stderr, flush=True)
        figures.begin(figure.name, CAPTIONS[figure.name])
        try:
            figure.draw(figures)
        except SamplingError as error:
            figures.not_drawn(str(error))
    page = figures.write_page("meander %s, seed %d%s" % (__version__, options.seed, ", --quick" if options.quick else ""))
    print("%d figures in %s, %.0f s" % (len(chosen), page, time.monotonic() - start))


if __name__ == "__main__":
    sys.exit(main())
