# SPDX-License-Identifier: Apache-2.0
"""Lanes side by side: as each alone, and nothing is computed twice."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_analysis.discovery.model import Lane
from flatplank_analysis.discovery.state import start_base
from flatplank_analysis.effects.checks import probe_model
from flatplank_analysis.effects.registry import library
from flatplank_analysis.tirebase import kernel
from flatplank_analysis.tirebase.model import LEAST, THREADS, _alike

EFFECTS = (
    {}, {"combined_slip": 0.4}, {"rolling_resistance": 0.5}, {"crosstalk_fz": 0.02},
    {"speed_droop": 1e-7}, {"combined_slip": 0.4, "drive_backlash": 5e-4},
)  # fmt: skip


def lanes_of(model, effects):
    """The start and, from it, every parameter of the base a little away."""
    base = start_base(model)
    known = library()
    terms = tuple(
        (known[name], known[name].vector({known[name].parameters()[0].name: size}))
        for name, size in effects.items()
    )
    moved = [base + (np.arange(len(base)) == i) * p.screen for i, p in enumerate(model.parameters)]
    return [Lane(b, terms) for b in (base, *moved)]


@pytest.mark.parametrize("effects", EFFECTS, ids=lambda e: "+".join(e) or "base")
def test_lanes_together_are_as_each_alone(effects):
    model = probe_model()
    lanes = lanes_of(model, effects)
    assert len(lanes) > THREADS * LEAST
    together = model.predict(lanes)
    for lane, found in zip(lanes, together, strict=True):
        np.testing.assert_array_equal(model.predict([lane])[0], found)


def test_kinds_side_by_side_are_as_each_alone():
    model = probe_model()
    lanes = [lane for effects in EFFECTS for lane in lanes_of(model, effects)[::7]]
    together = model.predict(lanes)
    for lane, found in zip(lanes, together, strict=True):
        np.testing.assert_array_equal(model.predict([lane])[0], found)


def inputs(lanes, **numbers):
    rng = np.random.default_rng(1)
    params = np.tile(rng.random((2, 1, 2, kernel.WIDTH)), (1, lanes, 1, 1))
    for name in ("combine", "turn", "give"):
        params[..., kernel.NAMES.index(name)] = numbers.get(name, 0.0)
    return np.tile(rng.random((2, 1, 9)), (1, lanes, 1)), params, [
        np.tile(rng.random((1, 9)), (lanes, 1)) for _ in range(3)
    ]  # fmt: skip


COUPLED = {"apart": {}, "combined": {"combine": 1.0}, "turned": {"turn": 0.5}}
COUPLED["given"] = {"turn": 0.5, "give": 0.1}
FELT = {  # what moves along x -> who has to be computed anew
    "apart": {"dw": (True, False), "params": (True, False)},
    "combined": {"dw": (True, True), "params": (True, True)},
    "turned": {"dw": (True, True), "params": (True, False)},
    "given": {"dw": (True, True), "params": (True, True)},
}


@pytest.mark.parametrize("what", ["dw", "params"])
@pytest.mark.parametrize("coupling", COUPLED)
def test_only_what_differs_is_computed(coupling, what):
    dw, params, common = inputs(4, **COUPLED[coupling])
    moved = {"dw": dw, "params": params}[what]
    moved[0, 1].flat[0] += 1e-9
    moved[0, 3].flat[0] += 1e-9
    x, y = _alike(dw, params, common)
    new_x, new_y = FELT[coupling][what]
    assert new_x and list(x) == [0, 1, 0, 1]
    assert list(y) == ([0, 1, 0, 1] if new_y else [0, 0, 0, 0])


@pytest.mark.parametrize("which", range(3))
def test_travel_load_and_friction_are_felt_by_both(which):
    dw, params, common = inputs(3)
    common[which][2, 5] += 1e-12
    assert _alike(dw, params, common).tolist() == [[0, 0, 2], [0, 0, 2]]
