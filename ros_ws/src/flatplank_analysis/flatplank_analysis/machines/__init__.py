# SPDX-License-Identifier: Apache-2.0
"""Machines that are not tires: records of a motion, its forces, effects that may be missing.

One degree of freedom: a position over time, moved by weight, springs, drives and friction.
Other models use `flatplank_analysis.discovery` directly; this package is an application of it.
"""
