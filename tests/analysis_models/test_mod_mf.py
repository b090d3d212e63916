# SPDX-License-Identifier: Apache-2.0
"""The Magic Formula in transients, and what a state needs of its file."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from mod_laws import X
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from flatplank_analysis.models.base import slip_inputs
from flatplank_analysis.models.mf_tyre import ContactPointMF, MFTyre
from flatplank_analysis.models.tire_state import tire_state
from flatplank_data.errors import FlatplankError
from flatplank_tire.magic_formula import steady_forces
from flatplank_tire.tir import shipped_tir


def test_magic_formula_starts_at_the_measured_force():
    even = {"LATERAL_STIFFNESS": 1e5, "PHY1": 0.0, "PVY1": 0.0}
    c = shipped_tir().replaced(even).coefficients
    state = tire_state(c, 3700.0)
    still = slip_inputs(X, 0.0, 3700.0, start_fx=-60.0, start_fy=state.fy)
    across = replace(still, start_fx=np.array([state.fx]), start_fy=np.array([50.0]))
    out = MFTyre(c).simulate_all(still)
    assert out["fx"][0, 0] == pytest.approx(-60.0, rel=0.06)
    side = MFTyre(c).simulate_all(across)["fy"][0]
    assert side[0] == pytest.approx(50.0, rel=0.06)
    np.testing.assert_allclose(
        side - state.fy, (side[0] - state.fy) * np.exp(-X / state.sigma_y), atol=2.0
    )
    away = out["fx"][0] - state.fx
    np.testing.assert_allclose(away, away[0] * np.exp(-X / state.sigma_x), atol=2.0)
    point = ContactPointMF(c).simulate(np.zeros((1, 0)), still)[0, 0]
    assert point[0] == pytest.approx(-60.0, abs=0.5)
    sigma = state.kx / c.LONGITUDINAL_STIFFNESS
    np.testing.assert_allclose(
        point - state.fx, (point[0] - state.fx) * np.exp(-X / sigma), atol=3.0
    )
    # and a step of 5 % ends at the steady force, from whatever force it begins
    long = slip_inputs(np.linspace(0.0, 8.0, 300), 0.05, 3700.0, start_fx=900.0)
    steady = ContactPointMF(c).simulate(np.zeros((1, 0)), long)[0, 0]
    assert steady[0] == pytest.approx(900.0, rel=0.01)
    assert steady[-1] == pytest.approx(tire_state(c, 3700.0, 0.05).fx, rel=1e-3)
    # a tire that pushes without slip: the start force is beside that
    pushes = shipped_tir().replaced(even | {"PVX1": 0.02}).coefficients
    own = tire_state(pushes, 3700.0)
    begun = MFTyre(pushes).simulate(np.zeros((1, 0)), replace(still, start_fx=np.array([own.fx])))
    assert abs(own.fx) > 50.0
    np.testing.assert_allclose(begun[0, 0], own.fx, rtol=0.02)
    # far beyond what the tire can hold the search for the start stays on the rising branch
    huge = ContactPointMF(c).simulate(np.zeros((1, 0)), replace(still, start_fx=np.array([9e3])))
    assert np.isfinite(huge).all() and huge.max() < 5e3


def test_what_a_state_needs_of_its_file():
    c = shipped_tir().coefficients
    with pytest.raises(FlatplankError, match="PHYP1, PHYP2, QCRP1, QDRP1 missing"):
        tire_state(c, 3700.0, turn_slip=0.1)
    assert math.isnan(tire_state(c.replaced({"Q_RA1": 0.0, "Q_RA2": 0.0}), 3700.0).a)
    assert tire_state(c, 3700.0).a == pytest.approx(0.0708, abs=2e-4)
    assert tire_state(c.replaced({"Q_RA2": 0.0}), 3700.0).a > 0.05
    assert 0.0 < tire_state(c.replaced({"Q_RA1": 0.0}), 3700.0).a < 0.02
    for n, of in ((1, "QSY"), (6, "QSY"), (1, "QSX"), (14, "QSX")):
        name = "my" if of == "QSY" else "mx"
        none = c.replaced(
            {f"QSY{i}": 0.0 for i in range(1, 9)} | {f"QSX{i}": 0.0 for i in range(1, 15)}
        )
        assert math.isnan(getattr(tire_state(none, 3700.0), name))
        assert math.isfinite(getattr(tire_state(none.replaced({f"{of}{n}": 0.01}), 3700.0), name))
    own, nominal = (tire_state(c, 3700.0, pressure=p) for p in (None, c.NOMPRES))
    assert own.to_json() == nominal.to_json()
    assert tire_state(c, 3700.0, 0.02).to_json()["fx"] == tire_state(c, 3700.0, 0.02).fx


SOFT = {"LATERAL_STIFFNESS": 1e5, "PHY1": 0.0, "PVY1": 0.0}


@pytest.mark.parametrize("alpha", [0.0, 0.05])
def test_without_a_relaxation_length_the_side_slip_is_the_wheels_own(alpha):
    c = shipped_tir().replaced({"RBX1": 9.0, "RCX1": 1.0, "QDZ1": 0.1, "QBZ1": 9.0, "QCZ1": 1.1})
    c = c.coefficients
    run = slip_inputs(X, 0.0, 3700.0, alpha=alpha, start_fx=tire_state(c, 3700.0).fx)
    out = MFTyre(c).simulate_all(run)
    state = tire_state(c, 3700.0, alpha=alpha)
    for name in ("fx", "fy", "mz"):
        np.testing.assert_allclose(out[name][0, 0], getattr(state, name), rtol=1e-6)


def test_a_load_that_changes_at_once_leaves_the_start_force():
    """The start deflection is that of sample 0, with its load, camber and lag."""
    c = shipped_tir().replaced(SOFT).coefficients
    fz = np.where(X > 0.0, 2500.0, 4000.0)
    own = tire_state(c, 4000.0)
    run = slip_inputs(X, 0.0, fz, start_fx=own.fx - 80.0, start_fy=own.fy + 60.0)
    out = MFTyre(c).simulate_all(run)
    assert out["fx"][0, 0] == pytest.approx(own.fx - 80.0, abs=2.0)
    assert out["fy"][0, 0] == pytest.approx(own.fy + 60.0, abs=2.0)
    light, way = tire_state(c, 2500.0), X[1] - X[0]
    ratio = own.sigma_x / light.sigma_x * np.exp(-way / light.sigma_x)
    wanted = light.fx - 80.0 / own.kx * light.kx * ratio
    assert out["fx"][0, 1] == pytest.approx(wanted, abs=2.0)
    point = ContactPointMF(c).simulate(np.zeros((1, 0)), run)[0, 0]
    assert point[0] == pytest.approx(own.fx - 80.0, abs=2.0)


def test_camber_of_the_run_reaches_the_force():
    c = shipped_tir().replaced(SOFT | {"PKY6": -0.9, "PDX3": 2.0}).coefficients
    long = np.linspace(0.0, 9.0, 400)
    run = slip_inputs(long, 0.03, 3700.0, gamma=0.06)
    for model in (MFTyre(c), ContactPointMF(c)):
        end = model.simulate(np.zeros((1, 0)), run)[0, 0, -1]
        assert end == pytest.approx(tire_state(c, 3700.0, 0.03, gamma=0.06).fx, rel=1e-3)
    end = MFTyre(c).simulate_all(run)["fy"][0, -1]
    assert end == pytest.approx(tire_state(c, 3700.0, 0.03, gamma=0.06).fy, rel=1e-3)


def test_side_slip_takes_its_part_of_a_contact_points_force():
    weighed = SOFT | {"RBX1": 9.0, "RCX1": 1.0, "REX1": -0.4}
    c = shipped_tir().replaced(weighed).coefficients
    run = slip_inputs(np.linspace(0.0, 9.0, 400), 0.03, 3700.0, alpha=0.08)
    end = ContactPointMF(c).simulate(np.zeros((1, 0)), run)[0, 0, -1]
    assert end == pytest.approx(tire_state(c, 3700.0, 0.03, alpha=0.08).fx, rel=1e-3)
    assert end < 0.9 * tire_state(c, 3700.0, 0.03).fx


@pytest.mark.parametrize("kappa", [-0.06, 0.01, 0.04])
def test_a_contact_point_on_its_spring_against_an_ode_solver(kappa):
    """C_x du = dFx, du = (kappa - s) dx: ds/dx = (kappa - s) C_x / (dFx/ds)."""
    c = shipped_tir().coefficients
    x = np.linspace(0.0, 2.0, 800)

    def force(slip):
        return steady_forces(c, 3700.0, slip, vx=0.03)[0]

    def rate(_, y):
        slope = (force(y[0] + 1e-6) - force(y[0] - 1e-6)) / 2e-6
        return [(kappa - y[0]) * c.LONGITUDINAL_STIFFNESS / max(slope, 5e-3 * stiffness)]

    stiffness = c.LONGITUDINAL_STIFFNESS
    begin = brentq(lambda s: force(s) - 150.0, -0.02, 0.02)
    found = solve_ivp(rate, (0.0, 2.0), [begin], "LSODA", t_eval=x, rtol=1e-8, atol=1e-11)
    run = slip_inputs(x, kappa, 3700.0, start_fx=150.0)
    out = ContactPointMF(c).simulate(np.zeros((1, 0)), run)[0, 0]
    np.testing.assert_allclose(out, force(found.y[0]), atol=3.0)


def test_where_the_curve_falls_the_contact_point_follows_in_five_millimetres():
    c = shipped_tir().replaced({"PCX1": 1.9, "PEX1": 0.5, "PEX4": 0.0}).coefficients
    x = np.linspace(0.0, 1.2, 1000)
    out = ContactPointMF(c).simulate(np.zeros((1, 0)), slip_inputs(x, 0.3, 3700.0))[0, 0]
    end = tire_state(c, 3700.0, 0.3).fx
    peak = int(np.argmax(out))
    assert out[peak] > 1.05 * end and out[-1] == pytest.approx(end, rel=1e-4)
    # 90 % of the way from the peak's slip to 30 % within some ten lags
    late = np.flatnonzero(np.abs(out[peak:] - end) < 0.1 * (out[peak] - end))[0] * (x[1] - x[0])
    assert 0.005 < late < 0.05
