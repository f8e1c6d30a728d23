#!/usr/bin/env python3
"""Draws the figures of docs/reproducing.md from the records of experiments; nothing is run or measured.

Input: the records in a folder, EXPERIMENT.json as `volccd experiment run` writes them. Output: each figure as SVG,
whose text is text, and as PNG with 300 dots per inch. The same record gives the same SVG, byte for byte (with the same
matplotlib).

  experiment   figures
  table1       speedup, breakdown, false-positives, funnel
  culling      culling
  ablation     ablation
  scaling      scaling, scaling-motion

Rows of another motion model than `linear` and of another edge set than `triangulated` get figures of their own
(speedup-tentative, speedup-polytope), and so do speed-ups over variants of a baseline (speedup-variants) and the tables
of an ablation (ablation-stages). What has no record or no rows is skipped, and this is said.

Examples:
  plot_results.py results/                                  all figures, into results/figures/
  plot_results.py results/ -o build/figures --only speedup culling

Needs python3-matplotlib. Exit code: 0 drawn, 2 bad input, output or usage; records are checked before
anything is drawn.
"""

import argparse
import collections
import dataclasses
import itertools
import json
import math
import os
import re
import statistics
import sys
import textwrap

try:
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
except ImportError as problem:
    sys.exit(f"plot_results.py: {problem}; install python3-matplotlib")

SCHEMA = 1
SINGLE, DOUBLE, TALLEST = 85, 175, 235  # widths of one and of two columns, and the height of a page, in mm
INCH = 25.4
RC = {"svg.fonttype": "none", "svg.hashsalt": "volccd", "font.family": "DejaVu Sans", "font.size": 8,
      "axes.titlesize": 8, "axes.labelsize": 8, "xtick.labelsize": 8, "ytick.labelsize": 8, "legend.fontsize": 8,
      "axes.linewidth": 0.6, "lines.linewidth": 1.0, "lines.markersize": 4.5, "hatch.linewidth": 0.5,
      "axes.axisbelow": True, "grid.linewidth": 0.4, "grid.color": "#cccccc", "legend.frameon": False,
      "text.parse_math": False}
SMALL = 7  # points: numbers beside marks, captions
LINES_OF_A_PAGE = 40  # of an ablation

