"""Appearance of figures: sizes, colours, marks, axes, and a page with its legend and caption."""

import math
import pathlib
import re
import textwrap

from PIL import Image
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

SINGLE, DOUBLE, TALLEST = 85, 175, 235  # width of one column and of two columns, greatest height, in mm
INCH = 25.4
RC = {"svg.fonttype": "none", "svg.hashsalt": "volccd", "font.family": "DejaVu Sans", "font.size": 8,
      "axes.titlesize": 8, "axes.labelsize": 8, "xtick.labelsize": 8, "ytick.labelsize": 8, "legend.fontsize": 8,
      "axes.linewidth": 0.6, "lines.linewidth": 1.0, "lines.markersize": 4.5, "hatch.linewidth": 0.5,
      "axes.axisbelow": True, "grid.linewidth": 0.4, "grid.color": "#cccccc", "legend.frameon": False,
      "text.parse_math": False}
SMALL = 7  # font size in points of captions and of numbers beside marks
# The palette of Okabe and Ito, dark colours first. Names also differ in marker, line style and hatch.
COLOURS = ["#0072B2", "#D55E00", "#009E73", "#000000", "#CC79A7", "#E69F00", "#56B4E9", "#F0E442"]
MARKERS = ["o", "s", "^", "v", "D", "P", "X", "<", ">"]
LINES = ["-", "--", "-.", ":", (0, (5, 1, 1, 1, 1, 1))]
# light colours, on which hatches are visible
BAR_COLOURS = ["#F0E442", "#56B4E9", "#E69F00", "#FFFFFF", "#CC79A7", "#009E73", "#D55E00", "#BBBBBB"]
HATCHES = ["", "////", "||||", "\\\\\\\\", "xxxx", "----", "++++", "//--", "oo"]  # dots would be 250 kB of each SVG
PAPER_MARK = {"marker": "D", "color": "white", "markeredgecolor": "black", "markeredgewidth": 0.8, "linestyle": "none"}


class Looks:
    """Colour, marker, line style and hatch of each name. Names in `known` have the same ones in all figures; other
    names get the next free ones."""

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


class Page:
    """A figure: panels with a legend above and a caption below; its width is that of one or two columns of print."""

    def __init__(self, width, height, rows=1, columns=1, **subplots):
        self.size = (width / INCH, min(height, TALLEST) / INCH)
        self.figure = Figure(figsize=self.size)
        self.panels = self.figure.subplots(rows, columns, squeeze=False, **subplots)
        self.handles = {}

    def legend(self, name, handle):
        self.handles.setdefault(name, handle)

    def unused(self, count):
        """Removes all panels of the grid but the first `count`."""
        for panel in list(self.panels.flat)[count:]:
            panel.remove()

    def fit_legend(self):
        """Draws the legend in as few lines as the width allows; means and the paper's marks come last. None without
        marks."""
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
        """Writes path.svg and path.png. The page is made taller for legend and caption, and the panels keep their
        sizes."""
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
        shorten_paths(f"{path}.svg")
        self.figure.savefig(f"{path}.png", dpi=130, metadata={"Software": None})
        with Image.open(f"{path}.png") as image:  # 64 colours are enough for a figure, and take half of the room
            image.convert("RGB").quantize(64).save(f"{path}.png", optimize=True)


def shorten_paths(path):
    """Coordinates of outlines with two decimals, hundredths of a point."""
    text = pathlib.Path(path).read_text(encoding="utf-8")
    text = re.sub(r' d="[^"]*"', lambda outline: re.sub(r"(\.\d\d)\d+", r"\1", outline.group()), text)
    pathlib.Path(path).write_text(text, encoding="utf-8")


def number(value, digits=3):
    """A short text for a number beside a mark: three digits, or from 1000 on `digits` digits with k, M or G."""
    for limit, unit in ((1e9, " G"), (1e6, " M"), (1e3, " k")):
        if value >= 0.9995 * limit:
            return f"{float(f'{value / limit:.{digits}g}'):g}{unit}"
    return f"{value:.3g}"


def times(ratio):
    return f"{ratio:.2f}×" if ratio < 1 else f"{ratio:.1f}×" if ratio < 99.95 else f"{ratio:.0f}×"


def log_axis(axis, zero=None):
    """Labels a logarithmic axis in plain text at powers of ten, and between them if there are few. Zeros are drawn
    at `zero`, if it is given."""
    low, high = sorted(axis.get_view_interval())
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if high < 100 * low else (1,), numticks=12))
    axis.set_major_formatter(FuncFormatter(lambda x, _: "0" if zero and x < 1.5 * zero else number(x)))
    axis.set_minor_formatter(NullFormatter())


def log_limits(set_limits, values, room):
    """Sets limits that contain all values: from a power of ten below the smallest one (two powers if there are
    zeros) to the largest one times `room`. Returns the lower limit, and the value at which zeros are drawn, or
    None."""
    positive = [value for value in values if value > 0] or [1]
    low = 10.0 ** math.floor(math.log10(min(positive)) - 0.05)
    zeros = min(values, default=1) <= 0
    low = low / 10 if zeros else low
    set_limits(low, max(max(positive) * room, low * 10))
    return low, low if zeros else None


def scene_axis(panel, positions, scenes):
    panel.set_yticks(positions, scenes)
    panel.tick_params(axis="y", length=0)
