# SPDX-License-Identifier: Apache-2.0
"""Post-processing of section 6.2, each step a function that can be left out."""

from flatplank_analysis.post.filtering import CUTOFF_PER_METRE, cutoff_per_metre, low_pass
from flatplank_analysis.post.gridding import GRID, Gridded, mean_of, on_grid, repeat_std
from flatplank_analysis.post.settling import ExponentialFit, fit_exponential, settling_distance
from flatplank_analysis.post.slip import StepFacts, step_facts

__all__ = [
    "CUTOFF_PER_METRE",
    "GRID",
    "ExponentialFit",
    "Gridded",
    "StepFacts",
    "cutoff_per_metre",
    "fit_exponential",
    "low_pass",
    "mean_of",
    "on_grid",
    "repeat_std",
    "settling_distance",
    "step_facts",
]
