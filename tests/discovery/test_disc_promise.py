# SPDX-License-Identifier: Apache-2.0
"""The proposed run is made, and the class becomes its true member, as surely as was promised."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from ball import TIME, Ball, Drag, throw

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.discovery.fit import Term
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import RunSet
from flatplank_analysis.inference.nextrun import EXCLUDED, Pair, next_run
from flatplank_analysis.inference.search import run_search


@dataclass(frozen=True)
class Thick(Effect):
    """Air slows the ball down with its speed to the power of 1.6, as it does at lower speeds."""

    identifier, kind, coordinate = "thick", "machine", "time"
    c: float = param(0.0, unit="1/m", bounds=(0.0, 0.5), screen=0.01, matters=0.002)


class Fall(Ball):
    """A ball in the air."""

    def _one(self, one):
        powers = {Drag: 2.0, Thick: 1.6}
        g, late = one.base
        z, v = self.runs.facts["height"].copy(), self.runs.facts["throw"] - g * late
        out, dt = np.empty((len(z), len(TIME))), TIME[1] - TIME[0]
        for n in range(len(TIME)):
            out[:, n] = z
            slowed = sum(s[0] * np.sign(v) * np.abs(v) ** powers[e] for e, s in one.effects)
            z = z + v * dt - 0.5 * (g + slowed) * dt**2
            v = v - (g + slowed) * dt
        return out[None]


@dataclass(frozen=True)
class Plan:
    """Throws that can be made."""

    text: str
    settings: dict[str, Any]
    model: Fall


def plan_of(model: Fall, speed: float, count: int = 3) -> Plan:
    """Balls thrown with a speed [m/s] from 10 m, one kind."""
    runs = model.runs
    shape = (count, runs.samples)
    planned = RunSet(
        names=("planned",) * count, condition=np.zeros(count, dtype=int),
        condition_names=(f"10 m, {speed} m/s",), channels=runs.channels,
        measured=np.zeros((1, *shape)), time=np.broadcast_to(TIME, shape).copy(),
        order=np.arange(count, dtype=float), coordinates={},
        facts={"height": np.full(count, 10.0), "throw": np.full(count, speed)},
    )  # fmt: skip
    return Plan(f"thrown with {speed:g} m/s", {"speed": speed}, Fall(planned))


def joined(model: Fall, plan: Plan, repeats: int, truth: ParameterSet, seed: int) -> Fall:
    """The campaign with the planned throws made, with the noise of the camera."""
    random, old, new = np.random.default_rng(seed), model.runs, plan.model.runs
    exact = np.tile(plan.model.predict([truth])[0], (1, repeats, 1))
    slow = 0.001 * np.cumsum(random.standard_normal(exact.shape), axis=2)
    measured = exact + slow + 0.02 * random.standard_normal(exact.shape)
    count = exact.shape[1]
    names = (*old.condition_names, *new.condition_names)
    both = {name: np.concatenate([v, np.tile(new.facts[name], repeats)])
            for name, v in old.facts.items()}  # fmt: skip
    total = old.runs + count
    time = np.broadcast_to(TIME, (total, len(TIME))).copy()
    return Fall(replace(
        old, names=tuple(f"throw {i}" for i in range(total)),
        condition=np.concatenate([old.condition, np.full(count, len(old.condition_names))]),
        condition_names=names, measured=np.concatenate([old.measured, measured], axis=1),
        time=time, order=np.arange(total, dtype=float), facts=both,
        coordinates={"time": replace(old.coordinates["time"], values=time)},
    ))  # fmt: skip


def log_odds(model: Fall) -> tuple[set[str], float]:
    """Names and class of what is found; logarithm of the odds of the rival."""
    search = run_search(model, [Drag, Thick])
    told = {n for f in search.last.found for n in (f.decision.term.effect.identifier, *f.alike)}
    scales = search.scales
    found, *_ = (w for key, w in search.posterior.sets.items() if key == ("drag",))
    rival = scales.with_term(
        scales.fitter.without_term(found.fit, 0), Term(Thick, np.array([0.004]))
    )
    both = replace(search.posterior, sets={("drag",): found, ("thick",): rival})
    return told, both.logs[("thick",)]


def test_the_proposed_run_excludes_the_rival_as_surely_as_was_promised():
    """Two powers of the speed: balls that fall from rest show hardly a difference."""
    size, runs = 0.004, throw(2, 0.004).runs
    before = Fall(runs.subset(np.flatnonzero(runs.facts["throw"] == 0.0)))
    search = run_search(before, [Drag, Thick])
    (found,) = search.last.found
    assert {found.decision.term.effect.identifier, *found.alike} == {"drag", "thick"}
    plans = [plan_of(before, speed) for speed in (0.0, -5.0, -10.0)]
    assert "settings" not in next_run(search, plans[:1])
    told = next_run(search, plans)
    assert told["settings"] == {"speed": -10.0} and told["separates"] == [["drag"], ["thick"]]
    # the worse of both cases is told; the ball falls through air
    pair = Pair(search, search.rival_set(0, "thick"), search.posterior.best)
    parts = [part.times(told["repeats"]) for part in pair.contrast.products(plans[-1].model)]
    expected, most = pair.promise(parts, told["repeats"] * 3)
    assert expected < math.log(told["odds"]) < EXCLUDED
    truth = ParameterSet(np.array([9.81, 0.01]), ((Drag, np.array([size])),))
    made = [log_odds(joined(before, plans[-1], told["repeats"], truth, s)) for s in range(5)]
    assert [names for names, _ in made] == [{"drag"}] * 5
    measured = [log for _, log in made]
    assert max(measured) < most < EXCLUDED
    assert np.median(measured) == pytest.approx(expected, rel=0.35)
