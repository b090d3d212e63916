# SPDX-License-Identifier: Apache-2.0
"""A figure as data: figure and CSV show the same numbers. Colours of all figures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

INK = "#1d2733"
MUTED = "#6b7684"
#: distinguishes up to six lines, also for colour-blind readers
PALETTE = ("#1f6fb2", "#d1672b", "#3b8f6b", "#8b5fa8", "#b8902f", "#5b6672")


@dataclass(frozen=True)
class Series:
    """One line or set of points; arrays of shape (n,)."""

    label: str
    x: np.ndarray
    y: np.ndarray
    style: str = "line"
    """key of `figures.draw.STYLES`"""
    color: str = ""
    """colour; empty: the next of the palette"""
    error: np.ndarray | None = None
    """half length of an error bar"""
    end_label: bool = False
    """True for a label at the end of the line instead of in the legend"""
    legend: bool = True


@dataclass(frozen=True)
class Panel:
    """One pair of axes."""

    x_label: str
    y_label: str
    series: Sequence[Series]
    x_range: tuple[float, float] | None = None
    marks: Sequence[float] = ()
    """vertical lines"""
    logarithmic: str = ""
    """axes with a logarithmic scale: x, y or xy"""
    title: str = ""
    strip: Panel | None = None
    """low panel below with the residual of a model, over the same horizontal axis"""


@dataclass(frozen=True)
class Figure:
    """Panels side by side with one title and a caption."""

    name: str
    """file name without suffix"""
    title: str
    caption: str
    panels: Sequence[Panel] = field(default_factory=tuple)
    source: str = ""
    """number of the figure in the thesis"""
    stacked: bool = False
    """True for panels above each other"""

    @property
    def with_strips(self) -> list[Panel]:
        """All panels, each strip after its panel."""
        both = ((panel, panel.strip) for panel in self.panels)
        return [p for pair in both for p in pair if p is not None]

    @property
    def wide(self) -> bool:
        """True for a figure as wide as the page."""
        return len(self.panels) > 1 and not self.stacked
