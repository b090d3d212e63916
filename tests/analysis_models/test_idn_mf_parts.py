# SPDX-License-Identifier: Apache-2.0
"""Parts of the Magic Formula fit: points, levels, proposals, problems, twins, statements."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from flatplank_analysis.identify import fit_file
from flatplank_analysis.identify.campaign import _run_task, _Task, carcass_fits, fit_campaign
from flatplank_analysis.identify.fit_file import FitFile
from flatplank_analysis.identify.least_squares import Solution
from flatplank_analysis.identify.mf import candidates, fit, stages, statement, twins
from flatplank_analysis.identify.mf.fit import MFSettings, fit_magic_formula
from flatplank_analysis.identify.mf.parameters import COEFFICIENTS, general_start
from flatplank_analysis.identify.mf.points import (
    SteadyPoints,
    _tail,
    gathered,
    merge,
    points_from_runs,
    steady_points,
    stiffness_points,
)
from flatplank_analysis.identify.mf.problem import _CURVATURES, OutputProblem, Prior
from flatplank_analysis.identify.results import Confusion
from flatplank_analysis.models.magic_formula import operating_point, steady_forces
from flatplank_analysis.models.magic_formula import structure as shape
from flatplank_analysis.models.shipped import shipped_tir
from flatplank_data.errors import FlatplankError
from flatplank_validation.fits.campaigns import Truth, simulate_runs

TIR = shipped_tir()
C = TIR.coefficients
LOADS = np.array([1850.0, 3700.0, 5550.0])


def points(n: int = 6, **axes) -> SteadyPoints:
    facts = {"fz": np.full(n, 3700.0), "pressure": 2.5e5} | axes
    return steady_points({"fx": np.arange(float(n))}, **facts)


def test_distinct_settings_of_the_data_in_words():
    p = points(fz=np.array([3000.0, 1000.0, 1150.0, 3190.0, 5000.0, 1300.0]))
    np.testing.assert_allclose(candidates.levels_of(p, "fz"), [1150.0, 3095.0, 5000.0])
    assert candidates.describe_levels(p, "fz") == "3 loads (1150 N, 3100 N, 5000 N)"
    assert candidates.describe_levels(p, "pressure") == "1 pressure (2.5 bar)"
    six = points(fz=1000.0 * np.arange(1, 7))
    assert candidates.describe_levels(six, "fz") == "6 loads"
    five = points(5, fz=1000.0 * np.arange(1, 6))
    assert candidates.describe_levels(five, "fz").endswith("5000 N)")
    assert candidates.levels_of(p.rows(np.zeros(6, bool)), "fz").size == 0
    angles = points(alpha=np.radians([0.0, 0.4, 0.8, 3.0, 3.0, 3.0]))
    np.testing.assert_allclose(np.degrees(candidates.levels_of(angles, "alpha")), [0.4, 3.0])
    assert candidates.LEVEL["kappa"](-0.05) == "-5 %"
    assert candidates.SHOW["alpha"](np.radians(-5.0)) == "a slip angle of -5 deg"
    assert candidates.SHOW["gamma"](np.radians(2.5)) == "a camber of +2.5 deg"
    assert candidates.SHOW["pressure"](2.2e5) == "a pressure of 2.2 bar"
    assert candidates.SHOW["kappa"](0.02) == "a slip of +2 %"
    assert (
        candidates.LEVEL["alpha"](np.radians(3.0))
        == "+3 deg"
        == candidates.LEVEL["gamma"](np.radians(3.0))
    )


def test_a_run_that_could_be_made_is_the_data_at_one_new_level():
    p = points(8, fz=np.repeat([2000.0, 4300.0], 4), kappa=np.tile([0.02, 0.05], 4))
    found = candidates.proposals(p, lambda new: np.column_stack([new.fz, new.kappa, new.alpha]))
    texts = [c.text for c in found]
    # 4000 and 4300 N are one load; two settings of four are measured twice and count once
    assert "a load of 4000 N" not in texts and "a load of 5000 N" in texts
    assert "a load of 2000 N" not in texts and "a slip of +2 %" not in texts
    load = found[texts.index("a load of 5000 N")]
    assert load.have == "2 loads (2000 N, 4300 N)"
    np.testing.assert_allclose(load.rows[:, 0], 5000.0)
    assert sorted(load.rows[:, 1]) == pytest.approx([0.02, 0.02, 0.05, 0.05])
    angle = found[texts.index("a slip angle of +5 deg")]
    np.testing.assert_allclose(angle.rows[:, 2], np.radians(5.0))
    assert sorted(angle.rows[:, 0]) == [2000.0, 2000.0, 4300.0, 4300.0]
    many = points(1000, fz=np.full(1000, 3e3), kappa=np.linspace(-5.0, 5.0, 1000))
    assert 400 <= len(candidates._representative(many)) <= 500


def test_points_axes_outputs_and_runs():
    p = points(3, kappa=np.array([0.0, 0.1, 0.2]))
    assert p.ranges() == {"kappa": (0.0, 0.2)} and p.run.tolist() == [0, 1, 2]
    one = replace(p, measured={"fx": np.array([1.0, np.nan, 3.0])})
    assert one.with_output("fx").kappa.tolist() == [0.0, 0.2]
    assert len(one.with_output("fy")) == 0
    other = steady_points(
        {"re": np.array([0.3, 0.31])}, fz=[2e3, 2e3], pressure=2e5, run=np.array([7, 7])
    )
    both = merge([p, other])
    assert len(both) == 5 and len(np.unique(both.run)) == 4
    assert both.with_output("re").run.tolist()[0] == both.with_output("re").run.tolist()[1]
    assert np.isnan(both.with_output("re").measured["fx"]).all()
    turned = merge([other, p.rows(np.array([2, 0, 1]))])
    np.testing.assert_array_equal(turned.kappa, both.kappa)
    x = np.linspace(0.0, 2.0, 201)
    run = SimpleNamespace(distance=x, fy=np.where(x > 1.5, 40.0, 7.0), mz=0.0 * x)
    assert _tail(run, "fy") == pytest.approx(40.0) and np.isnan(_tail(run, "mz"))
    with pytest.raises(FlatplankError, match="no run"):
        points_from_runs([])


def carcass(alpha: float = 0.0, gamma: float = 0.0, known: bool = True):
    number = SimpleNamespace(determined=known)
    at = SimpleNamespace(alpha=alpha, gamma=gamma)
    at._asdict = lambda: dict(fz=3e3, pressure=2.5e5, alpha=alpha, gamma=gamma)
    return SimpleNamespace(
        at=at, sigma_x=SimpleNamespace(value=0.5, determined=known),
        slip_stiffness=SimpleNamespace(value=1e5, determined=number.determined),
    )  # fmt: skip


def test_stiffness_of_the_rolling_tire_goes_before_that_at_rest():
    fits = [carcass(), carcass(alpha=0.01), carcass(gamma=0.01), carcass(known=False), carcass()]
    found = stiffness_points(fits)
    assert [p.measured["cx"].tolist() for p in found] == [[2e5], [2e5]]
    standing = steady_points(
        {"cx_at_rest": np.array([1.8e5, np.nan])}, fz=[3e3, 3e3], pressure=2e5
    )
    all_points, source = gathered([standing], fits)
    assert len(all_points.with_output("cx")) == 2 and source.startswith("C_F")
    assert "2 operating points without" in source
    assert "1 operating point without" in gathered([standing], fits[:1])[1]
    all_points, source = gathered([standing], fits[1:4])
    assert all_points.with_output("cx").measured["cx"].tolist() == [1.8e5]
    assert source.startswith("1 runs at rest")
    assert gathered([points()], [])[1] == ""


def test_points_of_runs_that_a_stage_takes():
    p = points(
        5, kappa=np.array([0.0, 0.05, 0.0, 0.0, 0.0]),
        alpha=np.array([0.0, 0.0, 0.1, 0.0, 0.0]), gamma=np.array([0.0, 0.0, 0.0, 0.1, 0.0]),
        pressure=C.NOMPRES * np.array([1.0, 1.019, 1.0, 1.0, 1.021]),
    )  # fmt: skip
    wanted = {
        "pure_x": [0, 1], "pure_y": [0, 2], "combined": [0, 1, 2], "pressure": [0, 1, 2, 4],
        "camber": [0, 1, 2, 3, 4],
    }  # fmt: skip
    for name, rows in wanted.items():
        mask = stages.STAGES[name].select(p, C)
        assert np.flatnonzero(mask).tolist() == rows, name
    scale = {k: stages.SCALE[k](p)[0] for k in ("fx", "fy", "mz", "re", "cx", "rho")}
    assert scale == pytest.approx({"fx": 37.0, "fy": 37.0, "mz": 1.48, "re": 2e-4, "cx": 5e3,
                                   "rho": 1e-4})  # fmt: skip


def test_predictions_are_those_of_the_law():
    c = TIR.replaced({"LATERAL_STIFFNESS": 1e5}).coefficients
    axes = LOADS, np.array([0.05, -0.02, 0.0]), np.array([0.0, 0.05, -0.1]), 0.01, 2.4e5
    o = operating_point(c, *axes, 0.03)
    for name, wanted in zip(("fx", "fy", "mz"), steady_forces(c, *axes, 0.03), strict=True):
        np.testing.assert_allclose(stages.PREDICTIONS[name](c, o), wanted)
    still = operating_point(c, LOADS, 0.0, 0.0, 0.0, 2.5e5, 0.03)
    rho = stages.PREDICTIONS["rho"](c, still)
    np.testing.assert_allclose(rho, shape.deflection(c, still, 0.0, 0.0, 0.0))
    np.testing.assert_allclose(stages.PREDICTIONS["re"](c, still),
                               shape.effective_radius(c, still, 0.0))  # fmt: skip


def test_curvatures_over_load_and_camber():
    """Polynomials of the load: both signs of the slip, and that of the combined weight."""
    names = {f"PEX{i}": v for i, v in ((1, 0.4), (2, -0.3), (3, 0.2), (4, 0.1))}
    names |= {"LEX": 0.9, "REX1": 0.7, "REX2": -0.5, "LEY": 0.8, "REY1": 0.3, "REY2": 0.6}
    names |= {f"PEY{i}": v for i, v in ((1, 0.5), (2, -0.2), (3, 0.3), (4, 0.4), (5, 2.0))}
    names |= {f"QEZ{i}": v for i, v in ((1, 0.6), (2, -0.1), (3, 0.2), (4, 0.3), (5, 0.5))}
    c, dfz, gamma = TIR.replaced(names).coefficients, np.array([-0.5, 0.4]), np.array([-0.1, 0.2])

    def of(output):
        return np.array(_CURVATURES[output](c, dfz, gamma))

    e = 0.9 * np.polyval([0.2, -0.3, 0.4], dfz)
    np.testing.assert_allclose(of("fx"), [0.9 * e, 1.1 * e, np.polyval([-0.5, 0.7], dfz)])
    e = 0.8 * np.polyval([-0.2, 0.5], dfz)
    tilt, skew = 1.0 + 2.0 * gamma**2, 0.3 + 0.4 * gamma
    np.testing.assert_allclose(of("fy"), [e * (tilt - skew), e * (tilt + skew),
                                          np.polyval([0.6, 0.3], dfz)])  # fmt: skip
    e = np.polyval([0.2, -0.1, 0.6], dfz)
    skew = 0.3 + 0.5 * gamma
    np.testing.assert_allclose(of("mz"), [e * (1.0 - skew), e * (1.0 + skew)])


def problem(**more) -> OutputProblem:
    kappa = np.tile([-0.1, -0.02, 0.0, 0.02, 0.1], 3)
    fz = np.repeat(LOADS, 5)
    fx = steady_forces(C, fz, kappa, 0.0, 0.0, 2.5e5, 0.03)[0]
    p = steady_points({"fx": fx}, fz=fz, kappa=kappa, pressure=2.5e5)
    return OutputProblem(
        **{"output": "fx", "points": p, "free": ("PKX1", "PEX1"), "base": C, **more}
    )


def test_rows_of_a_problem():
    """Errors over a hundredth of the load; a wall where a curvature passes one; priors."""
    one = problem()
    x = np.array([[C.PKX1, C.PEX1], [1.1 * C.PKX1, 1.5]])
    rows = one.residuals(x)
    np.testing.assert_allclose(rows[0, :15], 0.0, atol=1e-9)
    np.testing.assert_allclose(one.error_scale(), 0.01 * one.points.fz)
    np.testing.assert_allclose(replace(one, weight=2.0, scatter=3.0).error_scale(),
                               0.015 * one.points.fz)  # fmt: skip
    assert not rows[0, 15:-2].any()
    dfz = np.array([LOADS[0], LOADS[-1]]) / (C.LFZO * C.FNOMIN) - 1.0
    e = (1.5 + C.PEX2 * dfz + C.PEX3 * dfz**2) * C.LEX
    wall = np.concatenate([e * (1.0 - C.PEX4), e * (1.0 + C.PEX4)]) - 1.0
    np.testing.assert_allclose(rows[1, 15:19], 1e3 * np.maximum(wall, 0.0))
    np.testing.assert_allclose(rows[1, -2:], (x[1] - x[0]) / (10.0 * one.sizes))
    known = replace(one, priors={"PEX1": Prior(0.3, 0.05)})
    assert known.residuals(x)[1, -1] == pytest.approx((1.5 - 0.3) / 0.05)
    np.testing.assert_allclose(known.prior_information(np.array([False, False])),
                               np.diag([0.0, 400.0]))  # fmt: skip
    assert known.prior_information(np.array([True, False])).tolist() == [[pytest.approx(400.0)]]
    assert one.limit("PKX1") is COEFFICIENTS["PKX1"]
    tight = replace(one, limits={"PKX1": COEFFICIENTS["PKX1"]._replace(upper=5.0)})
    assert tight.start()[0] == 5.0 and one.start().tolist() == x[0].tolist()
    zero = replace(one, base=TIR.replaced({"PKX1": 0.0}).coefficients)
    assert zero.start()[0] == COEFFICIENTS["PKX1"].start


def test_a_search_from_several_shapes_finds_the_curve():
    off = TIR.replaced({"PKX1": 0.6 * C.PKX1, "PCX1": 1.05, "PEX1": -4.0}).coefficients
    one = problem(free=("PCX1", "PDX1", "PEX1", "PKX1"), base=off)
    found = one.solve(broadly=True)
    assert found.residual[:15] == pytest.approx(np.zeros(15), abs=0.05)
    assert found.x[3] == pytest.approx(C.PKX1, rel=0.01)
    scatter = fit._scatter(one, replace(found, residual=np.ones_like(found.residual)))
    assert scatter == pytest.approx(np.sqrt(15.0 / 11.0))
    assert fit._scatter(replace(one, weight=2.0), replace(found, residual=np.ones(15))) == (
        pytest.approx(2.0 * np.sqrt(15.0 / 11.0))
    )
    assert fit._scatter(one, replace(found, residual=np.zeros(15))) == 1e-3


def solution(x, cost: float = 0.0, n: int = 15) -> Solution:
    residual = np.zeros(n + 2)
    residual[0] = np.sqrt(cost)
    no = np.zeros(len(x), bool)
    return Solution(np.asarray(x, float), residual, np.zeros((n + 2, len(x))), no, no, True, 3)


def test_of_two_solutions_the_better_one_is_taken(monkeypatch):
    """Equally good within 9.2: that of the smaller PKX3."""
    one = problem(free=twins.PAIR)
    found = solution((4.0, 0.5), 100.0)
    for x, cost, mine in (
        ((-4.0, 0.2), 109.3, True), ((-4.0, 0.2), 109.1, False), ((-4.0, -0.6), 109.1, True),
        ((-4.0, 0.9), 90.7, False), ((-4.0, 0.9), 90.9, True),
    ):  # fmt: skip
        other = solution(x, cost)
        monkeypatch.setattr(twins, "_other", lambda *_, other=other: other)
        assert (twins.better_twin(one, found) is found) is mine, (x, cost)
    monkeypatch.setattr(twins, "_other", lambda *_: None)
    assert twins.better_twin(one, found) is found and twins.twin_of(one, found) is None


def test_solutions_are_told_apart_where_most_repeats_would(monkeypatch):
    """Predictions D apart: D^2 - 2 D beyond 9.2 is D beyond 4.2."""
    one = problem(free=twins.PAIR)
    other = solution((-4.0, 0.2), 120.0)
    for apart, cost, told in ((4.3, 100.0, True), (4.1, 100.0, False), (9.0, 111.0, False)):
        rows = np.zeros((2, 17))
        rows[1, 3], rows[1, 16] = apart, 99.0
        monkeypatch.setattr(OutputProblem, "residuals", lambda *_, rows=rows: rows)
        assert twins._told_apart(one, solution((4.0, 0.5), cost), other) is told


def test_the_mirrored_pair_has_the_same_stiffness():
    """K = Fz (PKX1 + PKX2 dfz) exp(PKX3 dfz): the logs of the bracket are odd in PKX2."""
    one = problem(free=twins.PAIR)
    dfz = candidates.levels_of(one.points, "fz") / (C.LFZO * C.FNOMIN) - 1.0
    x = np.array([0.3 * C.PKX1, -0.1])
    mirrored = twins._mirrored(one, x)
    both = [np.log(C.PKX1 + s * x[0] * dfz) + p * dfz for s, p in ((1, x[1]), (-1, mirrored))]
    np.testing.assert_allclose(both[0], both[1], atol=0.01)
    lone = replace(one, points=one.points.rows(one.points.fz == LOADS[1]))
    if abs(LOADS[1] / (C.LFZO * C.FNOMIN) - 1.0) < 1e-3:
        assert twins._mirrored(lone, x) == x[1]
    load = twins._deciding_load(one, x, np.array([-x[0], mirrored]))
    assert load in (1000.0, 8000.0)
    gap = {}
    for fz in (1000.0, 3000.0, 7000.0, 8000.0):
        d = fz / (C.LFZO * C.FNOMIN) - 1.0
        values = [
            fz * (C.PKX1 + s * x[0] * d) * np.exp(p * d) for s, p in ((1, x[1]), (-1, mirrored))
        ]
        gap[fz] = abs(values[1] - values[0])
    assert load == max(gap, key=gap.get)
    assert twins._other(replace(one, priors={"PKX3": Prior(0.0, 1.0)}), solution(x)) is None
    assert twins._other(problem(), solution(x)) is None
    bound = replace(solution(x), at_upper=np.array([False, True]))
    assert twins._other(one, bound) is None


def test_what_becomes_of_the_coefficients_of_a_stage():
    stage = stages.STAGES["stiffness"]
    p = points(4, fz=np.array([2e3, 2e3, 4e3, 4e3]))
    free = stage.outputs["cx"].split()
    kept, lines = fit._told(stage, free, p)
    assert kept == ["LONGITUDINAL_STIFFNESS", "PCFX1"]
    assert lines == [
        "PCFX2 not determined by 2 loads (2000 N, 4000 N); left at the start",
        "PCFX3 not determined by 1 pressure (2.5 bar); left at the start",
    ]
    obstacle = fit._obstacle
    assert obstacle(stage, "cx", [], p) == "all coefficients of cx are fixed"
    assert obstacle(stage, "cx", kept, p.rows([])) == "no measurement of cx"
    assert obstacle(stage, "cx", kept, p.rows([0])) == ""
    pure = stages.STAGES["pure_x"]
    assert obstacle(pure, "fx", ["PKX1"], p.rows([0])) == "one measurement of fx"
    assert "1 slip (+0 %)" in obstacle(pure, "fx", ["PKX1"], p)
    assert obstacle(pure, "fx", ["PKX1"], points(2, kappa=np.array([0.0, 0.1]))) == ""
    pressure = stages.STAGES["pressure"]
    two = points(2, pressure=np.array([2e5, 3e5]))
    assert "slip" in obstacle(pressure, "fx", ["PPX1"], two)
    settings = MFSettings(fixed={"PKX2": 0.0}, free=("PHX1", "RBX3", "PKY4"))
    names = ["PKX1", "PKX2", "PKX3"]
    assert fit._free(names, "fx", settings, {}) == ["PKX1", "PKX3", "PHX1", "RBX3"]
    assert fit._free(names, "fx", settings, {"fx": ["PKX3"]}) == ["PKX1"]
    outputs = {"PKX1": "fx", "RBX1": "fx", "RBX3": "fx", "PKY4": "fy", "QDZ1": "mz",
               "Q_FZ2": "rho", "Q_RE0": "re", "BREFF": "re"}  # fmt: skip
    assert {name: fit._output_of(name) for name in outputs} == outputs
    with pytest.raises(FlatplankError, match="FNOMIN cannot be fitted"):
        fit._output_of("FNOMIN")
    limit = fit._limit("PKX1", MFSettings(bounds={"PKX1": (2.0, 3.0)}))
    assert (limit.lower, limit.upper, limit.start) == (2.0, 3.0, 3.0)
    assert fit._limit("PKX1", MFSettings(bounds={"PKX1": (90.0, 95.0)})).start == 90.0
    assert fit._limit("PKX1", MFSettings()) is COEFFICIENTS["PKX1"]
    assert general_start()["PKX1"] == COEFFICIENTS["PKX1"].start


def test_every_coefficient_belongs_to_the_output_that_it_changes():
    """A free one that no stage has joins that output's first stage."""
    moved = {"LATERAL_STIFFNESS": 1e5, "QBZ1": 9.0, "QCZ1": 1.2, "QDZ1": 0.1, "QDZ6": 0.01,
             "QBZ9": 5.0, "QBZ10": 1.0, "SSZ1": 0.1, "RBX1": 9.0, "RBX2": 9.0, "RCX1": 1.0,
             "RBY1": 9.0, "RBY2": 9.0, "RCY1": 1.0, "RVY1": 0.1, "RVY4": 9.0, "RVY5": 1.9,
             "RVY6": 10.0, "Q_FZ2": 10.0, "BREFF": 6.0, "DREFF": 0.25, "FREFF": 0.02}  # fmt: skip
    base = TIR.replaced({n: v.start or 0.1 for n, v in COEFFICIENTS.items()} | moved)
    axes = LOADS, np.array([0.05, -0.02, 0.03]), np.array([0.08, 0.05, -0.1]), 0.05, 2.2e5

    def of(output, tir):
        c = tir.coefficients
        return stages.PREDICTIONS[output](c, operating_point(c, *axes, 0.03))

    for name in COEFFICIENTS:
        output, more = fit._output_of(name), base.coefficients.__dict__[name] + 0.01
        before, after = of(output, base), of(output, base.replaced({name: more}))
        assert np.any(np.abs(after - before) > 1e-12), (name, output)


