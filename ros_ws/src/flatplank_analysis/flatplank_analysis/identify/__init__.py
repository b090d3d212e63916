# SPDX-License-Identifier: Apache-2.0
"""Identification: parameters from measurements, with what the data can and cannot say."""

from .linear import LinearFit, linear_run
from .noise import ARNoise, fit_noise, repeat_differences
from .quality import (
    is_transient,
    relative_error,
    relaxation_length,
    rmse,
    transient_end,
    transient_weights,
)
from .results import Confusion, Estimate, Fit

__all__ = [
    "ARNoise",
    "Confusion",
    "Estimate",
    "Fit",
    "LinearFit",
    "fit_noise",
    "is_transient",
    "linear_run",
    "relative_error",
    "relaxation_length",
    "repeat_differences",
    "rmse",
    "transient_end",
    "transient_weights",
]
