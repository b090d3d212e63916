# SPDX-License-Identifier: Apache-2.0
"""Faults that are hard to name in full."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.verdict import FOUND, Diagnosis
from flatplank_validation.blind.cases import measured_table
from flatplank_validation.blind.noise import NOISES, RELATIVE, shown
from flatplank_validation.blind.plan import runs_of
from flatplank_validation.blind.second import SecondMachine, SecondTire, counted, measure
from flatplank_validation.blind.worlds import Scatter, SecondWorld

SCATTER = 0.01
pytestmark = pytest.mark.long


def diagnosed(seed: int, **faults: Any) -> Diagnosis:
    """Diagnosis of a straight-ahead campaign of the second tire with faults of its machine."""
    random = np.random.default_rng(seed)
    tire, machine = SecondTire().drawn(random), SecondMachine(**faults)
    runs = runs_of("plain", random)
    scatter = Scatter.drawn(len(runs), SCATTER, random)
    tables = []
    for run in runs:
        drawn = float(scatter.gain[run.index]), float(scatter.delay[run.index]), scatter.bumps
        columns = counted(measure(tire, machine, run, len(runs), *drawn))
        step = float(columns["time"][1] - columns["time"][0])
        for name, share in RELATIVE.items():
            columns[name] = shown(NOISES["usual"], columns[name], step, random, share)
        tables.append(measured_table(columns, run, SecondWorld().radius))
    return Session.of_tables(tables).diagnose()


def sizes(result: Diagnosis) -> list[tuple[str, float]]:
    terms = [f.decision.term for f in result.found]
    return sorted((t.effect.identifier, t.size) for t in terms if not t.effect.law)


def test_two_worn_patches_are_named_and_no_third_one():
    result = diagnosed(1, patches=((1.95, 2.15, 0.25), (2.8, 3.05, 0.25)))
    assert result.verdict == FOUND
    assert [name for name, _ in sizes(result)] == ["worn_patch", "worn_patch"]
    assert [size for _, size in sizes(result)] == pytest.approx([0.25, 0.25], rel=0.1)