# Okabe and Ito's palette, the dark colours first. Marker, line and hatch differ as well.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#000000", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442"]
MARKERS = ["o", "s", "^", "v", "D", "P", "X", "<", ">"]
LINES = ["-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1))]
BAR_COLOURS = ["#F0E442", "#56B4E9", "#E69F00", "#FFFFFF", "#CC79A7", "#009E73", "#D55E00", "#BBBBBB"]  # show hatches
HATCHES = ["", "////", "....", "\\\\\\\\", "xxxx", "----", "++++", "||||", "oo"]

# The paper's printed figures: Table I (speed-ups), Tables II and III (VF and EE tests for A, B and C).
PAPER_SCENES = ["octopi", "bullet", "airbag", "crash", "liver"]
PAPER_SPEEDUP = {"NavCCD": {"octopi": 12, "bullet": 21, "airbag": 10.2, "crash": 12.4, "liver": 10.3},
                 "HashCCD": {"octopi": 18.3, "bullet": 28, "airbag": 13, "crash": 17.4, "liver": 14.1}}
PAPER_TESTS = {"octopi": {"A": (26e6, 312e6), "B": (1.1e6, 6.4e6), "C": (7.9e3, 24e3)},
               "crash": {"A": (8.24e9, 1.6e10), "B": (9.8e7, 3.8e8), "C": (2.3e7, 1.2e8)}}

TEXTS = ("table", "scene", "motion_model", "pipeline", "variant")
COUNTS = ("vf_tests", "ee_tests")
ROLES = ("broad_phase", "element_culling", "assignment", "orphans", "feature_filter", "narrow_phase")
STAGES = ("bounds_s", *(f"{role}_{part}_s" for role in ROLES for part in ("prepare", "run")))


class BadInput(Exception):
    pass


@dataclasses.dataclass(frozen=True)
class Record:
    """Of one experiment; `rows` are those that a figure is about, `where` says of each (by its id) where it stands."""
    experiment: str
    path: str
    complete: bool
    provenance: dict
    rows: list
    where: dict

    def with_rows(self, rows):
        return dataclasses.replace(self, rows=rows)


# --- records -------------------------------------------------------------------------------------------------------

def read_record(path, experiment):
    try:
        with open(path, encoding="utf-8") as file:
            data = json.load(file)
    except (OSError, ValueError) as problem:
        raise BadInput(f"{path}: cannot be read: {problem}") from problem
    if not isinstance(data, dict) or data.get("experiment") != experiment:
        raise BadInput(f"{path}: is no record of the experiment {experiment}; run it again to replace the file")
    if data.get("schema") != SCHEMA:
        raise BadInput(f"{path}: has the schema {data.get('schema')}, but this program reads {SCHEMA}; "
                       "run the experiment again")
    for key, kind in (("rows", list), ("provenance", dict)):
        if not isinstance(data.get(key), kind):
            raise BadInput(f"{path}: has no '{key}'; run the experiment again")
    for key in ("setting", "commit", "cpu", "cores", "threads"):
        if key not in data["provenance"]:
            raise BadInput(f"{path}: the provenance has no '{key}'; run the experiment again")
    for index, row in enumerate(data["rows"]):
        if not isinstance(row, dict):
            raise BadInput(f"{path}: row {index} is no object of columns; run the experiment again")
    where = {id(row): index for index, row in enumerate(data["rows"])}
    return Record(experiment, path, data.get("complete") is True, data["provenance"], data["rows"], where)


def check_columns(record, columns):
    """Every row has the columns that identify it and `columns`: texts, else finite numbers that are not negative;
    times, elements and lengths are positive."""
    for row in record.rows:
        for column in (*TEXTS, "motion", "round", *columns):
            value = row.get(column)
            if column in TEXTS:
                good = isinstance(value, str)
            else:
                good = type(value) in (int, float) and 0 <= value < math.inf
                good = good and (value > 0 or column not in ("seconds", "elements", "moved_edges"))
            if not good:
                there = f"{column} = {json.dumps(value)}" if column in row else f"no column '{column}'"
                raise BadInput(f"{record.path}: row {record.where[id(row)]} has {there}, which a figure of "
                               f"{record.experiment} needs; run the experiment again with this version of the program")


def grouped(rows, *columns):
    """Rows by the values of the columns, in the order in which they come; by the value itself for a single column."""
    groups = {}
    for row in rows:
        key = tuple(row[column] for column in columns)
        groups.setdefault(key if len(columns) > 1 else key[0], []).append(row)
    return groups


def typical(rows):
    """One row for each motion: that of the round with the (lower) median time, so that its stages add up."""
    by_time = [sorted(rounds, key=lambda row: (row["seconds"], row["round"]))
               for rounds in grouped(rows, "motion").values()]
    return [rounds[(len(rounds) - 1) // 2] for rounds in by_time]


def median_over_motions(rows, value):
    """Of value(row): the median over motions of the median over rounds."""
    return statistics.median(statistics.median(map(value, rounds)) for rounds in grouped(rows, "motion").values())


def seconds(row):
    return row["seconds"]


def seconds_with_edit(row):
    return row["seconds"] + row["topology_seconds"]


def mean_count(rows, count):
    """Per motion; counts are the same in all rounds."""
    return statistics.fmean(count(row) for row in typical(rows))


def tests(row):
    return row["vf_tests"] + row["ee_tests"]


def is_baseline(pipeline):
    return pipeline.startswith(("NavCCD", "HashCCD"))


def label_of(pipeline, variant):
    return f"{pipeline}, {variant}" if variant else pipeline


def scenes_of(rows):
    """The paper's in the order of its Section 6.2, then all others by name."""
    names = {row["scene"] for row in rows}
    return [name for name in PAPER_SCENES if name in names] + sorted(names.difference(PAPER_SCENES))


def caption_of(record):
    motions = {scene: len({row["motion"] for row in rows}) for scene, rows in grouped(record.rows, "scene").items()}
    scenes = ", ".join(f"{scene}\N{NO-BREAK SPACE}({motions[scene]})" for scene in scenes_of(record.rows))
    facts = record.provenance
    incomplete = "" if record.complete else ", incomplete record"
    commit = facts["commit"].removesuffix("-dirty")
    changes = " with local changes" if commit != facts["commit"] else ""
    threads = f"{facts['threads']}\N{NO-BREAK SPACE}thread{'' if facts['threads'] == 1 else 's'}"
    return (f"Scenes (motions): {scenes}. Setting: {facts['setting']}{incomplete}. Commit {commit}{changes}. "
            f"{facts['cpu']}, {facts['cores']} cores, {threads}.")


# --- pages ------------------------------------------------------------------------------------------------------------

class Looks:
    """Colour, marker, line and hatch by name: the same in all figures for those of `known`; others follow in turn."""

    def __init__(self, known=()):
        self.names = list(known)

    def index(self, name):
        if name not in self.names:
            self.names.append(name)
        return self.names.index(name)

    def marker(self, name, **more):
        i = self.index(name)
        return {"color": COLOURS[i % len(COLOURS)], "marker": MARKERS[i % len(MARKERS)], "markeredgecolor": "black",
                "markeredgewidth": 0.4, **more}

    def line(self, name):
        return self.marker(name, linestyle=LINES[self.index(name) % len(LINES)])

    def bar(self, name):
        i = self.index(name)
        return {"facecolor": BAR_COLOURS[i % len(BAR_COLOURS)], "hatch": HATCHES[i % len(HATCHES)],
                "edgecolor": "black", "linewidth": 0.5}


def pipeline_looks():
    return Looks(["VolCCD-2011", "VolCCD", "VolCCD+", "NavCCD-2011", "NavCCD", "HashCCD-2011", "HashCCD"])


PAPER_MARK = {"marker": "D", "color": "white", "markeredgecolor": "black", "markeredgewidth": 0.8, "linestyle": "none"}


class Page:
    """A figure: panels, a legend above them and a caption below, as wide as one or two columns of print."""

    def __init__(self, width, height, rows=1, columns=1, **subplots):
        self.size = (width / INCH, min(height, TALLEST) / INCH)
        self.figure = Figure(figsize=self.size)
        self.panels = self.figure.subplots(rows, columns, squeeze=False, **subplots)
        self.handles = {}

    def legend(self, name, handle):
        self.handles.setdefault(name, handle)

    def unused(self, count):
        """Takes away the last panels of the grid, beyond the first `count`."""
        for panel in list(self.panels.flat)[count:]:
            panel.remove()

    def fit_legend(self):
        """The legend in as few lines as the width allows, means and the paper's marks last; None without marks."""
        names = sorted(self.handles, key=lambda name: (name.startswith("paper"), name.startswith("mean")))
        for lines in range(1, len(names) + 1):
            legend = self.figure.legend([self.handles[name] for name in names], names, loc="upper center",
                                        ncol=math.ceil(len(names) / lines), columnspacing=1.2, handletextpad=0.5,
                                        borderaxespad=0.2)
            if lines == len(names) or legend.get_window_extent().width <= self.figure.bbox.width:
                return legend
            legend.remove()
        return None

    def fit_caption(self, words):
        text = self.figure.text(0.01, 0, "", fontsize=SMALL, va="bottom", linespacing=1.15)
        for width in range(200, 20, -2):
            text.set_text(textwrap.fill(words, width, break_on_hyphens=False))
            if text.get_window_extent().width <= 0.98 * self.figure.bbox.width:
                break
        return text

    def save(self, path, caption):
        """Writes path.svg and path.png. Legend and caption make the page taller, not the panels smaller."""
        legend, text = self.fit_legend(), self.fit_caption(caption)
        dpi = self.figure.dpi
        above = (legend.get_window_extent().height / dpi if legend else 0) + 0.02
        below = text.get_window_extent().height / dpi + 0.05
        height = self.size[1] + above + below
        self.figure.set_size_inches(self.size[0], height)
        text.set_position((0.01, 0.03 / height))
        room = (0, below / height, 1, self.size[1] / height)
        self.figure.set_layout_engine("constrained", rect=room, w_pad=0.03, h_pad=0.03)
        self.figure.draw_without_rendering()
        self.figure.set_layout_engine("none")
        self.figure.savefig(f"{path}.svg", metadata={"Date": None, "Creator": None})
        self.figure.savefig(f"{path}.png", dpi=300, metadata={"Software": None})


def number(value, digits=3):
    """Short enough to stand beside a mark: three digits; from 1000 on `digits` of them, with k, M or G."""
    for limit, unit in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if value >= 0.9995 * limit:
            return f"{float(f'{value / limit:.{digits}g}'):g}{unit}"
    return f"{value:.3g}"


def times(ratio):
    return f"{ratio:.2f}×" if ratio < 1 else f"{ratio:.1f}×" if ratio < 99.95 else f"{ratio:.0f}×"


def log_axis(axis, zero=None):
    """Labels of a logarithmic axis in plain text: at powers of ten, between them too where there are few. Zeros, if
    there are any, stand at `zero`."""
    low, high = sorted(axis.get_view_interval())
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 100 * low else (1,), numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda x, _: "0" if zero and x < 1.5 * zero else number(x)))
    axis.set_minor_formatter(NullFormatter())


def log_limits(set_limits, values, room):
    """Limits that hold all values: from a power of ten below the smallest (two below, where zeros need a place) to the
    largest times `room`. Returns the lower one, and it again, or None, as the place of zeros."""
    positive = [value for value in values if value > 0] or [1]
    low = 10.0 ** math.floor(math.log10(min(positive)) - 0.05)
    zeros = min(values, default=1) <= 0
    low = low / 10 if zeros else low
    set_limits(low, max(max(positive) * room, low * 10))
    return low, low if zeros else None


def scene_axis(panel, positions, scenes):
    panel.set_yticks(positions, scenes)
    panel.tick_params(axis="y", length=0)


def without_common_settings(record, say):
    """The record without the settings that all variants of a table have, such as its narrow phase."""
    rows = []
    for table, of_table in grouped(record.rows, "table").items():
        words = [row["variant"].split() for row in of_table]
        common = {word for word in words[0] if all(word in others for others in words)}
        if common:
            say(f"{record.experiment}: table {table}: {' '.join(sorted(common))} is a setting of all its pipelines")
        rows += [row | {"variant": " ".join(word for word in row["variant"].split() if word not in common)}
                 for row in of_table]
    return record.with_rows(rows)


# --- table1 -----------------------------------------------------------------------------------------------------------

def comparisons(rows, family):
    """(label, baseline's rows, rows) of pipelines that are no baselines against those of the family, each variant
    against its like; where there is none, against the one without settings."""
    pipelines = grouped(rows, "pipeline", "variant")
    subjects = [key for key in pipelines if not is_baseline(key[0])]
    baselines = [key for key in pipelines if key[0].startswith(family)]

    def like(key, others):
        same = [other for other in others if other[1] == key[1]]
        return same or [other for other in others if not other[1]] or others

    pairs = {(subject, baseline): None for subject in subjects for baseline in like(subject, baselines)}
    pairs |= {(subject, baseline): None for baseline in baselines for subject in like(baseline, subjects)}
    several = len({baseline[0] for baseline in baselines}) > 1
    for subject, baseline in pairs:
        label = label_of(*subject)
        if several or baseline[1] != subject[1]:
            label += " over " + label_of(*baseline)
        yield label, pipelines[baseline], pipelines[subject]


def speedup(baseline, subject):
    """Ratio of the median times, topology edits included, of the motions that both have, or None without any."""
    motions = {row["motion"] for row in baseline} & {row["motion"] for row in subject}
    if not motions:
        return None
    before, after = (median_over_motions([row for row in rows if row["motion"] in motions], seconds_with_edit)
                     for rows in (baseline, subject))
    return before / after


def speedups(record, say):
    """{(family, table, scene): [(label, ratio)]}."""
    result = {}
    for family in PAPER_SPEEDUP:
        for (table, scene), rows in grouped(record.rows, "table", "scene").items():
            entries = result.setdefault((family, table, scene), [])
            for label, baseline, subject in comparisons(rows, family):
                ratio = speedup(baseline, subject)
                if ratio is None:
                    say(f"speedup: table {table}, {scene}, {label}: has no motion in common with "
                        f"{baseline[0]['pipeline']}; left out")
                else:
                    entries.append((label, ratio))
    return result


def draw_speedup(record, say):
    """Speed-ups over a variant of a baseline that the pipeline itself has not go to a page of their own."""
    ratios = speedups(record, say)
    pages = []
    for name, wanted in (("speedup", False), ("speedup-variants", True)):
        some = {key: [entry for entry in entries if (" over " in entry[0]) == wanted]
                for key, entries in ratios.items()}
        if any(some.values()):
            families = [family for family in PAPER_SPEEDUP if any(some[key] for key in some if key[0] == family)]
            tables = sorted({table for (_, table, _), entries in some.items() if entries})
            scenes = [scene for scene in scenes_of(record.rows) if any(some[key] for key in some if key[2] == scene)]
            pages.append((name, speedup_page(record, some, families, tables, scenes)))
    return pages


def speedup_page(record, ratios, families, tables, scenes):
    slots = max(map(len, ratios.values())) + 1
    pitch = slots + 0.8
    page = Page(DOUBLE, len(families) * (12 + 3.3 * pitch * len(scenes)), len(families), len(tables), sharex=True,
                sharey=True)
    looks = pipeline_looks()
    every = [ratio for entries in ratios.values() for _, ratio in entries]
    every += [factor for printed in PAPER_SPEEDUP.values() for factor in printed.values()]
    low = min(0.9, *every) / 1.2
    high = max(every) * (max(every) / low) ** 0.35  # room for numbers beside marks
    for (family, panels), (column, table) in itertools.product(zip(families, page.panels), enumerate(tables)):
        panel = panels[column]
        names = {row["pipeline"] for row in record.rows if row["table"] == table and row["pipeline"].startswith(family)}
        panel.set(xscale="log", xlim=(low, high), title=f"I-{table}: over {', '.join(sorted(names)) or family}")
        for i, scene in enumerate(scenes):
            if i % 2:
                panel.axhspan(i * pitch - 0.9, i * pitch + slots - 0.1, color="#f2f2f2", linewidth=0)
            draw_speedups(page, panel, i * pitch, ratios.get((family, table, scene), []), looks,
                          PAPER_SPEEDUP[family].get(scene))
        panel.axvline(1, color="black", linewidth=0.6)
        log_axis(panel.xaxis)
        panel.set_ylim(len(scenes) * pitch - 0.9, -0.9)
        scene_axis(panel, [i * pitch + (slots - 1) / 2 for i in range(len(scenes))], scenes)
    for panel in page.panels[-1]:
        panel.set_xlabel("speed-up (ratio of median times)" if len(tables) < 4 else "speed-up")
    return page


def draw_speedups(page, panel, y, entries, looks, printed):
    """Of one scene, one below the other, the paper's last."""
    marks = [(label, ratio, looks.marker(label), times(ratio)) for label, ratio in entries]
    marks += [("paper (Table I, as printed)", printed, PAPER_MARK, f"{printed:g}×")] if printed else []
    for j, (label, ratio, look, text) in enumerate(marks):
        panel.plot([1, ratio], [y + j, y + j], color="#888888", linewidth=0.6)
        panel.plot([ratio], [y + j], **look)
        panel.annotate(text, (ratio, y + j), (4, 0), textcoords="offset points", va="center", fontsize=SMALL)
        page.legend(label, Line2D([], [], **{**look, "linestyle": "none"}))


def parts_of(row):
    """Seconds by the parts of Figure 11; with several threads, stages count the time of all workers."""
    parts = {"k-DOPs": row["bounds_s"],
             "tree": row["broad_phase_prepare_s"] - row["bounds_s"],
             "traversal and culling": row["broad_phase_run_s"] + sum(
                 row[f"{role}_{part}_s"] for role in ("element_culling", "assignment") for part in ("prepare", "run"))}
    others = {"orphans": "O-Set", "feature_filter": "feature filters", "narrow_phase": "elementary tests"}
    for role, name in others.items():
        parts[name] = row[f"{role}_prepare_s"] + row[f"{role}_run_s"]
    return parts


def shares_of(rows):
    """Percent of the time of all motions, by part, the remainder included."""
    totals, measured = collections.Counter(), 0
    for row in typical(rows):
        totals.update(parts_of(row))
        measured += row["seconds"]
    totals["remainder"] = max(0, measured - sum(totals.values()))
    whole = sum(totals.values())
    return {name: 100 * max(0, value) / whole for name, value in totals.items()}


def draw_breakdown(record, _):
    scenes = scenes_of(record.rows)
    groups = grouped([row for row in record.rows if not is_baseline(row["pipeline"])], "table", "pipeline", "variant")
    columns = min(5, len(groups))
    lines = math.ceil(len(groups) / max(columns, 1))
    if not groups:
        return []
    page = Page(DOUBLE, lines * (14 + 5.2 * len(scenes)), lines, columns, sharex=True, sharey=True)
    looks = Looks()
    for panel, ((table, pipeline, variant), rows) in zip(page.panels.flat, sorted(groups.items())):
        for scene, of_scene in grouped(rows, "scene").items():
            left = 0
            for name, share in shares_of(of_scene).items():
                look = looks.bar(name)
                panel.barh(scenes.index(scene), share, left=left, height=0.75, **look)
                if share >= 2.8 * columns:  # wide enough for two digits
                    panel.text(left + share / 2, scenes.index(scene), f"{share:.0f}", ha="center", va="center",
                               fontsize=SMALL, bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.6})
                page.legend(name, Patch(**look))
                left += share
        panel.set_title(textwrap.fill(f"I-{table}: {label_of(pipeline, variant)}", 24))
        panel.set(xlim=(0, 100), ylim=(len(scenes) - 0.5, -0.5), xticks=[0, 50, 100])
        scene_axis(panel, range(len(scenes)), scenes)
    page.unused(len(groups))
    for panel in list(page.panels.flat)[max(0, len(groups) - columns):len(groups)]:
        panel.set_xlabel("share of time, %")
        panel.tick_params(axis="x", labelbottom=True)
    return [("breakdown", page)]


