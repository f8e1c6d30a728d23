#!/usr/bin/env python3
"""Draws the figures of docs/reproducing.md from the records of experiments; nothing is run or measured.

Input: the records in a folder, EXPERIMENT.json as `volccd experiment run` writes them. Output: each figure as SVG,
in which text remains text, and as PNG with 130 dots per inch. The same record gives the same SVG, byte for byte (with the same
matplotlib).

  experiment   figures
  table1       speedup, breakdown, false-positives, funnel
  culling      culling
  ablation     ablation
  scaling      scaling, scaling-motion
  plus         plus
  feature-sets feature-sets

Rows of another motion model than `linear` and of another edge set than `triangulated` get figures of their own
(speedup-tentative, speedup-polytope), and so do speed-ups over variants of a baseline (speedup-variants), the tables
of an ablation (ablation-stages), and several threads (plus-2-threads). A figure without a record or without rows is
skipped with a message.

Examples:
  volccd-plot results/                                  all figures, into results/figures/
  volccd-plot results/ -o build/figures --only speedup culling

Needs python3-matplotlib. Exit code: 0 drawn, 2 bad input, output or usage; records are checked before
anything is drawn.
"""

import argparse
import os
import sys

try:
    import matplotlib
except ImportError as problem:
    sys.exit(f"volccd-plot: {problem}; install python3-matplotlib")

from plots.ablation import draw_ablation
from plots.culling import draw_culling
from plots.feature_sets import draw_feature_sets
from plots.page import RC
from plots.plus import draw_plus
from plots.records import COUNTS, STAGES, BadInput, caption_of, check_columns, read_record, without_common_settings
from plots.scaling import draw_scaling, draw_scaling_motion
from plots.speedup import draw_speedup
from plots.stages import draw_breakdown, draw_false_positives, draw_funnel
from version import version

PAIRS = ("element_pairs", "adjacent_pairs")
SCALING = ("seconds", "elements", "workspace_bytes", *COUNTS)
# For each experiment: its figures, each with the function that draws it and the columns that this function reads.
FIGURES = {
    "table1": {"speedup": (draw_speedup, ("seconds", "topology_seconds")),
               "breakdown": (draw_breakdown, ("seconds", *STAGES)),
               "false-positives": (draw_false_positives, ("seconds", *PAIRS, "touching_pairs")),
               "funnel": (draw_funnel, ("seconds", *PAIRS, "surviving_pairs", "owned_tests", "orphan_tests", *COUNTS,
                                        "contacts"))},
    "culling": {"culling": (draw_culling, ("seconds", *COUNTS))},
    "ablation": {"ablation": (draw_ablation, ("seconds", *COUNTS))},
    "scaling": {"scaling": (draw_scaling, SCALING), "scaling-motion": (draw_scaling_motion, SCALING)},
    "plus": {"plus": (draw_plus, ("seconds", "topology_seconds", "window"))},
    "feature-sets": {"feature-sets": (draw_feature_sets, ("time", "velocity", "overlaps_inter", "interior"))},
}


def say(text):
    print(f"volccd-plot: {text}")


def records_in(folder, wanted):
    """The records that have one of the wanted figures, after checking them. Prints which figures have no record."""
    if not os.path.isdir(folder):
        raise BadInput(f"{folder}: no such folder; name the folder that `volccd experiment run` wrote to")
    records = []
    for experiment, figures in FIGURES.items():
        names = [name for name in figures if name in wanted]
        path = os.path.join(folder, f"{experiment}.json")
        if names and not os.path.exists(path):
            begun = os.path.join(folder, f"{experiment}.incomplete.jsonl")
            say(f"{', '.join(names)}: skipped, there is no {path}" +
                (f"; repeat the command that began {begun}" if os.path.exists(begun) else ""))
        elif names:
            record = read_record(path, experiment)
            for name in names:
                check_columns(record, figures[name][1])
            records.append((record, names))
    others = sorted(name for name in os.listdir(folder) if name.endswith(".json") and name[:-5] not in FIGURES)
    if others:
        say(f"no figure is made of {', '.join(others)}")
    if not records:
        raise BadInput(f"{folder}: has no record for the figures asked for; run one of the experiments "
                       f"{', '.join(FIGURES)} first")
    return records


def suffix_of(row):
    """The end of a figure's name: motion model and edge set, if they are not the usual ones."""
    parts = (row["motion_model"], row.get("edges", "triangulated"))
    return "".join(f"-{part}" for part in parts if part not in ("linear", "triangulated"))


def pages_of(record, names):
    """[(file name without ending, page, record with the rows of its motion model and edge set)]."""
    if record.experiment == "table1":
        record = without_common_settings(record, say)
    parts = {}
    for row in record.rows:
        parts.setdefault(suffix_of(row), []).append(row)
    result = []
    for name in names:
        draw = FIGURES[record.experiment][name][0]
        drawn = []
        for suffix, rows in parts.items():
            part = record.with_rows(rows)
            drawn += [(page_name + suffix, page, part) for page_name, page in draw(part, say)]
        if not drawn:
            say(f"{name}: skipped, {record.path} has no rows for it")
        result += drawn
    return result


def parse_arguments(arguments):
    every = [name for figures in FIGURES.values() for name in figures]
    parser = argparse.ArgumentParser(prog="volccd-plot", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--version", action="version", version=f"volccd-plot {version()}")
    parser.add_argument("folder", metavar="RESULTS_FOLDER", help="the records")
    parser.add_argument("-o", "--output", metavar="FOLDER",
                        help="where figures are written; RESULTS_FOLDER/figures if absent")
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=every, default=every,
                        help=f"of {', '.join(every)}")
    return parser.parse_args(arguments)


def main(arguments):
    options = parse_arguments(arguments)
    output = options.output or os.path.join(options.folder, "figures")
    try:
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            matplotlib.rcParams.update(RC)
            records = records_in(options.folder, options.only)
            pages = [page for record, names in records for page in pages_of(record, names)]
            os.makedirs(output, exist_ok=True)
            for name, page, record in pages:
                path = os.path.join(output, name)
                page.save(path, caption_of(record))
                print(f"{path}.svg, {path}.png")
    except (BadInput, OSError) as problem:
        print(f"volccd-plot: {problem}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
