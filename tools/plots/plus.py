"""The experiment `plus`: whole steps of VolCCD, VolCCD+ without and with flood, and on the boundary alone."""

from matplotlib.patches import Patch

from .page import DOUBLE, SMALL, Looks, Page, log_axis, log_limits, number, scene_axis
from .records import grouped, label_of, mean_over_steps, scenes_of, seconds_with_edit


def steady(rows):
    """Rows of the steps after the first of their window; a window of one step keeps its row."""
    result = []
    for window in grouped(rows, "window").values():
        later = [row for row in window if row["step"] != row["window"]]
        result += later or window
    return result


def mean_ms(rows):
    return 1e3 * mean_over_steps(steady(rows), seconds_with_edit)


def draw_plus(record, _):
    pages = []
    for table, rows in grouped(record.rows, "table").items():
        name = "plus" if not table else "plus-" + table.replace(" ", "-")
        pages.append((name, plus_page(rows, table)))
    return pages


def plus_page(rows, title):
    scenes = scenes_of(rows)
    bars = {scene: [(label_of(*key), mean_ms(some)) for key, some in
                    grouped([row for row in rows if row["scene"] == scene], "pipeline", "variant").items()]
            for scene in scenes}
    slots = max(map(len, bars.values()))
    pitch = slots + 1.2
    page = Page(DOUBLE, 12 + 3.1 * pitch * len(scenes))
    panel, looks = page.panels[0][0], Looks()
    panel.set(xscale="log", xlabel="ms a step (mean over steps)", title=title, ylim=(len(scenes) * pitch - 1, -1))
    low, _ = log_limits(panel.set_xlim, [ms for some in bars.values() for _, ms in some], 2.8)
    panel.grid(axis="x")
    log_axis(panel.xaxis)
    for i, scene in enumerate(scenes):
        for j, (label, ms) in enumerate(bars[scene]):
            look = looks.bar(label)
            panel.barh(i * pitch + j, ms - low, left=low, height=0.85, **look)
            panel.annotate(number(ms), (ms, i * pitch + j), (3, 0), textcoords="offset points", va="center",
                           fontsize=SMALL)
            page.legend(label, Patch(**look))
    scene_axis(panel, [i * pitch + (slots - 1) / 2 for i in range(len(scenes))], scenes)
    return page
