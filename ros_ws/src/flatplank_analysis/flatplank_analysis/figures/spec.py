# SPDX-License-Identifier: Apache-2.0
"""A figure as data: what is drawn is what stands in its CSV."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np


@dataclass(frozen=True)
class Series:
    """One line or set of points; arrays of shape (n,)."""

    label: str
    x: np.ndarray
    y: np.ndarray
    style: str = "line"
    """key of `figures.draw.STYLES`: line, model, points, curve, bar"""
    color: str = ""
    """colour, or empty for the next of the palette"""
    error: np.ndarray | None = None
    """half length of an error bar"""
    end_label: bool = False
    """write the label at the end of the line instead of in the legend"""
    legend: bool = True


@dataclass(frozen=True)
class Panel:
    """One pair of axes."""

    x_label: str
    y_label: str
    series: Sequence[Series]
    x_range: tuple[float, float] | None = None
    y_range: tuple[float, float] | None = None
    marks: Sequence[float] = ()
    """vertical lines"""
    title: str = ""


@dataclass(frozen=True)
class Figure:
    """Panels side by side with one title and a caption."""

    name: str
    """file name without suffix"""
    title: str
    caption: str
    panels: Sequence[Panel] = field(default_factory=tuple)
    source: str = ""
    """which figure of the thesis this is"""
    stacked: bool = False
    """panels above each other"""
