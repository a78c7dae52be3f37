#!/usr/bin/env python3
"""Score of every descriptor against its milliseconds a model, measured: a table and a picture.

    descriptor_costs.py MEANDER FOLDER... [-n 1024] [--runs 3] [--score "1st tier"] [--csv FILE] [--svg FILE]

Each FOLDER holds models in folders that name their classes. One descriptor after the other is made by
`meander run -j 1 --describe NAME` over the folder; its milliseconds a model are those that the run reports for the
stage that describes (STORE.run.json), the least of --runs runs. `meander retrieve evaluate` scores it (means over
queries, distance l1). Then a store of all descriptors is given to `meander retrieve words`, on one core, for local-pairs;
to `meander retrieve select`; and to `meander retrieve evaluate` without options. What the last two use is scored with
the milliseconds of its parts together. Nothing is kept from earlier measurements: run it
again after a change. Python's standard library only. Exit status 1 when a run failed.
"""
import argparse
import csv
import datetime
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from html import escape
from pathlib import Path

SCORES = ["NN", "1st tier", "2nd tier", "E-measure", "DCG", "mAP"]
COMBINED = ["without options", "selected"]
COLUMNS = ["models", "descriptor", "setting", "ms a model", *SCORES]


class Failure(Exception):
    """A run that cannot be used."""


def run_process(command, allowed=(0,), one_core=False):
    alone = (lambda: os.sched_setaffinity(0, [min(os.sched_getaffinity(0))])) if one_core else None
    done = subprocess.run(command, capture_output=True, text=True, check=False, preexec_fn=alone)
    if done.returncode not in allowed:
        raise Failure(f"{' '.join(command)}: exit {done.returncode}\n{done.stderr[-2000:]}")
    return done.stdout


def known_descriptors(meander):
    """Those that the program names in its help."""
    text = " ".join(run_process([meander, "run", "--help"]).split())
    found = re.search(r"Descriptors to store: none, or one or more of ([\w,\- ]+), separated by commas", text)
    if not found:
        raise Failure("the help of `run --describe` does not list the descriptors")
    return re.sub(r"\s", "", found.group(1)).split(",")


WITHOUT_BINS = set()  # descriptors that refuse --bins


# ---- measuring -----------------------------------------------------------------------------------------------

def make_store(arguments, folder, store, descriptors):
    """Milliseconds that describing a model took."""
    bins = [] if WITHOUT_BINS.issuperset(descriptors) else ["--bins", str(arguments.bins)]
    run_process([arguments.meander, "run", str(folder), "-o", str(store), "--fresh", "-j", "1", "-n",
                 str(arguments.samples), *bins, "--describe", ",".join(descriptors), "--label-from-folder",
                 "--timeout", "0", "--progress", "none"], allowed=(0, 3))
    report = json.loads(Path(f"{store}.run.json").read_text(encoding="utf-8"))
    return report["describe_microseconds"] / 1000


def scores_of(arguments, store, descriptor, distance="l1"):
    answer = json.loads(run_process([arguments.meander, "retrieve", "evaluate", str(store), "--descriptor",
                                     descriptor, "--distance", distance, "--json"]))
    return [answer["results"][0][score] for score in SCORES]


def find_without_bins(arguments, folder, scratch, descriptors):
    """Fills WITHOUT_BINS by a dry run each."""
    for descriptor in descriptors:
        done = subprocess.run([arguments.meander, "run", str(folder), "-o", str(scratch / "dry.h5"), "--describe",
                               descriptor, "--bins", str(arguments.bins), "--dry-run", "-n", "64"],
                              capture_output=True, text=True, check=False)
        if done.returncode == 2:
            WITHOUT_BINS.add(descriptor)