def false_positives(rows, say):
    """Percent of a motion's pairs of non-adjacent leaves that have no contact; motions without such pairs have none."""
    shares = []
    for row in typical(rows):
        pairs = row["element_pairs"] - row["adjacent_pairs"]
        if pairs > 0:
            shares.append(100 * (1 - row["touching_pairs"] / pairs))
    left_out = len(typical(rows)) - len(shares)
    if left_out:
        say(f"false-positives: {rows[0]['scene']}: {left_out} motions without pairs of non-adjacent leaves; left out")
    return shares


def draw_false_positives(record, say):
    preferred = ["VolCCD-2011", "VolCCD", "NavCCD-2011", "NavCCD"]
    rank = {name: i for i, name in enumerate([*preferred, *sorted({row["pipeline"] for row in record.rows})][::-1])}
    shares = {}
    for scene, rows in grouped(record.rows, "scene").items():
        groups = grouped(rows, "variant", "pipeline", "table")
        chosen = min(groups, key=lambda key: (key[0], -rank[key[1]], key[2]))
        shares[scene] = (chosen[1], false_positives(groups[chosen], say))
    scenes = [scene for scene in scenes_of(record.rows) if shares[scene][1]]
    if not scenes:
        return []
    page = Page(SINGLE, 14 + 6 * len(scenes))
    panel = page.panels[0][0]
    band = panel.axvspan(90, 99, facecolor="#dddddd", hatch="////", edgecolor="#bbbbbb")
    page.legend("paper (Figure 4): 90 to 99 %", band)
    looks = Looks()
    for i, scene in enumerate(scenes):
        pipeline, values = shares[scene]
        middle, look = statistics.median(values), looks.marker(pipeline, markersize=5)
        panel.plot([min(values), max(values)], [i, i], color=look["color"], linewidth=1, marker="|", markersize=6)
        panel.plot([middle], [i], **look)
        panel.annotate(f"{middle:.2f}", (middle, i), (0, 4), textcoords="offset points", ha="center", fontsize=SMALL)
        page.legend(f"non-adjacent leaf pairs, {pipeline}: median, range", Line2D([], [], **{**look, "linestyle": "-"}))
    low = min(85, math.floor(min(min(shares[scene][1]) for scene in scenes) / 10) * 10)
    panel.set(xlim=(low, 100 + (100 - low) * 0.1), ylim=(len(scenes) - 0.5, -0.8))
    panel.set_xlabel("leaf pairs that touch nothing, %")
    scene_axis(panel, range(len(scenes)), scenes)
    return [("false-positives", page)]


