"""Tables II and III: elementary tests with and without culling."""

import dataclasses
import itertools
import math

from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from .page import DOUBLE, PAPER_MARK, SINGLE, SMALL, Looks, Page, log_axis, log_limits, number
from .records import COUNTS, grouped, label_of, mean_count, scenes_of, typical

# As printed in Tables II and III: VF and EE tests for A, B and C.
PAPER_TESTS = {"octopi": {"A": (26e6, 312e6), "B": (1.1e6, 6.4e6), "C": (7.9e3, 24e3)},
               "crash": {"A": (8.24e9, 1.6e10), "B": (9.8e7, 3.8e8), "C": (2.3e7, 1.2e8)}}


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
            # The names A, B and C imply their settings.
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
    page.legend(f"{bar.label}: sum of all steps", Patch(**look))
    mark = {"marker": "_", "markersize": 13, "color": "black", "markeredgewidth": 2.2, "linestyle": "none"}
    panel.plot([bar.x], [max(bar.mean, low)], **{**mark, "color": "white", "markeredgewidth": 4, "markersize": 15})
    panel.plot([bar.x], [max(bar.mean, low)], **mark)
    page.legend("mean of a step", Line2D([], [], **{**mark, "markersize": 9}))
    if bar.printed:
        panel.plot([bar.x], [bar.printed], **PAPER_MARK)
        page.legend("paper (Tables II and III, as printed)", Line2D([], [], **PAPER_MARK))
