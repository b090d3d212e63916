# SPDX-License-Identifier: Apache-2.0
"""Transient models: closed forms, and a contract that every registered model keeps."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from flatplank_analysis.models import nonlinear as nl
from flatplank_analysis.models.base import (
    TOYO,
    TransientModel,
    slip_inputs,
    stack_runs,
)
from flatplank_analysis.models.linear import LinearX
from flatplank_analysis.models.mf_tyre import ContactPointMF, MFTyre
from flatplank_analysis.models.nonlinear import (
    NonlinearX,
    NonlinearY,
    TableLaw,
    table_law,
)
from flatplank_analysis.models.tire_record import shipped_record
from flatplank_analysis.models.tire_state import tire_state
from flatplank_tire.magic_formula import Coefficients
from flatplank_tire.tir import shipped_tir

X = np.linspace(0.0, 2.6, 700)


def law_of(stiffness: float = 9e4, peak: float = 3700.0) -> TableLaw:
    slips = np.linspace(-0.12, 0.12, 49)
    return table_law(slips, peak * np.sin(1.4 * np.arctan(stiffness / 1.4 / peak * slips)))


MODELS: dict[str, tuple[TransientModel, np.ndarray]] = {
    "linear": (LinearX(), np.array([[0.45, 9e4], [0.5, 9.9e4]])),
    "nonlinear": (NonlinearX(lambda _: law_of()), np.array([[2e5], [2.2e5]])),
    "nonlinear-y": (NonlinearY(lambda _: law_of()), np.array([[1e5], [2e5]])),
    "mf": (MFTyre(shipped_tir().coefficients), np.zeros((1, 0))),
    "mf-contact-point": (ContactPointMF(shipped_tir().coefficients), np.zeros((1, 0))),
}
"""Model and its sets of parameters."""


@pytest.mark.parametrize("name", MODELS)
def test_contract(name: str) -> None:
    model, sets = MODELS[name]
    runs = [
        slip_inputs(X, 0.02, 3700.0, alpha=0.02),
        slip_inputs(X[:500], 0.05 * np.sin(8.0 * X[:500]), 3000.0, alpha=-0.03, start_fx=-40.0),
    ]
    inputs = stack_runs(runs)
    both = model.simulate(sets, inputs)
    assert both.shape == (len(sets), 2, len(X))
    assert np.all(np.isfinite(both))
    for index in range(len(sets)):
        np.testing.assert_allclose(
            model.simulate(sets[index : index + 1], inputs)[0], both[index], rtol=0, atol=1e-7
        )
    for i, run in enumerate(runs):
        alone = model.simulate(sets, run)
        np.testing.assert_allclose(alone[:, 0], both[:, i, : run.shape[1]], rtol=0, atol=1e-7)
    # Padded samples are at rest: nothing changes there.
    np.testing.assert_allclose(both[:, 1, 500:] - both[:, 1, 499:500], 0.0, atol=5.0)
    assert len(sets) == 1 or np.any(np.abs(both[1] - both[0]) > 1.0)


def test_linear_step_is_the_exponential() -> None:
    for x in (X, np.sort(np.random.default_rng(0).uniform(0, 2.6, 40))):
        force = LinearX().simulate(np.array([[0.45, 9e4]]), slip_inputs(x, 0.02, 3700.0))[0, 0]
        np.testing.assert_allclose(
            force, 1800.0 * (1.0 - np.exp(-(x - x[0]) / 0.45)), rtol=1e-12, atol=1e-9
        )


def test_linear_starts_at_the_start_force_and_forgets_it() -> None:
    run = slip_inputs(X, 0.0, 3700.0, start_fx=-150.0)
    force = LinearX().simulate(np.array([[0.45, 9e4]]), run)[0, 0]
    np.testing.assert_allclose(force, -150.0 * np.exp(-X / 0.45), rtol=1e-12)


def test_nonlinear_side_force_ends_at_its_law_and_begins_where_it_is_told() -> None:
    law = law_of(5e4, 3300.0)
    run = slip_inputs(X, 0.0, 3700.0, alpha=0.03, start_fy=400.0)
    force = NonlinearY(lambda _: law).simulate(np.array([[3e5]]), run)[0, 0]
    assert force[0] == pytest.approx(400.0, abs=25.0)
    wanted = -law.force(np.array([[np.tan(0.03)]]))[0].item()
    assert force[-1] == pytest.approx(wanted, rel=1e-3)


@pytest.mark.parametrize("kappa", [-0.1, -0.02, 0.01, 0.05, 0.1])
def test_nonlinear_against_an_ode_solver(kappa: float) -> None:
    law = law_of()
    slips = law.first + law.step * np.arange(law.values.shape[-1])
    forces = law.values[0]
    slopes = np.gradient(forces, slips)
    a = float(TOYO.half_length(3700.0, 250e3))
    theta = law.stiffness().item() / (3.0 * 3700.0)

    def rate(_: float, y: np.ndarray) -> list[float]:
        base = 1.0 + y[0]
        sigma = max(1.0 - theta * abs(y[0]) / base, 0.01) * a / base
        return [(kappa - y[0]) / (sigma + np.interp(y[0], slips, slopes) / 2.4e5)]

    found = solve_ivp(rate, (0.0, 2.6), [0.0], "LSODA", t_eval=X, rtol=1e-8, atol=1e-11)
    model = NonlinearX(lambda _: law, friction=1.0)
    force = model.simulate(np.array([[2.4e5]]), slip_inputs(X, kappa, 3700.0))[0, 0]
    np.testing.assert_allclose(force, np.interp(found.y[0], slips, forces), atol=0.15)


def test_nonlinear_small_slip_has_the_relaxation_length_of_7_27() -> None:
    model = NonlinearX(lambda _: law_of())
    force = model.simulate(np.array([[2.4e5]]), slip_inputs(X, 1e-4, 3700.0))[0, 0]
    sigma = 9e4 / 2.4e5 + float(TOYO.half_length(3700.0, 250e3))
    np.testing.assert_allclose(force, 9.0 * -np.expm1(-X / sigma), rtol=4e-3, atol=0.01)


@pytest.mark.parametrize(
    "model",
    [
        NonlinearX(lambda _: law_of()),
        NonlinearY(lambda _: law_of()),
        NonlinearX(lambda _: law_of(), tread_stiffness=1.7e7),
        NonlinearX(lambda _: law_of(), friction=0.35),
        NonlinearX(lambda _: table_law(np.linspace(-0.4, 0.4, 41), 3700.0 * np.sin(
            1.9 * np.arctan(17.0 * np.linspace(-0.4, 0.4, 41)))), friction=20.0),
        NonlinearX(lambda _: TableLaw(-0.12, 0.01, 9e2 * np.outer(
            np.arange(1, 7), np.linspace(-1.0, 1.0, 25) ** 3 + np.linspace(-1.0, 1.0, 25)))),
        NonlinearX(lambda p: table_law(np.linspace(-0.1, 0.1, 5), 9e3 * np.outer(
            np.arange(1, len(p) + 1), np.linspace(-0.1, 0.1, 5)))),
    ],
)  # fmt: skip
def test_nonlinear_machine_code_equals_python(
    model: NonlinearX, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Up to slips at which all slides, and beyond the table; with a table of each run."""
    slips = (-0.3, -0.02, 0.0, 0.01, 0.05, 0.2)
    loads = 3700.0 + 900.0 * np.sin(7.0 * X)
    inputs = stack_runs([slip_inputs(X[::3], k, loads[::3], start_fx=-30.0) for k in slips])
    sets = np.array([[2e5], [3e5]])
    fast = model.simulate(sets, inputs)
    monkeypatch.setattr(nl, "march", nl.march.py_func)
    np.testing.assert_allclose(model.simulate(sets, inputs), fast, atol=1e-5)


