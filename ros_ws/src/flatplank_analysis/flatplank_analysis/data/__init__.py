# SPDX-License-Identifier: Apache-2.0
"""Measurements: tables, campaigns, and the file formats that they come in."""

from flatplank_analysis.data.campaign import Campaign, Run
from flatplank_analysis.data.info import Condition, RunInfo
from flatplank_analysis.data.problem import Problem
from flatplank_analysis.data.table import COLUMN_UNITS, STANDARD_COLUMNS, MeasurementTable

__all__ = [
    "COLUMN_UNITS",
    "STANDARD_COLUMNS",
    "Campaign",
    "Condition",
    "MeasurementTable",
    "Problem",
    "Run",
    "RunInfo",
]
