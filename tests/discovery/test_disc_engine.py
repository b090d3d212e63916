# SPDX-License-Identifier: Apache-2.0
"""The engine on something that is no tire: a ball that falls, with and without drag."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import dataclass, replace

import numpy as np
import pytest

from flatplank_analysis.discovery.decide import CONDITIONS, _reasons
from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import bounded_step
from flatplank_analysis.discovery.parameters import Parameter, param
from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_analysis.discovery.search import Options, run_search
from flatplank_analysis.discovery.verdict import AT_FLOOR, FOUND, diagnose, undecidable

TIME = np.linspace(0.0, 2.0, 160)
HEIGHTS = (5.0, 10.0, 20.0)
THROWS = (0.0, 2.0, 4.0, 6.0)


@dataclass(frozen=True)
class Drag(Effect):
    """Air slows the ball down with the square of its speed."""

    identifier = "drag"
    kind = "machine"
    coordinate = "time"
    k: float = param(0.0, unit="1/m", bounds=(0.0, 0.5), screen=0.01, matters=0.002)


@dataclass(frozen=True)
class Wind(Effect):
    """A wind pushes upwards, growing with time."""

    identifier = "wind"
    kind = "machine"
    coordinate = "time"
    a: float = param(0.0, unit="m/s3", bounds=(-2.0, 2.0), screen=0.05, matters=0.02)


class Ball:
    """Height of a thrown ball; fitted: gravity and a timing offset of the camera."""

    parameters = (
        Parameter("g", "m/s2", 9.0, 5.0, 15.0, 0.1),
        Parameter("late", "s", 0.0, -0.1, 0.1, 0.01),
    )

    def __init__(self, runs: RunSet) -> None:
        self.runs = runs

    def stiff(self, base):
        return ({"late": 1.0},)

    def predict(self, lanes):
        return np.stack([self._one(lane) for lane in lanes])

    def _one(self, lane):
        g, late = lane.base
        k = a = 0.0
        for effect, values in lane.effects:
            k += values[0] if effect is Drag else 0.0
            a += values[0] if effect is Wind else 0.0
        z, v = self.runs.facts["height"].copy(), self.runs.facts["throw"].copy()
        v = v - (g * late)
        out = np.empty((len(z), len(TIME)))
        dt = TIME[1] - TIME[0]
        for n, t in enumerate(TIME):
            out[:, n] = z
            acceleration = -g - k * v * np.abs(v) + a * t
            z = z + v * dt + 0.5 * acceleration * dt**2
            v = v + acceleration * dt
        return out[None]


def throw(seed: int, k: float, repeats: int = 3, a: float = 0.0) -> Ball:
    """Throws measured by a camera with white noise of 2 cm and a slow drift."""
    rng = np.random.default_rng(seed)
    plan = [(h, v) for h in HEIGHTS for v in THROWS for _ in range(repeats)]
    kinds = sorted(set(plan))
    shape = (len(plan), len(TIME))
    runs = RunSet(
        names=tuple(f"throw {i}" for i in range(len(plan))),
        condition=np.array([kinds.index(p) for p in plan]),
        condition_names=tuple(f"{h} m, {v} m/s" for h, v in kinds),
        channels=("z",),
        measured=np.zeros((1, *shape)),
        time=np.broadcast_to(TIME, shape).copy(),
        order=np.arange(len(plan), dtype=float),
        used=np.ones(shape, dtype=bool),
        coordinates={"time": Coordinate(np.broadcast_to(TIME, shape).copy(), "s", local=True)},
        facts={
            "height": np.array([h for h, _ in plan]),
            "throw": np.array([v for _, v in plan]),
        },
    )
    ball = Ball(runs)
    from flatplank_analysis.discovery.model import Lane

    hidden = ((Drag, np.array([k])), (Wind, np.array([a])))
    truth = ball.predict([Lane(np.array([9.81, 0.01]), hidden)])[0]
    slow = np.cumsum(rng.standard_normal(shape), axis=1) * 0.001
    runs.measured[:] = truth + 0.02 * rng.standard_normal(shape) + slow
    return ball


@pytest.mark.parametrize("seed", [1, 2])
def test_drag_is_found_with_its_size(seed):
    search = run_search(throw(seed, 0.02), [Drag, Wind], Options())
    result = diagnose(search)
    assert result.verdict == FOUND, result.reason
    assert [f.decision.term.effect.identifier for f in result.found] == ["drag"]
    low, high = result.found[0].decision.interval
    assert result.found[0].decision.term.size == pytest.approx(0.02, rel=0.1)
    assert low < 0.0215 and high > 0.0185
    assert result.rmse_after < 0.5 * result.rmse_before


@pytest.mark.parametrize(("step", "told"), [(np.nan, False), (1.5, True)])
def test_one_step_position_is_told_and_none_is_no_fault(step, told):
    ball = throw(3, 0.0)
    facts = {**ball.runs.facts, "step": np.full(ball.runs.runs, step)}
    ball.runs = replace(ball.runs, facts=facts)
    result = diagnose(run_search(ball, [Drag], Options()))
    assert any("one step position" in note for note in result.notes) is told


def test_two_effects_are_found_and_an_unsure_one_is_refused():
    """What the form of a law leaves over differs between conditions, too."""
    found = run_search(throw(1, 0.02, a=1.0), [Drag, Wind], Options()).last.found
    assert {f.decision.term.effect for f in found} == {Drag, Wind}
    sure = replace(found[0].decision, p_repeats=0.0, p_conditions=0.5 * CONDITIONS)
    unsure = replace(sure, p_conditions=2.0 * CONDITIONS)
    reason = "not beyond the scatter among conditions"
    assert reason in tuple(_reasons(unsure, 0.0))
    assert reason not in tuple(_reasons(sure, 0.0))


def test_nothing_is_found_where_nothing_is():
    result = diagnose(run_search(throw(3, 0.0), [Drag, Wind], Options()))
    assert result.verdict == AT_FLOOR, result.reason
    assert not result.found
    assert result.to_dict()["effects"] == []
    size, unit = result.detectable["drag"]
    assert 0.0 < size < 0.02 and unit == "1/m"


def test_too_little_is_said_to_be_too_little():
    assert "no repeats" in undecidable(throw(4, 0.0, repeats=1).runs)
    assert "runs" in undecidable(throw(4, 0.0).runs.subset(np.arange(4)))


def test_engine_knows_no_tires():
    code = (
        "import sys, flatplank_analysis.discovery.search, flatplank_analysis.discovery.verdict, "
        "flatplank_analysis.discovery.nextrun, flatplank_analysis.discovery.score\n"
        "bad = [m for m in sys.modules if m.startswith(('flatplank_analysis.tirebase', "
        "'flatplank_analysis.effects', 'flatplank_analysis.models'))]\n"
        "sys.exit(repr(bad) if bad else 0)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_bounded_step_holds_the_box():
    hessian = np.array([[2.0, 0.5], [0.5, 1.0]])
    slope = np.array([4.0, -1.0])
    free = bounded_step(hessian, slope, np.full(2, -10.0), np.full(2, 10.0), 0.0)
    np.testing.assert_allclose(hessian @ free, slope, rtol=1e-6)
    held = bounded_step(hessian, slope, np.full(2, -10.0), np.array([1.0, 10.0]), 0.0)
    assert held[0] == pytest.approx(1.0)
    assert held[1] == pytest.approx(-1.5, rel=1e-6)
