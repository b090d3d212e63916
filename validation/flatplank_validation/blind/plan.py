# SPDX-License-Identifier: Apache-2.0
"""Designs of the blind campaigns: their conditions and runs."""

from __future__ import annotations

import numpy as np

from flatplank_sim.sealed.conditions import LOAD, Run, Setting

SLIPS = (-0.1, -0.05, -0.02, -0.01, 0.0, 0.01, 0.02, 0.05, 0.1)
COARSE = (-0.1, -0.02, 0.0, 0.02, 0.1)
FEW = (-0.05, -0.01, 0.0, 0.01, 0.05)


DESIGNS: dict[str, tuple[Setting, ...]] = {
    "plain": tuple(Setting(k) for k in SLIPS),
    "small": tuple(Setting(k) for k in FEW),
    "loads": tuple(Setting(k, fz) for fz in (2400.0, 3700.0, 5000.0) for k in FEW),
    "pressures": tuple(Setting(k, LOAD, p) for p in (2.0, 2.5) for k in FEW),
    "combined": tuple(Setting(k, alpha_deg=a) for a in (0.0, 5.0) for k in COARSE),
    "wide_loads": tuple(Setting(k, fz) for fz in (1850.0, 3700.0, 5550.0) for k in COARSE[::2]),
    "angles": tuple(Setting(k, alpha_deg=a) for a in (-2.0, 2.0) for k in FEW),
    "cambers": tuple(
        Setting(k, gamma_deg=g) for g in (-3.0, 0.0, 3.0) for k in (-0.02, 0.0, 0.02)
    ),
}  # fmt: skip
"""design -> conditions of a campaign; each is measured from three wheel angles"""
STARTS = (1, 2, 3)


def runs_of(design: str, random: np.random.Generator) -> list[Run]:
    """All runs in random order."""
    return _ordered([(s, start) for s in DESIGNS[design] for start in STARTS], random)


def runs_once(design: str, random: np.random.Generator) -> list[Run]:
    """Every condition once, at the wheel angles in turn, in random order."""
    settings = enumerate(DESIGNS[design])
    return _ordered([(s, STARTS[i % len(STARTS)]) for i, s in settings], random)


def _ordered(pairs: list[tuple[Setting, int]], random: np.random.Generator) -> list[Run]:
    order = random.permutation(len(pairs))
    return [Run(pairs[which][0], pairs[which][1], index) for index, which in enumerate(order)]
