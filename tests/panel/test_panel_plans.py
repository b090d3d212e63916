# SPDX-License-Identifier: Apache-2.0
"""Every run that the discovery can propose becomes a plan that says the same, or is refused with
the name of what a plan cannot say."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest
from made_up import campaign

from flatplank_analysis.contact_patch.plans import plans_for
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery import verdict
from flatplank_control.runner.campaign import load_plan
from flatplank_data.waveforms import WAVEFORMS
from flatplank_panel.analysis.fit_jobs import runs_of
from flatplank_panel.next_plan import block_of, plans_of, write_next

RUN = {"kappa": 0.05, "fz": 3700.0, "pressure": 2.5, "step_position": 1.5}


@pytest.fixture(scope="module")
def session(tmp_path_factory) -> Session:
    return Session.open(str(campaign(tmp_path_factory.mktemp("plans") / "made_up")))


def slips_of(plan) -> list:
    """The runs that were asked for, without those that only give r_e."""
    return [r.measurement for r in plan.runs if r.role == "run"]


def asked(m, key: str) -> float:
    """What a run of the plan does, in the words of a proposal."""
    wave = WAVEFORMS[m.waveform](**m.slip_parameters())
    step = m.waveform_parameters.get("length", m.step_position)
    made = {
        "kappa": wave.slip(step - m.step_position + 1e-6),
        "step_position": step,
        "preload": wave.slip(0.0) if m.step_position == 0.0 else 0.0,
        "start": 1.0 + m.start_angle / 120.0,
    }
    return made[key] if key in made else getattr(m, key)


def test_every_proposal_around_the_campaign_is_a_plan(session, tmp_path):
    plans = plans_for(session.model)
    assert {"speed", "preload"} < {k for p in plans for k in p.settings}
    for plan in plans:
        wish = {"what": plan.text, "settings": plan.settings, "repeats": 2}
        runs = slips_of(load_plan(write_next(runs_of(session, wish), "x", tmp_path)))
        settings = dict(plan.settings)
        starts = settings.pop("starts")
        assert sorted(asked(run, "start") for run in runs) == pytest.approx(sorted(2 * starts))
        for key, value in settings.items():
            assert asked(runs[0], key) == pytest.approx(value), (plan.text, key)


@pytest.mark.parametrize("found", [verdict.NONE, verdict.PARTLY])
def test_the_fixed_proposal_becomes_a_run_per_condition(session, tmp_path, found):
    names = session.data.runs.condition_names
    result = SimpleNamespace(verdict=found, events=[SimpleNamespace(conditions=names[:2])])
    proposal = session.fixed_proposal(result)
    assert set(proposal["settings"]) == {"step_position", "conditions"}
    path = write_next(runs_of(session, proposal), "x", tmp_path)
    made = {(m.kappa, m.fz, m.step_position) for m in slips_of(load_plan(path))}
    assert made == {(-0.05, 3700.0, 2.2), (0.02, 3700.0, 2.2)}
    assert len(slips_of(load_plan(path))) == 2 * proposal["repeats"]


def test_what_the_campaign_holds_constant_is_in_the_plan(session, tmp_path):
    wish = {"settings": {"kappa": 0.02, "step_position": 0.9}}
    run = slips_of(load_plan(write_next(runs_of(session, wish), "x", tmp_path)))[0]
    assert (run.tire, run.fz, run.pressure, run.alpha_deg) == ("TOY", 3700.0, 2.5, 0.0)


@pytest.mark.parametrize("key", ["speed", "humidity"])
def test_what_no_plan_can_say_is_named(key, tmp_path):
    with pytest.raises(ValueError, match=key):
        write_next({"tire": "TOY", "runs": [RUN | {key: 1.5}]}, "x", tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("key", ["kappa", "step_position"])
def test_nothing_is_made_up(key):
    with pytest.raises(ValueError, match=key):
        block_of({k: v for k, v in RUN.items() if k != key})


@pytest.mark.parametrize("load", [99_000.0, math.nan])
def test_a_plan_that_the_bench_refuses_leaves_no_file(load, tmp_path):
    with pytest.raises(ValueError, match="fz"):
        write_next({"tire": "TOY", "runs": [RUN | {"fz": load}]}, "x", tmp_path)
    assert not list(tmp_path.iterdir())


def test_no_run_no_plan(tmp_path):
    with pytest.raises(ValueError, match="no run"):
        write_next({"what": "check on the machine"}, "x", tmp_path)


def test_the_plan_is_offered_and_a_note_stays_a_note(tmp_path):
    path = write_next({"tire": "TOY", "what": "a\nname: b", "runs": [RUN]}, "x", tmp_path)
    assert load_plan(path).name == "next_run_x"
    offered = plans_of(tmp_path)
    assert offered["plans/next_run_x.yaml"] == path and "toyo longitudinal" in offered