def test_a_fit_without_its_points_is_refused():
    p = points(4, kappa=np.array([-0.1, 0.0, 0.1, 0.2]), pressure=3.2e5)
    with pytest.raises(FlatplankError, match=r"nominal pressure of 2.5 bar \(runs are at 3.2 bar"):
        fit_magic_formula(p, TIR, MFSettings(stages=("pure_x",)))
    near = replace(p, pressure=np.full(4, 2.54e5), alpha=np.full(4, 0.1))
    with pytest.raises(FlatplankError) as error:
        fit_magic_formula(near, TIR, MFSettings(stages=("pure_x",)))
    assert "no steady Fx or Fy to fit" in str(error.value) and "(runs" not in str(error.value)
    bare = replace(p, pressure=np.full(4, np.nan))
    with pytest.raises(FlatplankError, match="pressure not said"):
        fit_magic_formula(bare, TIR)
    radius = steady_points({"re": 0.3 + 1e-6 * LOADS}, fz=LOADS, pressure=2.5e5)
    found = fit_magic_formula(radius, TIR, MFSettings(stages=("radius",)))
    assert set(found.fits) == {"re"}
    assert found.cx_source.startswith("not measured: the start value of")
    none = TIR.replaced({"LONGITUDINAL_STIFFNESS": float("nan")})
    assert fit._start_cx(none) == "not known: no fit and no start file tells it"


