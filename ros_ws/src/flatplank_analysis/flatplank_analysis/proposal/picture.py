# SPDX-License-Identifier: Apache-2.0
"""Figure and page of a proposal: the free curve with its band, the form over it, and the file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from flatplank_analysis.discovery.report.figures import BLUE, GREY, ORANGE, figure_of
from flatplank_analysis.effects.grammar.file import SUFFIX
from flatplank_analysis.pages.book import Book, write_page
from flatplank_analysis.proposal.propose import Proposal
from flatplank_data.wording import displayed

WIDEST = 3.0
"""largest width of the band, in heights of the form, with which the free curve is drawn"""


@dataclass(frozen=True)
class Lines:
    """Data of the figure in display units; all (points,). No curve where the form is a wave; NaN
    where the runs do not determine it."""

    u: np.ndarray
    form: np.ndarray
    free: np.ndarray | None
    half: np.ndarray | None
    over: str
    unit: str


def lines_of(result: Proposal) -> Lines:
    """Form, and the free curve with its band, shifted onto it: the base takes any constant."""
    s, outcome = result.sentence, result.outcome
    if s is None or outcome is None:
        raise ValueError("nothing is proposed")
    span, curve = s.site.coordinate.span, outcome.curve
    u = curve.u if curve is not None else np.linspace(span.low, span.high, 1000)
    form = np.tensordot(s.sizes, s.shape.values(span, u[None], s.numbers, u[None]), 1)[0]
    along, length = displayed(span.unit, span.low, span.high)
    high = float(np.abs(form).max())
    factor, unit = displayed(s.site.hook.unit, high)
    over = f"{s.site.coordinate.name or 'all runs'} [{length}]"
    what = f"{s.site.hook.words.partition(' that ')[0].removeprefix('a ')} [{unit}]"
    if curve is None:
        return Lines(along * u, factor * form, None, None, over, what)
    weight = 1.0 / np.maximum(curve.half, 1e-12) ** 2
    free = curve.values + np.average(form - curve.values, weights=weight)
    seen = np.where(curve.half <= WIDEST * high, factor, np.nan)
    return Lines(along * u, factor * form, seen * free, seen * curve.half, over, what)


def picture(result: Proposal) -> Figure:
    """Curve, band and form over the coordinate; only the form where it is a wave."""
    lines = lines_of(result)
    u, free, half = lines.u, lines.free, lines.half
    figure = figure_of(8.0, 3.2)
    axes = figure.add_subplot()
    if free is not None and half is not None:
        axes.fill_between(
            u, free - half, free + half, color=GREY, alpha=0.25, lw=0, label="free curve, 90 %",
        )  # fmt: skip
        axes.plot(u, free, color=GREY, lw=1.0)
    assert result.sentence is not None
    shape = result.sentence.shape.name
    axes.plot(u, lines.form, color=ORANGE, lw=1.8, label=f"form: {shape}")
    axes.axhline(0.0, color=BLUE, lw=0.5)
    axes.set_xlabel(lines.over, fontsize=9)
    axes.set_ylabel(lines.unit, fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(fontsize=8, frameon=False)
    return figure


def write_proposal(result: Proposal, folder: Path, campaign: str, about: str = "") -> Path:
    """Write page and figure; return the page. about: where the runs come from."""
    book = Book(folder)
    drawn = book.add("proposal", picture(result)) if result.sentence is not None else None
    return write_page(
        folder / "index.html",
        "proposal.html.j2",
        Path(__file__).parent,
        campaign=campaign,
        about=about,
        result=result,
        sentence=result.sentence.words() if result.sentence else "",
        picture_of=drawn,
        file=f"{result.name}{SUFFIX}" if result.name else "",
    )