FUNNEL = {"element pairs": lambda row: row["element_pairs"],
          "surviving pairs": lambda row: row["surviving_pairs"],
          "assigned tests": lambda row: row["owned_tests"] + row["orphan_tests"],
          "tests performed": tests,
          "contacts": lambda row: row["contacts"]}


def draw_funnel(record, say):
    """Of the last table (c, of `inclusion`): pipelines that are no baselines."""
    rows = [row for row in record.rows if not is_baseline(row["pipeline"])]
    if not rows:
        return []
    tables = sorted({row["table"] for row in rows})
    rows = [row for row in rows if row["table"] == tables[-1]]
    if len(tables) > 1:
        say(f"funnel: table {tables[-1]} is drawn; tables {', '.join(tables[:-1])} are not in this figure")
    scenes, looks = scenes_of(rows), pipeline_looks()
    columns = min(3, len(scenes))
    lines = math.ceil(len(scenes) / columns)
    page = Page(DOUBLE if columns > 1 else SINGLE, lines * 48, lines, columns, sharex=True, sharey=True)
    every = []
    for panel, scene in zip(page.panels.flat, scenes):
        panel.set(title=scene, yscale="log")
        panel.grid(axis="y")
        counts = {label_of(*key): [mean_count(of_key, count) for count in FUNNEL.values()] for key, of_key
                  in grouped([row for row in rows if row["scene"] == scene], "pipeline", "variant").items()}
        every.append((panel, counts))
    values = [value for _, counts in every for line in counts.values() for value in line]
    low, zero = log_limits(page.panels.flat[0].set_ylim, values, 20)
    for panel, counts in every:
        draw_funnel_lines(page, panel, counts, looks, low)
        log_axis(panel.yaxis, zero)
    page.unused(len(scenes))
    for panel in list(page.panels.flat)[max(0, len(scenes) - columns):len(scenes)]:
        panel.tick_params(axis="x", labelbottom=True)
    for line in page.panels:
        line[0].set_ylabel(f"mean of a motion (I-{tables[-1]})")
    return [("funnel", page)]