def test_a_bound_and_too_few_runs_have_no_error():
    one = problem()
    found = one.solve()
    edge = replace(found, at_upper=np.array([True, False]), at_lower=np.array([False, False]))
    told, held = statement.report("fx", one, edge, [])
    pkx, pex = told.estimates
    assert pkx.at_bound == "upper" and not pkx.determined and pkx.note == "rests on its bound"
    assert np.isnan(pkx.std_error) and pex.determined
    assert told.runs == 15 and told.model == "mf:fx"
    assert not held.brought[:, 0].any() and held.brought[:, 1].shape == (15,)
    low = replace(found, at_lower=np.array([True, False]), at_upper=np.array([False, False]))
    assert statement.report("fx", one, low, [])[0].estimates[0].at_bound == "lower"
    # as many coefficients as runs: nothing is left over for an error
    points_of_two = replace(one.points, run=np.arange(15) % 2)
    few = replace(one, points=points_of_two)
    told, _ = statement.report("fx", few, found, [])
    assert (
        np.isnan(told.estimates[0].std_error) and "as many coefficients" in told.estimates[0].note
    )
    three = replace(one, points=replace(one.points, run=np.arange(15) % 3))
    assert np.isfinite(statement.report("fx", three, found, [])[0].estimates[0].std_error)
    shifted = replace(found, residual=found.residual + 2.0)
    told, _ = statement.report("fx", one, shifted, [])
    wanted = np.sqrt(np.mean((0.02 * one.points.fz) ** 2))
    assert told.rmse == pytest.approx(wanted, rel=0.02)


