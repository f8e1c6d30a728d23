"""The paper's Figure 3 in numbers: the bullet simulated with contacts among fewer and fewer features."""

from matplotlib.lines import Line2D

from .page import DOUBLE, Looks, Page
from .records import grouped, scenes_of

QUANTITIES = {"velocity of the bullet, m/s": "velocity", "pairs of bullet and plate that overlap": "overlaps_inter",
              "contacts with a feature inside": "interior"}


def draw_feature_sets(record, _):
    """Draws each quantity against time, with one line for each scene."""
    page, looks = Page(DOUBLE, 60, 1, len(QUANTITIES)), Looks(["bullet", "bullet-boundary", "bullet-surface"])
    for panel, (label, column) in zip(page.panels[0], QUANTITIES.items()):
        for scene in scenes_of(record.rows):
            rows = sorted(grouped(record.rows, "scene")[scene], key=lambda row: row["step"])
            look = looks.line(scene) | {"markevery": max(1, len(rows) // 8)}
            panel.plot([1e6 * row["time"] for row in rows], [row[column] for row in rows], **look)
            page.legend(scene, Line2D([], [], **look))
        panel.set(xlabel="time, microseconds", title=label)
        panel.set_ylim(bottom=min(0, *(row[column] for row in record.rows)))
        panel.grid(True)
    return [("feature-sets", page)]