def test_nonlinear_large_steps_do_not_ring() -> None:
    coarse = np.linspace(0.0, 2.6, 27)
    model = NonlinearX(lambda _: law_of())
    force = model.simulate(np.array([[2.4e5]]), slip_inputs(coarse, 0.1, 3700.0))[0, 0]
    assert np.all(np.diff(force) > -1e-6)


def test_contact_lengths_of_table_7_2() -> None:
    found = TOYO.half_length(np.array([1850.0, 3700.0, 5550.0]), 250e3)
    np.testing.assert_allclose(found, [0.0496, 0.0708, 0.0872], atol=1e-4)
    assert float(TOYO.stiffness(200e3)) == pytest.approx(1.770e5, rel=1e-3)
    continental, _ = shipped_record("continental").geometry()
    assert float(continental.stiffness(280e3)) == pytest.approx(2.41e5)


def test_mf_tyre_ends_at_the_steady_state_and_follows_a_sine() -> None:
    c = shipped_tir().coefficients
    model = MFTyre(c)
    long = np.linspace(0.0, 8.0, 2000)
    end = model.simulate(np.zeros((1, 0)), slip_inputs(long, 0.02, 3700.0))[0, 0, -1]
    assert end == pytest.approx(tire_state(c, 3700.0, 0.02).fx, rel=1e-4)
    wave = 5e-4 * np.sin(2.0 * np.pi * long / 1.5)
    swing = model.simulate(np.zeros((1, 0)), slip_inputs(long, wave, 3700.0))[0, 0]
    sigma = tire_state(c, 3700.0).sigma_x
    gain = 1.0 / np.hypot(1.0, 2.0 * np.pi * sigma / 1.5)
    local = (tire_state(c, 3700.0, 5e-4).fx - tire_state(c, 3700.0, -5e-4).fx) / 2.0
    assert np.ptp(swing[1000:]) / 2.0 == pytest.approx(local * gain, rel=0.02)


def test_mf_tyre_side_force_and_moment_build_up_over_sigma_y() -> None:
    values = shipped_tir().values | {
        "LATERAL_STIFFNESS": 1e5,
        "QDZ1": 0.1,
        "QBZ1": 10,
        "QCZ1": 1.1,
    }
    c = Coefficients(values | {"PHY1": 0.0, "PVY1": 0.0})
    out = MFTyre(c).simulate_all(slip_inputs(X, 0.0, 3700.0, alpha=1e-3))
    state = tire_state(c, 3700.0, alpha=1e-3)
    sigma = state.sigma_y
    np.testing.assert_allclose(out["fy"][0], state.fy * -np.expm1(-X / sigma), rtol=2e-3)
    np.testing.assert_allclose(out["mz"][0], state.mz * -np.expm1(-X / sigma), rtol=2e-2)