def test_rows_of_points_that_were_not_measured():
    one = problem()
    rows = statement._rows(one, np.array([C.PKX1, C.PEX1]), one.points)
    step = 1e-3
    moved = one.predict(np.array([[C.PKX1 + step, C.PEX1], [C.PKX1 - step, C.PEX1]]))
    numeric = (moved[0] - moved[1]) / (2.0 * step) / one.error_scale()
    np.testing.assert_allclose(rows[:, 0], numeric, atol=1e-4 * np.abs(numeric).max())


def test_fits_of_a_campaign_by_its_model():
    quiet = simulate_runs(Truth(noise=1e-6, gain_scatter=0.0, slip_scatter=0.0,
                                carcass_scatter=0.0), np.random.default_rng(0))  # fmt: skip
    settings = FitFile("nonlinear", bounds={"c_cx": (3e5, 4e5)})
    found = fit_campaign(quiet, settings)
    assert found.fits[0].c_cx.at_bound == "lower" and found.to_json()["problems"] == []
    assert carcass_fits(quiet, settings)[0].c_cx.value == pytest.approx(3e5)
    # options of the carcass are none of the linear model
    assert fit_campaign(quiet[:6], replace(settings, model="linear")).model == "linear"
    assert "three or more" in _run_task(_Task("nonlinear", tuple(quiet[:2]), {}))
    for runs, model, words in (
        (quiet, "mf", "no tire to start from"),
        ([], "linear", "no usable"),
    ):
        with pytest.raises(FlatplankError, match=words):
            fit_campaign(runs, FitFile(model))


