# SPDX-License-Identifier: Apache-2.0
"""Whether the aligning moment of a file can be used."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from flatplank_analysis.slip_sweeps.axes import SMALL_ALPHA, slope_sign

MOMENT = "mz"
"""channel beside the side force"""
EMPTY = "Mz is left out: 0 in every row"
AHEAD = (
    "Mz is left out: it falls where the slip angle rises, as if the side force acted ahead of the "
    "contact; if the file counts it the other way: --turn mz"
)


def with_usable_moment(
    columns: Mapping[str, np.ndarray],
) -> tuple[dict[str, np.ndarray], tuple[str, ...]]:
    """The columns, ISO W, without an Mz that nobody measured or that has the other sign, and the
    line that says so.

    At small slip angles the side force acts behind the middle of the contact (Pacejka, Tire and
    Vehicle Dynamics, 2012, section 1.2).
    """
    if MOMENT not in columns:
        return dict(columns), ()
    rest = {name: values for name, values in columns.items() if name != MOMENT}
    if not np.nan_to_num(columns[MOMENT]).any():
        return rest, (EMPTY,)
    if slope_sign(columns, MOMENT, "alpha", SMALL_ALPHA) < 0:
        return rest, (AHEAD,)
    return dict(columns), ()