def measure_folder(arguments, folder, scratch):
    """One row a descriptor, as COLUMNS, and one of each combined setting."""
    rows, milliseconds = [], {}
    for descriptor in arguments.descriptors:
        store = scratch / "one.h5"
        times = [make_store(arguments, folder, store, [descriptor]) for _ in range(arguments.runs)]
        milliseconds[descriptor] = min(times)
        rows.append([folder.name, descriptor, "l1", min(times), *scores_of(arguments, store, descriptor)])
        print(f"{folder.name}: {descriptor}: {min(times):.3g} ms a model", file=sys.stderr, flush=True)
    store = scratch / "all.h5"
    make_store(arguments, folder, store, arguments.descriptors)
    times = []
    for _ in range(arguments.runs):
        words = json.loads(run_process([arguments.meander, "retrieve", "words", str(store), "--replace", "--json"],
                                       one_core=True))
        times.append(words["coding_milliseconds"] / words["coded"])
    milliseconds["local-pairs"] = min(times)
    rows.append([folder.name, "local-pairs", "cosine", min(times), *scores_of(arguments, store, "local-pairs")])
    answer = json.loads(run_process([arguments.meander, "retrieve", "evaluate", str(store), "--json"]))
    rows.append([folder.name, "without options", f"{answer['descriptor']}, {answer['rank']}",
                 sum(milliseconds[part] for part in answer["descriptor"].split("+")),
                 *(answer["results"][0][score] for score in SCORES)])
    answer = json.loads(run_process([arguments.meander, "retrieve", "select", str(store), "--most",
                                     str(arguments.most), "--json"]))
    recommended, distance = answer["recommended"]["descriptor"], answer["recommended"]["distance"]
    parts = [term.split("=")[0] for term in recommended.split("+")]
    if len(parts) > 1:
        rows.append([folder.name, "selected", f"{recommended}, {distance}", sum(milliseconds[p] for p in parts),
                     *scores_of(arguments, store, recommended, distance)])
    return rows


# ---- the picture ---------------------------------------------------------------------------------------------

COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7"]
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 760, 460, 64, 150, 44, 54


def placed_labels(points):
    """A label beside every point, where it covers no other label and no point and stays in the frame if there is such a
    place: [(x of the text's start, baseline, text, color)]."""
    marks = [(x - 6, y - 6, x + 6, y + 6) for x, y, _, _ in points] + [(WIDTH - RIGHT, 0, WIDTH, HEIGHT)]
    placed, boxes = [], []
    for x, y, text, color in sorted(points):
        width = 6.6 * len(text)
        places = [(x + 8, y + 4), (x - 8 - width, y + 4), (x + 8, y + 17), (x + 8, y - 9), (x - 8 - width, y + 17),
                  (x - 8 - width, y - 9), (x - width / 2, y + 20), (x - width / 2, y - 12)]
        box = lambda place: (place[0], place[1] - 10, place[0] + width, place[1] + 3)
        apart = lambda a, b: a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
        free = [place for place in places if all(apart(box(place), other) for other in marks + boxes)]
        place = (free or places)[0]
        boxes.append(box(place))
        placed.append((*place, text, color))
    return placed


def svg_picture(rows, score, title):
    column = COLUMNS.index(score)
    folders = list(dict.fromkeys(row[0] for row in rows))
    low = math.floor(math.log10(min(row[3] for row in rows)) - 0.05)
    high = math.ceil(math.log10(max(row[3] for row in rows)) + 0.05)
    top = min(1.0, math.ceil(max(row[column] for row in rows) * 10 + 0.3) / 10)
    x_of = lambda ms: LEFT + (math.log10(ms) - low) / (high - low) * (WIDTH - LEFT - RIGHT)
    y_of = lambda value: HEIGHT - BOTTOM - value / top * (HEIGHT - TOP - BOTTOM)
    out = [f'<?xml version="1.0" encoding="UTF-8"?>\n<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" '
           f'height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="12" fill="#333">',
           f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#fff"/>',
           f'<text x="{LEFT}" y="22" font-size="14">{escape(title)}</text>']
    for decade in range(low, high + 1):
        x = x_of(10.0 ** decade)
        out.append(f'<line x1="{x:.1f}" y1="{TOP}" x2="{x:.1f}" y2="{HEIGHT - BOTTOM}" stroke="#ddd"/>'
                   f'<text x="{x:.1f}" y="{HEIGHT - BOTTOM + 18}" text-anchor="middle">{10.0 ** decade:g}</text>')
        for k in range(2, 10) if decade < high else []:
            x = x_of(k * 10.0 ** decade)
            out.append(f'<line x1="{x:.1f}" y1="{HEIGHT - BOTTOM - 4}" x2="{x:.1f}" y2="{HEIGHT - BOTTOM}" stroke="#999"/>')
    for tenth in range(0, round(top * 10) + 1):
        y = y_of(tenth / 10)
        out.append(f'<line x1="{LEFT}" y1="{y:.1f}" x2="{WIDTH - RIGHT}" y2="{y:.1f}" stroke="#ddd"/>'
                   f'<text x="{LEFT - 8}" y="{y + 4:.1f}" text-anchor="end">{tenth / 10:.1f}</text>')
    out.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{HEIGHT - 14}" text-anchor="middle">ms a model, one '
               f'thread</text><text x="16" y="{(TOP + HEIGHT - BOTTOM) / 2}" text-anchor="middle" transform='
               f'"rotate(-90 16 {(TOP + HEIGHT - BOTTOM) / 2})">{escape(score)}</text>')
    points = []
    for row in rows:
        color = COLORS[folders.index(row[0]) % len(COLORS)]
        x, y = x_of(row[3]), y_of(row[column])
        if row[1] in COMBINED:
            out.append(f'<path d="M{x:.1f} {y - 6:.1f}l6 6l-6 6l-6 -6z" fill="{color}"><title>{escape(row[2])}</title></path>')
        else:
            out.append(f'<circle cx="{x:.1f}" cy="{y:.1f}" r="4.5" fill="{color}"/>')
        points.append((x, y, row[1], color))
    out += [f'<text x="{x:.1f}" y="{y:.1f}" fill="{color}">{escape(text)}</text>'
            for x, y, text, color in placed_labels(points)]
    for i, name in enumerate(folders):
        y = TOP + 12 + 20 * i
        out.append(f'<circle cx="{WIDTH - RIGHT + 22}" cy="{y - 4}" r="4.5" fill="{COLORS[i % len(COLORS)]}"/>'
                   f'<text x="{WIDTH - RIGHT + 34}" y="{y}">{escape(name)}</text>')
    return "\n".join(out) + "\n</svg>\n"


