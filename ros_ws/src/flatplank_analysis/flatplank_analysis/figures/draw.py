# SPDX-License-Identifier: Apache-2.0
"""Draws figures, and lists their points."""

from __future__ import annotations

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure as Canvas
from matplotlib.gridspec import SubplotSpec
from matplotlib.ticker import MaxNLocator

from flatplank_analysis.figures.spec import INK, MUTED, PALETTE, Figure, Panel, Series
from flatplank_analysis.pages.book import Book, Picture

MAX_POINTS = 700
"""most points of a line in a figure; the CSV has all"""
LEGEND_WIDTH, LEGEND_MARK = 54, 4
"""characters that fit above the axes, and width of a marker in characters"""
WIDTH, HEIGHT = 6.4, 3.7
"""size of one panel [inch]"""
STRIP = 0.4
"""height of the strip below a panel, relative to the panel"""
END_SHARE = 50
"""a label stands at the mean of the last one of so many parts of its line"""
MARGIN = 0.05
"""room above and below the visible values, as a share of their range"""
CONSTANT = 2e-3
"""least range of an axis, as a share of the largest value"""

RC = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans"],
    "font.size": 9.0,
    "axes.labelsize": 9.0,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": MUTED,
    "axes.labelcolor": INK,
    "axes.linewidth": 0.8,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#e4e8ed",
    "grid.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": MUTED,
    "ytick.color": MUTED,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8.5,
    "ytick.labelsize": 8.5,
    "legend.frameon": False,
    "legend.fontsize": 8.5,
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "svg.fonttype": "none",
    "axes.unicode_minus": True,
}

#: keyword arguments of `plot` per style
STYLES: dict[str, dict] = {
    "line": {"linewidth": 1.4},
    "model": {"linewidth": 1.3, "linestyle": (0, (4, 2)), "color": INK},
    "dashed": {"linewidth": 1.4, "linestyle": (0, (4, 2))},
    "curve": {"linewidth": 1.6},
    "points": {"linestyle": "none", "marker": "o", "markersize": 5},
    "joined": {"linewidth": 1.2, "marker": "o", "markersize": 4.5},
    "open": {
        "linewidth": 1.0,
        "linestyle": (0, (4, 2)),
        "marker": "o",
        "markersize": 4.5,
        "markerfacecolor": "white",
    },
    "cross": {"linestyle": "none", "marker": "x", "markersize": 7},
    "square": {"linestyle": "none", "marker": "s", "markersize": 8, "markerfacecolor": "none"},
    "hollow": {"linestyle": "none", "marker": "o", "markersize": 6, "markerfacecolor": "white"},
}


