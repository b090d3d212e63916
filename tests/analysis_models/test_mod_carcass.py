# SPDX-License-Identifier: Apache-2.0
"""Transient models: start forces, relaxation of the patch, tread, damping, machine code."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from mod_laws import X, law

from flatplank_analysis.models import nonlinear as nl
from flatplank_analysis.models.base import TOYO, slip_inputs, stack_runs
from flatplank_analysis.models.linear import LinearX, deflection
from flatplank_analysis.models.mf_tyre import late_weight
from flatplank_analysis.models.nonlinear import NonlinearX, table_law


def test_deflection_at_rest_and_over_a_long_way():
    """At rest the slip is taken in full; over a long way it is sigma times the slip."""
    travel = np.array([[0.0, 1e-12, 0.2, 50.0]])
    slip = np.array([[0.01, 0.02, 0.004, -1.0]])
    sigma = np.full((1, 1, 1), 0.5)
    found = deflection(travel[None], slip[None], sigma, np.array([[0.1]]))[0, 0]
    one = 0.13
    two = one * math.exp(-0.4) + 0.5 * 0.004 / 0.2 * -math.expm1(-0.4)
    np.testing.assert_allclose(found, [0.11, one, two, -0.5 * 1.0 / 50.0], rtol=1e-9)


def test_start_forces_in_both_directions():
    decay = np.exp(-X / 0.45)
    for start in (-50.0, 80.0):
        run = slip_inputs(X, 0.0, 3700.0, start_fx=start)
        force = LinearX().simulate(np.array([[0.45, 9e4]]), run)[0, 0]
        np.testing.assert_allclose(force, start * decay, rtol=1e-9)
        force = NonlinearX(lambda _: law()).simulate(np.array([[2e5]]), run)[0, 0]
        assert force[0] == pytest.approx(start, abs=1e-6)
        assert abs(force[-1]) < 2.0
    # a spring without stiffness has no deflection to start from
    assert not LinearX().simulate(np.array([[0.45, 0.0]]), run).any()


def test_the_tread_that_the_law_has_and_one_that_is_given():
    """2 c_px a^2 = C_Fk: the same tread said otherwise."""
    run = slip_inputs(X, 0.05, 3700.0)
    a = float(TOYO.half_length(3700.0, 250e3))
    stiffness = law().stiffness().item()
    tied = NonlinearX(lambda _: law()).simulate(np.array([[2e5]]), run)
    same = NonlinearX(lambda _: law(), tread_stiffness=stiffness / (2.0 * a**2))
    np.testing.assert_allclose(same.simulate(np.array([[2e5]]), run), tied, rtol=1e-9)
    hard = replace(same, tread_stiffness=3.0 * stiffness / (2.0 * a**2))
    assert np.abs(hard.simulate(np.array([[2e5]]), run) - tied).max() > 10.0


def test_the_weight_of_the_end_of_an_increment():
    ratio = np.array([1e-6, 0.5, 40.0])
    late = late_weight(0.2 * ratio, np.full(3, 0.2))
    assert late == pytest.approx([0.5, 1.0 / -math.expm1(-0.5) - 2.0, 1.0 - 1.0 / 40.0], abs=1e-4)


@pytest.mark.parametrize("drop", [0.02, 0.2])
@pytest.mark.parametrize("step", [0.002, 0.008, 0.02])
@pytest.mark.parametrize("machine_code", [True, False])
def test_beyond_the_peak_of_the_curve_the_force_ends_on_it(drop, step, machine_code, monkeypatch):
    """Where the curve falls no spring holds the contact point: it slides on to the slip."""
    if not machine_code:
        monkeypatch.setattr(nl, "march", nl.march.py_func)
    slips = np.array([-0.15, -0.1, -0.05, -0.02, 0.0, 0.02, 0.05, 0.1, 0.15])
    shape = np.array([drop - 1.0, -1.0, -0.85, -0.45, 0.0, 0.45, 0.85, 1.0, 1.0 - drop])
    model, x = NonlinearX(lambda _: table_law(slips, 3700.0 * shape)), np.arange(0.0, 3.0, step)
    inputs = stack_runs([slip_inputs(x, k, 3700.0) for k in (-0.15, 0.15, 0.12)])
    force = model.simulate(np.array([[1e5], [2e5]]), inputs)
    assert np.abs(force).max() <= 3701.0
    ends = model.law(None).force(np.array([[-0.15, 0.15, 0.12]]))[0][0]
    np.testing.assert_allclose(force[:, :, -1], np.tile(ends, (2, 1)), rtol=1e-3)
    back = slip_inputs(x, np.where(x < 0.9, 0.15, 0.02), 3700.0)  # and back on the rising branch
    force = model.simulate(np.array([[2e5]]), back)[0, 0]
    assert force.max() <= 3701.0 and force[-1] == pytest.approx(0.45 * 3700.0, rel=0.01)
