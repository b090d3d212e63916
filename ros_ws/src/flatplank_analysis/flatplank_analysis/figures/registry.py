# SPDX-License-Identifier: Apache-2.0
"""Every figure is a function from the results to figures, none where the data do not allow it."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from flatplank_analysis.figures.spec import Figure
from flatplank_analysis.report.results import CampaignResult

Maker = Callable[[CampaignResult], Iterable[Figure]]
#: section of the report -> makers, in the order of the report
MAKERS: dict[str, list[Maker]] = {}


def maker(section: str) -> Callable[[Maker], Maker]:
    """Register a function that makes figures for a section."""

    def register(function: Maker) -> Maker:
        MAKERS.setdefault(section, []).append(function)
        return function

    return register


def make_figures(result: CampaignResult) -> dict[str, list[Figure]]:
    """All figures that the results allow, by section."""
    from flatplank_analysis.figures import (  # noqa: F401  (they register)
        beside,
        chapter6,
        chapter7,
        kinds,
        machine,
        sessions,
        waveforms,
    )

    order = (
        "measurements",
        "repeatability",
        "models",
        "waveforms",
        "special",
        "reference",
        "parameters",
        "radius",
        "machine",
    )
    made = {s: [f for m in MAKERS.get(s, []) for f in m(result)] for s in order}
    return {section: figures for section, figures in made.items() if figures}