def canvas(figure: Figure) -> Canvas:
    """A matplotlib figure; no global state is touched."""
    count = max(len(figure.panels), 1)
    rows, columns = (count, 1) if figure.stacked else (1, count)
    width = WIDTH if columns == 1 else 4.4 * columns
    share = 1.0 + STRIP * any(panel.strip for panel in figure.panels)
    height = (2.4 if figure.stacked and rows > 1 else HEIGHT) * rows * share
    out = Canvas(figsize=(width, height), layout="constrained")
    FigureCanvasAgg(out)
    grid = out.add_gridspec(rows, columns)
    drawn: list[tuple[Axes, Panel]] = []
    for k, panel in enumerate(figure.panels):
        drawn += _with_strip(out, grid[k // columns, k % columns], panel)
    for axis, panel in drawn:
        _panel(axis, panel)
    out.draw_without_rendering()
    for axis, panel in drawn:
        _off_the_lines(axis, bool(panel.title))
    return out


def _with_strip(out: Canvas, cell: SubplotSpec, panel: Panel) -> list[tuple[Axes, Panel]]:
    """Axes of a panel and of its strip."""
    if panel.strip is None:
        return [(out.add_subplot(cell), panel)]
    upper, lower = cell.subgridspec(2, 1, height_ratios=(1.0, STRIP))
    axis = out.add_subplot(upper)
    axis.tick_params(labelbottom=False)
    return [(axis, panel), (out.add_subplot(lower, sharex=axis), panel.strip)]


def _panel(axis: Axes, panel: Panel) -> None:
    colors = iter(PALETTE * 4)
    labels = []
    for series in panel.series:
        color = series.color or STYLES[series.style].get("color") or next(colors)
        _series(axis, series, color, panel.x_range)
        if series.end_label:
            labels.append((series, color))
    for mark in panel.marks:
        axis.axvline(mark, color=MUTED, linewidth=0.8, linestyle=(0, (2, 2)), zorder=0.5)
    axis.set_xlabel(panel.x_label)
    axis.set_ylabel(panel.y_label)
    if panel.title:
        axis.set_title(panel.title)
    if "x" in panel.logarithmic:
        axis.set_xscale("log")
    else:
        axis.xaxis.set_major_locator(MaxNLocator(nbins=7, steps=[1, 2, 5, 10]))
        axis.ticklabel_format(axis="x", useOffset=False)
    if "y" in panel.logarithmic:
        axis.set_yscale("log")
    else:
        axis.ticklabel_format(axis="y", useOffset=False)
    if panel.x_range:
        axis.set_xlim(*panel.x_range)
        axis.set_ylim(*_visible(axis, panel))
    # values that are constant except for rounding are drawn as constant
    low, high = axis.get_ylim()
    missing = CONSTANT * max(abs(low), abs(high)) - (high - low)
    if missing > 0.0:
        axis.set_ylim(low - missing / 2.0, high + missing / 2.0)
    _end_labels(axis, labels)
    _legend(axis, panel)


def _visible(axis: Axes, panel: Panel) -> tuple[float, float]:
    """Range of what lies within the shown part of the horizontal axis, with a margin."""
    low, high = panel.x_range or axis.get_xlim()
    seen = [s.y[(s.x >= low) & (s.x <= high) & np.isfinite(s.y)] for s in panel.series]
    values = np.concatenate([*seen, np.zeros(0)])
    if not values.size or "y" in panel.logarithmic:
        return axis.get_ylim()
    least, most = float(values.min()), float(values.max())
    room = MARGIN * (most - least)
    return least - room, most + room


def _legend(axis: Axes, panel: Panel) -> None:
    """Add a legend where there are several series; above the axes when lines fill them."""
    shown = [s for s in panel.series if s.legend and not s.end_label and s.label]
    if len(panel.series) < 2 or not shown:
        return
    if len(shown) == len(panel.series) or panel.title:
        axis.legend(loc="best")
    else:
        _legend_above(axis)


def _legend_above(axis: Axes) -> None:
    handles, labels = axis.get_legend_handles_labels()
    place = {"loc": "lower right", "bbox_to_anchor": (1.0, 1.0), "borderaxespad": 0.2}
    longest = max(map(len, labels)) + LEGEND_MARK
    axis.legend(handles, labels, ncols=max(1, min(len(labels), LEGEND_WIDTH // longest)), **place)


def _off_the_lines(axis: Axes, titled: bool) -> None:
    """Where a drawn legend lies on a line, put it above the axes; beside a title, make room for
    it over the lines."""
    legend = axis.get_legend()
    if legend is None:
        return
    box = legend.get_window_extent()
    paths = (line.get_transform().transform_path(line.get_path()) for line in axis.get_lines())
    if not any(path.intersects_bbox(box, filled=False) for path in paths):
        return
    if not titled:
        _legend_above(axis)
        return
    low, high = axis.transAxes.inverted().transform(box.corners())[[0, -1], 1]
    least, most = axis.get_ylim()
    axis.set_ylim(least, least + (most - least) / (1.0 - (high - low) - MARGIN))
    axis.legend(loc="upper right")


def _series(
    axis: Axes, series: Series, color: str, shown_range: tuple[float, float] | None
) -> None:
    x, y = series.x, series.y
    if series.error is None:
        x, y = thinned(x, y, shown_range)
    shown = series.legend and not series.end_label
    label = series.label if shown else "_" + series.label
    style = {**STYLES[series.style], "color": color}
    if series.style == "hollow":
        style["markeredgecolor"] = color
    if series.error is None:
        axis.plot(x, y, label=label, **style)
    else:
        axis.errorbar(x, y, yerr=series.error, label=label, capsize=2.5, elinewidth=1.0, **style)


def _end_labels(axis: Axes, labels: list[tuple[Series, str]]) -> None:
    """Labels at the right end of the lines, moved apart where they would overlap."""
    if not labels:
        return
    low, high = axis.get_ylim()
    left, right = axis.get_xlim()
    gap = 0.052 * (high - low)
    ends = sorted(((_last(s, right), s.label, c) for s, c in labels), key=lambda e: e[0])
    places = [end for end, _, _ in ends]
    for _ in range(200):
        moved = False
        for i in range(len(places) - 1):
            short = gap - (places[i + 1] - places[i])
            if short > 1e-9 * gap:
                places[i] -= short / 2
                places[i + 1] += short / 2
                moved = True
        if not moved:
            break
    axis.set_xlim(left, right)
    style = {"xytext": (5, 0), "textcoords": "offset points", "va": "center", "fontsize": 8.5}
    for place, (_, text, color) in zip(places, ends, strict=True):
        axis.annotate(text, (right, place), color=color, annotation_clip=False, **style)


def _last(series: Series, right: float) -> float:
    """Value at the right end: mean over the last part of a line, the last point of a few."""
    shown = series.y[np.isfinite(series.y) & (series.x <= right)]
    return float(np.mean(shown[-(1 + shown.size // END_SHARE) :])) if shown.size else 0.0


def thinned(
    x: np.ndarray, y: np.ndarray, shown: tuple[float, float] | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """At most MAX_POINTS evenly chosen points, without NaN; those of the shown range, if given."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    good = np.isfinite(x) & np.isfinite(y)
    if shown is not None:
        good &= (x >= shown[0]) & (x <= shown[1])
    x, y = x[good], y[good]
    if x.size <= MAX_POINTS:
        return x, y
    chosen = np.unique(np.linspace(0, x.size - 1, MAX_POINTS).round().astype(int))
    return x[chosen], y[chosen]


def save(book: Book, figure: Figure) -> Picture:
    """Draw a figure and save it in a book."""
    with matplotlib.rc_context(RC):
        return book.add(figure.name, canvas(figure), table_of(figure), figure.wide)


def table_of(figure: Figure) -> list[list]:
    """All points of a figure: panel, series, x, y, error; a strip follows its panel."""
    rows: list[list] = []
    for number, panel in enumerate(figure.with_strips, start=1):
        rows.append([f"# {number}", panel.title, panel.x_label, panel.y_label, ""])
        for series in panel.series:
            error = series.error if series.error is not None else [""] * len(series.x)
            points = zip(series.x, series.y, error, strict=True)
            rows += [[number, series.label, *point] for point in points]
    return rows
