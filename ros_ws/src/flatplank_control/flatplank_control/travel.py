# SPDX-License-Identifier: Apache-2.0
"""What all hold who follow the travel of the road."""

JUMP = 1e-3
"""a longer way in one cycle is a new zero of the plank position [m]"""
FASTEST = 1.5
"""times the road's speed, while the wheel makes up travel: a faster one would stop too late"""
