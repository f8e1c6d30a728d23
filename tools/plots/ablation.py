"""Ablations: time and tests of each variant on each broad phase."""

import math
import re
import textwrap

from matplotlib.lines import Line2D

from .page import DOUBLE, INCH, SMALL, Looks, Page, log_axis, log_limits, number, scene_axis, times
from .records import grouped, label_of, mean_count, mean_over_steps, scenes_of, seconds_with_edit, tests

LINES_OF_A_PAGE = 40  # rows of an ablation on one page
NOT_RECORDED = "broad phase not recorded"


def broad_phases(record):
    """The broad phase by (table, pipeline, variant), from the plan in the provenance."""
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
        time = mean_over_steps(rows, seconds_with_edit)
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
    left.set(xscale="log", xlabel="mean time / the scene's best", ylim=(y - 0.4, -0.4))
    left.set_xlim(0.9, room * max(ratio for _, _, cells in lines for ratio, _ in cells.values()))
    right.set(xscale="log", xlabel="tests per step (mean)")
    log_limits(right.set_xlim, [max(count, 0.5) for _, _, cells in lines for _, count in cells.values()], room)
    scene_axis(left, heights, labels)
    right.tick_params(axis="y", length=0)
    log_axis(left.xaxis)
    log_axis(right.xaxis)
    page.size = (page.size[0], (12 + 3.9 * y) / INCH)
    return page
