# SPDX-License-Identifier: Apache-2.0
"""Errors of the models beside those of Tables 7.1, 7.3, 7.4, H.1 and H.2."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial

from flatplank_analysis.figures import pieces
from flatplank_analysis.report.results import CampaignResult
from flatplank_validation.thesis.lab import Lab
from flatplank_validation.thesis.points import SLIPS, point
from flatplank_validation.thesis.registry import Near, Row

SMALL, LARGE = 41.0 / math.sqrt(3.0), 70.0 / math.sqrt(3.0)
"""largest standard deviation of ten runs at 1 and 5 %, for the mean of three starts [N]"""
BASIS = "largest standard deviation of ten runs at {} %, {} N, over √3 starts"
MAGIC = "mf_contact_point"
"""the model of section 7.3, ‘set to nonlinear dynamics with relaxation behavior’: a contact point
on the carcass spring, whose lag becomes shorter with slip"""
RMSE_WHY = (
    "an RMSE is the error of the model against this tire and this machine: the plant's tire is "
    "another one, the same for driving and braking but for 3 % of its friction, and the preset "
    "has the sizes of the machine's defects only where the thesis gives them"
)
WHY = {
    MAGIC: f"{RMSE_WHY}; why braking has the larger errors, section 7.3 calls ‘unknown’",
}
"""reasons of single models"""


def tolerance(kappa: float) -> Near:
    """Accuracy of a mean of three runs by the thesis's repeatability."""
    if abs(kappa) < 0.03:
        return Near(SMALL, BASIS.format(1, 41))
    return Near(LARGE, BASIS.format(5, 70))


def rmse(model: str, of: CampaignResult, kappa: float, **where: float) -> float:
    """RMSE in the transient part [N]; NaN where the model has no curve."""
    found = point(of, **where).models.get(model)
    if found is None:
        return math.nan
    return next((v for c, v in found.rmse.items() if abs(c.kappa - kappa) < 1e-6), math.nan)


def _of(model: str, kappa: float, repaired: bool, where: Mapping[str, float], lab: Lab) -> float:
    return rmse(model, lab.repaired if repaired else lab.matrix, kappa, **where)


def rmse_rows(
    model: str, printed: Sequence[float], place: str, *, repaired: bool = False, label: str = "",
    where: Mapping[str, float] | None = None,
) -> Iterator[Row]:  # fmt: skip
    """Nine rows, one per slip."""
    words = "reduced play, " if repaired else f"{label}, " if label else ""
    for kappa, value in zip(SLIPS, printed, strict=True):
        yield Row(f"RMSE, {words}κ = {pieces.percent(kappa)}", "N", value, place,
                  partial(_of, model, kappa, repaired, where or {}), tolerance(kappa),
                  WHY.get(model, RMSE_WHY))  # fmt: skip