def print_table(rows):
    print("| models | descriptor | ms a model | " + " | ".join(SCORES) + " |\n|---|---|---|" + "---|" * len(SCORES))
    for row in rows:
        name = f"{row[1]}: {row[2]}" if row[1] in COMBINED else row[1]
        print(f"| {row[0]} | {name} | {row[3]:.2g} | " + " | ".join(f"{value:.3f}" for value in row[4:]) + " |")


def measure(arguments):
    rows = []
    with tempfile.TemporaryDirectory(prefix="meander-costs-", dir=arguments.scratch) as name:
        scratch = Path(name)
        find_without_bins(arguments, arguments.folders[0], scratch, arguments.descriptors)
        for folder in arguments.folders:
            rows += measure_folder(arguments, folder, scratch)
    print_table(rows)
    if arguments.csv:
        with open(arguments.csv, "w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(COLUMNS)
            writer.writerows([[f"{cell:.6g}" if isinstance(cell, float) else cell for cell in row] for row in rows])
    if arguments.svg:
        title = f"{arguments.samples} samples a model, {datetime.date.today().isoformat()}"
        Path(arguments.svg).write_text(svg_picture(rows, arguments.score, title), encoding="utf-8")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meander", help="the program")
    parser.add_argument("folders", nargs="+", type=Path, help="folders of folders of models")
    parser.add_argument("-n", "--samples", type=int, default=1024, help="samples a model (default 1024)")
    parser.add_argument("--bins", type=int, default=64, help="bins of histograms that take them (default 64)")
    parser.add_argument("--descriptors", help="separated by commas (default: all that the program makes)")
    parser.add_argument("--most", type=int, default=3, help="largest combinations that `select` starts from (default 3)")
    parser.add_argument("--runs", type=int, default=3, help="runs of a descriptor, of which the fastest counts (default 3)")
    parser.add_argument("--score", default="1st tier", choices=SCORES, help="in the picture (default 1st tier)")
    parser.add_argument("--csv", metavar="FILE", help="the table")
    parser.add_argument("--svg", metavar="FILE", help="the picture")
    parser.add_argument("--scratch", default=None, help="folder for stores (default: the system's)")
    arguments = parser.parse_args()
    arguments.meander = os.path.abspath(shutil.which(arguments.meander) or arguments.meander)
    arguments.folders = [folder.resolve() for folder in arguments.folders]
    try:
        arguments.descriptors = arguments.descriptors.split(",") if arguments.descriptors else known_descriptors(
            arguments.meander)
        return measure(arguments)
    except Failure as failure:
        print(f"descriptor_costs: {failure}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main())
