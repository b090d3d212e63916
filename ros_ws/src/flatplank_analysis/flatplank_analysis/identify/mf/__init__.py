# SPDX-License-Identifier: Apache-2.0
"""Identification of the Magic Formula in ordered stages."""

from .fit import MFFit, MFSettings, fit_magic_formula
from .points import SteadyPoints, merge, points_from_runs, steady_points
from .problem import Prior
from .stages import STAGES, Stage

__all__ = [
    "STAGES",
    "MFFit",
    "MFSettings",
    "Prior",
    "Stage",
    "SteadyPoints",
    "fit_magic_formula",
    "merge",
    "points_from_runs",
    "steady_points",
]