def draw_funnel_lines(page, panel, counts, looks, low):
    """Numbers stand above the first line and below the last; zeros at the lower end of the axis."""
    first = next(iter(counts.values()))
    for i, (label, values) in enumerate(counts.items()):
        look = looks.line(label)
        panel.plot(range(len(values)), [max(value, low) for value in values], clip_on=False, **look)
        page.legend(label, Line2D([], [], **look))
        if i not in (0, len(counts) - 1):
            continue
        for x, value in enumerate(values):
            above = i == 0 or value <= low
            if i == 0 or number(value, 2) != number(first[x], 2):
                panel.annotate(number(value, 2), (x, max(value, low)), (0, 4 if above else -4), ha="center",
                               textcoords="offset points", va="bottom" if above else "top", fontsize=SMALL,
                               bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.2, "alpha": 0.8})
    panel.set_xlim(-0.5, len(FUNNEL) - 0.5)
    panel.set_xticks(range(len(FUNNEL)), FUNNEL, rotation=40, ha="right", rotation_mode="anchor")


# --- culling ----------------------------------------------------------------------------------------------------------

def draw_culling(record, _):
    scenes = scenes_of(record.rows)
    looks = Looks()
    columns = min(2, len(scenes))
    lines = math.ceil(len(scenes) / columns)
    page = Page(DOUBLE if columns > 1 else SINGLE, 62 * lines, lines, columns)
    for panel, scene in zip(page.panels.flat, scenes):
        groups = grouped([row for row in record.rows if row["scene"] == scene], "pipeline", "variant")
        bars = []
        for (group, column), (i, (key, rows)) in itertools.product(enumerate(COUNTS), enumerate(groups.items())):
            # A, B and C have settings that their names stand for.
            label = key[0] if [name for name, _ in groups].count(key[0]) == 1 else label_of(*key)
            bars.append(Bar(group * (len(groups) + 1) + i, label, sum(row[column] for row in typical(rows)),
                            mean_count(rows, lambda row, column=column: row[column]),
                            PAPER_TESTS.get(scene, {}).get(key[0].split(" ")[0], (None, None))[group]))
        values = [value for bar in bars for value in (bar.total, bar.mean, bar.printed or bar.total)]
        low, zero = log_limits(panel.set_ylim, values, 3)
        panel.set(yscale="log", title=scene, ylabel="elementary tests")
        panel.grid(axis="y")
        log_axis(panel.yaxis, zero)
        for bar in bars:
            draw_bar(page, panel, bar, looks, low)
        names = {(len(groups) - 1) // 2: "VF tests", (len(groups) - 1) // 2 + len(groups): "EE tests"}
        labels = [f"{number(bar.total)}\n{names.get(i, '')}" for i, bar in enumerate(bars)]
        panel.set_xticks([bar.x for bar in bars], labels, linespacing=1.6, fontsize=SMALL)
        panel.tick_params(axis="x", length=0)
    page.unused(len(scenes))
    return [("culling", page)]


@dataclasses.dataclass(frozen=True)
class Bar:
    x: int
    label: str
    total: int
    mean: float
    printed: float | None


def draw_bar(page, panel, bar, looks, low):
    look = looks.bar(bar.label)
    panel.bar(bar.x, max(bar.total, low) - low, bottom=low, width=0.85, **look)
    page.legend(f"{bar.label}: sum of all motions", Patch(**look))
    mark = {"marker": "_", "markersize": 13, "color": "black", "markeredgewidth": 2.2, "linestyle": "none"}
    panel.plot([bar.x], [max(bar.mean, low)], **{**mark, "color": "white", "markeredgewidth": 4, "markersize": 15})
    panel.plot([bar.x], [max(bar.mean, low)], **mark)
    page.legend("mean of a motion", Line2D([], [], **{**mark, "markersize": 9}))
    if bar.printed:
        panel.plot([bar.x], [bar.printed], **PAPER_MARK)
        page.legend("paper (Tables II and III, as printed)", Line2D([], [], **PAPER_MARK))


# --- ablation ---------------------------------------------------------------------------------------------------------

NOT_RECORDED = "broad phase not recorded"


def broad_phases(record):
    """By (table, pipeline, variant), of the plan in the provenance."""
    result = {}
    for run in record.provenance.get("plan", {}).get("runs", []):
        for entrant in run["entrants"]:
            result[entrant["table"], entrant["pipeline"], entrant["variant"]] = entrant["stages"]["broad_phase"]["name"]
    return result


def ablation_lines(record):
    """[(broad phase, label, {scene: (seconds relative to the scene's best, tests)})], one broad phase after another."""
    best, cells, planned = {}, {}, broad_phases(record)
    for key, rows in grouped(record.rows, "table", "pipeline", "variant", "scene").items():
        table, pipeline, variant, scene = key
        setting = re.search(r"(?:^|\s)broad-phase=([\w-]+)", variant)
        broad_phase = setting[1] if setting else planned.get((table, pipeline, variant), NOT_RECORDED)
        others = re.sub(r"(?:^|\s)broad-phase=[\w-]+", "", variant).strip()
        label = others or "none" if pipeline == broad_phase else label_of(pipeline, others)
        time = median_over_motions(rows, seconds)
        best[scene] = min(time, best.get(scene, math.inf))
        cells.setdefault((broad_phase, label), {})[scene] = (time, mean_count(rows, tests))
    order = list(dict.fromkeys(broad_phase for broad_phase, _ in cells))
    ordered = sorted(cells.items(), key=lambda cell: order.index(cell[0][0]))
    return [(*key, {scene: (time / best[scene], count) for scene, (time, count) in scenes.items()})
            for key, scenes in ordered]


def draw_ablation(record, say):
    tables = grouped(record.rows, "table")
    result = []
    for table, rows in tables.items():
        name = "ablation" if len(tables) == 1 else "ablation-" + re.sub(r"[^\w.-]+", "-", table)
        lines = ablation_lines(record.with_rows(rows))
        for first in range(0, len(lines), LINES_OF_A_PAGE):
            more = f"-{first // LINES_OF_A_PAGE + 1}" if len(lines) > LINES_OF_A_PAGE else ""
            result.append((name + more, ablation_page(lines[first:first + LINES_OF_A_PAGE], scenes_of(rows))))
        if any(line[0] == NOT_RECORDED for line in lines):
            say(f"{name}: neither the variant nor the provenance names the broad phase of some rows")
    return result


def ablation_page(lines, scenes):
    labels, heights, y = [], [], 0.0
    page = Page(DOUBLE, 0, 1, 2, sharey=True)
    left, right = page.panels[0]
    for i, (broad_phase, label, _) in enumerate(lines):
        if i == 0 or lines[i - 1][0] != broad_phase:
            y += 1.1 if i else 0.2
            left.text(-0.02, y, broad_phase, transform=left.get_yaxis_transform(), ha="right", va="center",
                      weight="bold")
            y += 1.0
        labels.append(textwrap.fill(label, 46, break_on_hyphens=False))
        y += 0.4 * labels[-1].count("\n")
        heights.append(y)
        y += 1 + 0.4 * labels[-1].count("\n")
    looks, pitch = Looks(scenes), 0.5 / len(scenes)
    for height, (_, _, cells) in zip(heights, lines):
        for panel in (left, right):
            panel.axhline(height, color="#dddddd", linewidth=0.4, zorder=0)
        for scene, (ratio, count) in cells.items():
            at = height + pitch * (scenes.index(scene) - (len(scenes) - 1) / 2)
            look = {**looks.marker(scene), "linestyle": "none", "clip_on": False}
            left.plot([ratio], [at], **look)
            right.plot([max(count, 0.5)], [at], **look)
            page.legend(scene, Line2D([], [], **look))
            if len(scenes) == 1:
                for panel, value, text in ((left, ratio, times(ratio)), (right, max(count, 0.5), number(count))):
                    panel.annotate(text, (value, height), (5, 0), textcoords="offset points", va="center",
                                   fontsize=SMALL)
    room = 3 if len(scenes) == 1 else 1.4
    left.set(xscale="log", xlabel="median time / the scene's best", ylim=(y - 0.4, -0.4))
    left.set_xlim(0.9, room * max(ratio for _, _, cells in lines for ratio, _ in cells.values()))
    right.set(xscale="log", xlabel="tests per motion (mean)")
    log_limits(right.set_xlim, [max(count, 0.5) for _, _, cells in lines for _, count in cells.values()], room)
    scene_axis(left, heights, labels)
    right.tick_params(axis="y", length=0)
    log_axis(left.xaxis)
    log_axis(right.xaxis)
    page.size = (page.size[0], (12 + 3.9 * y) / INCH)
    return page


# --- scaling ----------------------------------------------------------------------------------------------------------

QUANTITIES = {"time, s": lambda rows: median_over_motions(rows, seconds),
              "memory, bytes": lambda rows: max(row["workspace_bytes"] for row in rows),
              "elementary tests per motion": lambda rows: mean_count(rows, tests)}


def exponent(lines):
    """Slope of log y against log x, one for all lines of points, each with its own height, and its standard error (None
    where there are no more points than unknowns); None where x does not vary."""
    logs = [[(math.log(x), math.log(y)) for x, y in points if y > 0] for points in lines]
    logs = [points for points in logs if points]
    centred = [(x - statistics.fmean(p[0] for p in points), y - statistics.fmean(p[1] for p in points))
               for points in logs for x, y in points]
    across = sum(x * x for x, _ in centred)
    if across < 1e-12:
        return None
    slope = sum(x * y for x, y in centred) / across
    free = len(centred) - len(logs) - 1
    rest = sum((y - slope * x) ** 2 for x, y in centred)
    return slope, math.sqrt(rest / free / across) if free > 0 else None


def exponent_text(fit):
    if fit is None:
        return "no exponent"
    return f"{fit[0]:.2f} ± {fit[1]:.2f}" if fit[1] is not None else f"{fit[0]:.2f} (no spread)"


def scaling_lines(rows, prefix, column):
    """{pipeline with its other settings: {scene: [(x, rows)] by x}}, of rows whose variant begins with the prefix."""
    result = {}
    for (pipeline, variant, scene), group in grouped(rows, "pipeline", "variant", "scene").items():
        others = " ".join(word for word in variant.split() if not word.startswith(prefix))
        x = statistics.median(row[column] for row in group)
        result.setdefault(label_of(pipeline, others), {}).setdefault(scene, []).append((x, group))
    return {label: {scene: sorted(points, key=lambda point: point[0]) for scene, points in scenes.items()}
            for label, scenes in result.items()}


def draw_scaling_page(record, prefix, column, xlabel, say):
    rows = [row for row in record.rows if row["variant"].startswith(prefix)]
    if not rows:
        return None
    lines, scenes = scaling_lines(rows, prefix, column), scenes_of(rows)
    looks, marks = pipeline_looks(), Looks(scenes)
    page = Page(DOUBLE, 78, 1, len(QUANTITIES))
    for panel, (ylabel, measure) in zip(page.panels.flat, QUANTITIES.items()):
        handles = {}
        for label, of_scene in lines.items():
            points = {scene: [(x, measure(group)) for x, group in groups] for scene, groups in of_scene.items()}
            look = looks.line(label)
            for scene, xy in points.items():
                positive = [(x, y) for x, y in xy if y > 0]
                if len(positive) < len(xy):
                    say(f"scaling, {prefix}: {scene}, {label}: {ylabel} is 0 at {len(xy) - len(positive)} points, "
                        "which a logarithmic axis does not show")
                look["marker"] = marks.marker(scene)["marker"]
                panel.plot([x for x, _ in positive], [y for _, y in positive], **look)
            handles[f"{label}: {exponent_text(exponent(points.values()))}"] = Line2D([], [], **{**look, "marker": ""})
        panel.set(xscale="log", yscale="log", xlabel=xlabel, ylabel=ylabel)
        panel.grid()
        log_axis(panel.xaxis)
        log_axis(panel.yaxis)
        panel.legend(handles.values(), handles.keys(), loc="lower center", bbox_to_anchor=(0.45, 1), fontsize=SMALL,
                     title="exponent ± std. error", title_fontsize=SMALL, handlelength=2.6, borderaxespad=0.2)
    for scene in scenes:
        page.legend(scene, Line2D([], [], linestyle="none", marker=marks.marker(scene)["marker"], color="black"))
    return page


def draw_scaling(record, say):
    page = draw_scaling_page(record, "size=", "elements", "elements", say)
    others = grouped([row for row in record.rows if not row["variant"].startswith(("size=", "motion="))], "variant")
    for variant, rows in others.items():
        say(f"scaling: {len(rows)} rows with the variant '{variant}' are neither of size= nor of motion=; not drawn")
    return [("scaling", page)] if page else []


def draw_scaling_motion(record, say):
    rows = [row for row in record.rows if row["variant"].startswith("motion=")]
    check_columns(record.with_rows(rows), ("moved_edges",))
    page = draw_scaling_page(record, "motion=", "moved_edges", "motion per step, edge lengths", say)
    return [("scaling-motion", page)] if page else []


# --- all --------------------------------------------------------------------------------------------------------------

PAIRS = ("element_pairs", "adjacent_pairs")
SCALING = ("seconds", "elements", "workspace_bytes", *COUNTS)
# Experiment: its figures, each with the function that draws it and the columns that this reads.
FIGURES = {
    "table1": {"speedup": (draw_speedup, ("seconds", "topology_seconds")),
               "breakdown": (draw_breakdown, ("seconds", *STAGES)),
               "false-positives": (draw_false_positives, ("seconds", *PAIRS, "touching_pairs")),
               "funnel": (draw_funnel, ("seconds", *PAIRS, "surviving_pairs", "owned_tests", "orphan_tests", *COUNTS,
                                        "contacts"))},
    "culling": {"culling": (draw_culling, ("seconds", *COUNTS))},
    "ablation": {"ablation": (draw_ablation, ("seconds", *COUNTS))},
    "scaling": {"scaling": (draw_scaling, SCALING), "scaling-motion": (draw_scaling_motion, SCALING)},
}


def say(text):
    print(f"plot_results.py: {text}")


def records_in(folder, wanted):
    """Those of experiments with a wanted figure, checked; says what has none."""
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
    """Of the names of figures: what is not as usual."""
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
    parser = argparse.ArgumentParser(prog="plot_results.py", description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
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
        print(f"plot_results.py: {problem}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