def test_a_fit_file_says_what_it_does_not_understand():
    head = {"format": "flatplank-fit/1"}
    for raw, words in (
        ({"stages": 3}, "stages: 3 is not understood"),
        ({"bounds": {"PKX1": [1.0]}}, "write NAME: [number, number]"),
        ({"fixed": {"PKX1": "x"}}, "write a list of names or NAME: number"),
        ({"prior": {"PKX1": [1.0, -1.0]}}, "prior of PKX1 has spread -1"),
        ({"bounds": {"PKX1": [1.0, 1.0]}}, "bounds of PKX1 are 1, 1"),
        ({"geometry": {"q": 1.0}}, "geometry: unknown name q"),
    ):
        with pytest.raises(FlatplankError) as error:
            fit_file.parse_fit(head | raw, "f.yaml")
        assert words in str(error.value)
    good = fit_file.parse_fit(head | {"joint": 0, "fixed": {"friction": 0.9, "PKX1": 20}})
    assert good.joint is False and good.carcass_options() == {"friction": 0.9}
    assert good.mf_settings().fixed == {"friction": 0.9, "PKX1": 20.0}
    with pytest.raises(FlatplankError, match="format is not"):
        fit_file.parse_fit([])


def test_statements_of_an_output_are_kept_together():
    twin = Confusion(("PKX2", "PKX3"), 1.0, "two", "one")
    assert fit.MFFit(
        TIR, {"fx": SimpleNamespace(estimates=(), confusions=(twin,))}, {}
    ).confusions == (twin,)
