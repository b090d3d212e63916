# SPDX-License-Identifier: Apache-2.0
"""A page that opens offline, and its figures: each inline as SVG, and beside the page as SVG, PNG
and CSV."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib
import numpy as np
from jinja2 import Environment, FileSystemLoader
from markupsafe import Markup, escape
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator

from flatplank_analysis import words
from flatplank_analysis.pages.csv_text import csv_text
from flatplank_analysis.word import Word
from flatplank_data.files import write_atomic

HERE = Path(__file__).parent
POLYLINE = re.compile(r' d="(M [-\d. ]+(?:\nL [-\d. ]+)+\n?)"')
"""path of an SVG element that consists of straight lines, without a close"""
HEADER = ("panel", "series", "x", "y", "error")
"""columns of the numbers of a figure"""


class Picture(NamedTuple):
    """A figure as a template shows it; see the macro `picture`."""

    name: str
    svg: Markup
    href: str
    """link to its files, without suffix"""
    wide: bool = False


class Book:
    """Figures of a page, saved in a folder beside it."""

    def __init__(self, folder: Path, inside: str = "") -> None:
        """folder: of the page; inside: folder of the figures in it."""
        self.folder, self.inside = folder / inside, inside
        self.folder.mkdir(parents=True, exist_ok=True)

    def add(
        self, name: str, figure: Figure, rows: Sequence[Sequence[Any]] = (), wide: bool = False
    ) -> Picture:
        """Save a drawn figure; rows: its numbers under `HEADER`, else those of its curves, bars
        and maps."""
        path = self.folder / name
        table = csv_text([HEADER, *(rows or numbers_of(figure))])
        write_atomic(path.with_name(f"{name}.csv"), table, durable=False)
        stream = io.StringIO()
        with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": name}):
            figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
        figure.set_layout_engine("none")  # laid out once: this takes as long as drawing
        figure.savefig(path.with_name(f"{name}.png"), dpi=160)
        text = POLYLINE.sub(_shorter, stream.getvalue())
        write_atomic(path.with_name(f"{name}.svg"), text, durable=False)
        href = f"{self.inside}/{name}" if self.inside else name
        return Picture(name, _inline(text, name), href, wide)


def hover(name: str, own: Mapping[str, Word] = {}) -> Markup:
    """A word with its sentence as hover text; a text that is no word as it is.

    own: words beside those of the glossary.
    """
    word = own.get(name) or words.known(name)
    if word is None:
        return escape(name)
    return Markup('<abbr title="{}">{}</abbr>').format(words.told(word), name)


def write_page(
    page: Path, template: str, folder: Path, own_words: Mapping[str, Word] = {}, **values: Any
) -> Path:
    """Write a page by a template of a folder, which extends `base.html.j2`; returns the page.

    own_words: those of the filter `word` beside the glossary, such as names of effects.
    """
    places = FileSystemLoader([folder, HERE])
    environment = Environment(loader=places, autoescape=True, trim_blocks=True, lstrip_blocks=True)
    environment.filters["word"] = partial(hover, own=own_words)
    values = {"parts": (), "about": "", **values}
    write_atomic(page, environment.get_template(template).render(**values), durable=False)
    return page


def numbers_of(figure: Figure) -> list[list[Any]]:
    """Numbers of a figure as its axes show them: points of curves, heights of bars, cells of
    maps; a panel begins with its labels."""
    rows: list[list[Any]] = []
    for number, axes in enumerate(figure.axes, start=1):
        points = list(_points(axes))
        if points:
            names = axes.get_title(loc="left"), axes.get_xlabel(), axes.get_ylabel()
            rows.append([f"# {number}", *names, ""])
            rows += [[number, *point, ""] for point in points]
    return rows


def _points(axes: Axes) -> Iterator[tuple[str, Any, Any]]:
    """Series, x and y of what axes show."""
    ticks = dict(_named_ticks(axes))
    for line in axes.lines:
        x, y = (np.asarray(v, float) for v in line.get_data())
        if len(x) > 2 or line.get_transform() == axes.transData:
            yield from ((_name(line), a, b) for a, b in zip(x, y, strict=True))
    for bars in axes.containers:
        for bar in getattr(bars, "patches", ()):
            x = bar.get_x() + 0.5 * bar.get_width()
            y = bar.get_y() + 0.5 * bar.get_height()
            lying = getattr(bars, "orientation", "") == "horizontal"
            at, value = (y, bar.get_width()) if lying else (x, bar.get_height())
            yield _name(bars), ticks.get(float(round(at)), at), value
    for mesh in axes.collections:
        grid = getattr(mesh, "get_coordinates", None)
        if grid is None:
            continue
        corners, values = grid(), np.ma.filled(mesh.get_array(), np.nan)
        middles = 0.5 * (corners[0, 1:, 0] + corners[0, :-1, 0])
        for row, level in zip(values, corners[:-1, 0, 1] + 0.5, strict=True):
            name = ticks.get(float(level), f"{level:g}")
            yield from ((name, a, b) for a, b in zip(middles, row, strict=True))


def _named_ticks(axes: Axes) -> Iterator[tuple[float, str]]:
    """Place and name of the ticks that have names."""
    for axis in (axes.xaxis, axes.yaxis):
        if isinstance(axis.get_major_locator(), FixedLocator):
            for place, label in zip(axis.get_ticklocs(), axis.get_ticklabels(), strict=True):
                yield float(place), label.get_text().replace("\n", " ")


def _name(artist: Any) -> str:
    label = str(artist.get_label())
    return "" if label.startswith("_") else label


def _shorter(path: re.Match[str]) -> str:
    """A polyline with relative coordinates in tenths of a point: a third of the text."""
    points = np.array(re.findall(r"-?[\d.]+", path[1]), dtype=float).reshape(-1, 2)
    moves = np.diff(np.rint(10.0 * points), axis=0, prepend=0.0) / 10.0
    first, *steps = (f" {x:g} {y:g}".replace(" 0.", " .").replace("-0.", "-.") for x, y in moves)
    return f' d="M{first}l{"".join(steps)}"'.replace(" -", "-")


def _inline(text: str, name: str) -> Markup:
    """The SVG element with unique identifiers, so that a page can contain many."""
    text = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    text = re.sub(r'(<g) id="[^"]*"', r"\1", re.sub(r"\n\s*", "\n", text))
    prefix = re.sub(r"\W", "-", name)
    for pattern in ('id="', 'href="#', r"url\(#"):
        text = re.sub(f"({pattern})", rf"\g<1>{prefix}-", text)
    return Markup(re.sub(r'width="[\d.]+pt" height="[\d.]+pt" ', "", text, count=1))
