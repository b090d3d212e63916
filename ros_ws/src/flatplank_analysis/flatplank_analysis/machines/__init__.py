# SPDX-License-Identifier: Apache-2.0
"""Machines that are not tires: records of a motion, what moves it, effects that may be missing.

One degree of freedom: a position over time, of which weight, springs, drives and friction are to
be known. Other models: `flatplank_analysis.discovery`, which this is an application of.
"""
