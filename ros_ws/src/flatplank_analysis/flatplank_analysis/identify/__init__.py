# SPDX-License-Identifier: Apache-2.0
"""Identification: parameters from measurements, with what the data can and cannot say."""

from .campaign import ConditionFits, fit_campaign
from .carcass import fit_carcass
from .carcass_report import CarcassFit
from .fit_file import FitFile, parse_fit, read_fit_file
from .lateral import fit_lateral_carcass, lateral_run
from .linear import LinearFit, linear_run
from .mf import (
    MFFit,
    MFSettings,
    SteadyPoints,
    fit_magic_formula,
    merge,
    points_from_runs,
    steady_points,
)
from .noise import ARNoise, fit_noise, repeat_differences
from .quality import (
    is_transient,
    relative_error,
    relaxation_length,
    rmse,
    transient_end,
    transient_weights,
)
from .repeats import LinearCondition, LinearLevel, fit_linear
from .results import Confusion, Estimate, Fit
from .runs import StepRun, actual_slip, by_condition, by_level, step_run
from .steady_curve import SteadyCurve, steady_curve

__all__ = [
    "ARNoise",
    "CarcassFit",
    "ConditionFits",
    "Confusion",
    "Estimate",
    "Fit",
    "FitFile",
    "LinearCondition",
    "LinearFit",
    "LinearLevel",
    "MFFit",
    "MFSettings",
    "SteadyCurve",
    "SteadyPoints",
    "StepRun",
    "actual_slip",
    "by_condition",
    "by_level",
    "fit_campaign",
    "fit_carcass",
    "fit_lateral_carcass",
    "fit_linear",
    "fit_magic_formula",
    "fit_noise",
    "is_transient",
    "lateral_run",
    "linear_run",
    "merge",
    "parse_fit",
    "points_from_runs",
    "read_fit_file",
    "relative_error",
    "relaxation_length",
    "repeat_differences",
    "rmse",
    "steady_curve",
    "steady_points",
    "step_run",
    "transient_end",
    "transient_weights",
]
