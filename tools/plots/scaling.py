"""Scaling: time, memory and tests against elements and against movement per step."""

import math
import statistics

from matplotlib.lines import Line2D

from .page import DOUBLE, SMALL, Looks, Page, log_axis, pipeline_looks
from .records import check_columns, grouped, label_of, mean_count, mean_over_steps, scenes_of, seconds, tests

QUANTITIES = {"time, s": lambda rows: mean_over_steps(rows, seconds),
              "memory, bytes": lambda rows: max(row["workspace_bytes"] for row in rows),
              "elementary tests per step": lambda rows: mean_count(rows, tests)}


def exponent(lines):
    """The common slope of log y against log x for several lines of points with different offsets, and its standard
    error (None if there are no more points than unknowns). Returns None if x does not vary."""
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
    """{pipeline and its other settings: {scene: [(x, rows)], ascending in x}} for rows whose variant begins with
    the prefix."""
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
    page = draw_scaling_page(record, "motion=", "moved_edges", "movement per step, edge lengths", say)
    return [("scaling-motion", page)] if page else []
