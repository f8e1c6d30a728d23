"""Figures 4 and 11 and the funnel: the time of the stages of a pipeline, and what passes each of them."""

import collections
import math
import statistics
import textwrap

from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .page import DOUBLE, SINGLE, SMALL, Looks, Page, log_axis, log_limits, number, pipeline_looks, scene_axis
from .records import grouped, is_baseline, label_of, mean_count, scenes_of, tests, typical


def parts_of(row):
    """Seconds of the parts of Figure 11. With several threads, the times of a stage are summed over all workers."""
    parts = {"k-DOPs": row["bounds_s"],
             "tree": row["broad_phase_prepare_s"] - row["bounds_s"],
             "traversal and culling": row["broad_phase_run_s"] + sum(
                 row[f"{role}_{part}_s"] for role in ("element_culling", "assignment") for part in ("prepare", "run"))}
    others = {"orphans": "O-Set", "feature_filter": "feature filters", "narrow_phase": "elementary tests"}
    for role, name in others.items():
        parts[name] = row[f"{role}_prepare_s"] + row[f"{role}_run_s"]
    return parts


def shares_of(rows):
    """Share of each part in the time of all steps in per cent, with the remainder."""
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
                if share >= 2.8 * columns:  # the bar is wide enough for two digits
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
    """Per cent of the pairs of non-adjacent leaves that have no contact, by step. Steps without such pairs are
    left out."""
    shares = []
    for row in typical(rows):
        pairs = row["element_pairs"] - row["adjacent_pairs"]
        if pairs > 0:
            shares.append(100 * (1 - row["touching_pairs"] / pairs))
    left_out = len(typical(rows)) - len(shares)
    if left_out:
        say(f"false-positives: {rows[0]['scene']}: {left_out} steps without pairs of non-adjacent leaves; left out")
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
    """Draws the pipelines that are no baselines, from the last table (c, with `inclusion`)."""
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
        line[0].set_ylabel(f"mean of a step (I-{tables[-1]})")
    return [("funnel", page)]


def draw_funnel_lines(page, panel, counts, looks, low):
    """Draws the lines, with numbers above the first and below the last one. Zeros are drawn at the lower end of the
    axis."""
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
