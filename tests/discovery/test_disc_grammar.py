# SPDX-License-Identifier: Apache-2.0
"""The grammar of proposals: every piece of it makes an effect file that keeps the contract."""

from __future__ import annotations

from copy import deepcopy
from dataclasses import replace

import numpy as np
import pytest
from bristles import Truth, campaign

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.tire_runs import coordinates_of
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.effects.checks import check_effect, probe_of
from flatplank_analysis.effects.grammar.file import renamed, text_of
from flatplank_analysis.effects.grammar.hooks import HOOKS, NONE
from flatplank_analysis.effects.grammar.modulators import BY_NAME, MODULATORS
from flatplank_analysis.effects.grammar.sentence import Sentence, Site, SiteCoordinate, effect_of
from flatplank_analysis.effects.grammar.shapes import shapes
from flatplank_analysis.effects.grammar.shapes.base import ANGLE, LEVEL, PLACE, SIGNAL, Span
from flatplank_analysis.effects.registry import load_file
from flatplank_analysis.proposal.curves import effect_of_curve
from flatplank_analysis.proposal.sites import sites_of, varying_coordinates
from flatplank_data.errors import FlatplankError

OVER = {
    PLACE: ("plank position", Span(0.0, 4.15, PLACE, "m")),
    ANGLE: ("wheel angle", Span(0.0, 2.0 * np.pi, ANGLE, "rad")),
    LEVEL: ("run order", Span(0.0, 26.0, LEVEL)),
    SIGNAL: ("temperature", Span(-12.0, 31.0, SIGNAL, "degC")),
    NONE: ("", Span(0.0, 1.0, NONE)),
}
TOLD = (
    "From 27 runs of 9 conditions of summer_tires.",
    "Error of Fx 28.4 -> 20.1 N, floor 20.0 N; in left-out conditions 20.1 N, in left-out levels "
    "21.0 N.",
    "These runs cannot tell it from: a factor on Fx over plank position, only while driving; a "
    "load on the tire that the load channel does not show over plank position.",
)
"""of a proposal that resembles two others"""
HOOK = {h.name: h for h in HOOKS}


def sentence(hook: str, kind: str, shape: str, modulator: str = "") -> Sentence:
    """A sentence with every number in the middle of what is looked at."""
    name, span = OVER[kind]
    if shape == "ringing":
        name, span = "distance since the step", Span(-1.5, 2.65, PLACE, "m")
    form = shapes()[shape]
    numbers = {n.name: float(np.median(list(n.grid(span)))) for n in form.numbers}
    site = Site(HOOK[hook], SiteCoordinate(name, span, np.zeros((1, 1))), BY_NAME[modulator])
    return Sentence(site, form, numbers, interval=(1.0, 2.0), evidence=("Seen.",))


CASES = [("fx", k, s.name) for s in shapes().values() for k in s.kinds]
CASES += [
    (h.name, k, {PLACE: "bump", LEVEL: "threshold"}[k])
    for h in HOOKS
    for k in (PLACE, LEVEL)
    if k in h.kinds
]


@pytest.mark.parametrize("hook, kind, shape", CASES)
def test_file_keeps_the_contract(hook, kind, shape, tmp_path):
    said = sentence(hook, kind, shape, "driving" if kind == NONE else "")
    file = tmp_path / f"{said.identifier}.yaml"
    file.write_text(text_of(said))
    (effect,) = load_file(file)
    assert check_effect(effect) == []
    assert effect.identifier == said.identifier


@pytest.mark.parametrize("modulator", [m.name for m in MODULATORS])
def test_modulators_keep_the_contract(modulator):
    effect = effect_of(sentence("fx", SIGNAL, "ramp", modulator))
    assert check_effect(effect) == []


@pytest.mark.parametrize("hook, kind, shape", CASES)
def test_file_is_short_and_within_the_margin(hook, kind, shape):
    said = replace(sentence(hook, kind, shape, "driving"), evidence=TOLD)
    lines = text_of(said).splitlines()
    assert 10 <= len(lines) <= 40
    assert max(map(len, lines)) <= 99


@pytest.mark.parametrize("name", ['oil "A"', "a\\b", "Öl 1", "x" * 70, ("long name " * 8).strip()])
def test_a_column_may_have_any_name(name, tmp_path):
    said = sentence("fx", SIGNAL, "ramp")
    said = replace(
        said, site=replace(said.site, coordinate=replace(said.site.coordinate, name=name))
    )
    said = replace(said, evidence=(f"over {name}",))
    file = tmp_path / "proposed.yaml"
    file.write_text(text_of(said), encoding="utf-8")
    (effect,) = load_file(file)
    assert effect.coordinate == name and check_effect(effect) == []


def test_every_shape_stays_finite_over_its_grid():
    for shape in shapes().values():
        for kind in shape.kinds:
            span = OVER[kind][1]
            u = np.linspace(span.low, span.high, 200)[None]
            time = np.linspace(0.0, 100.0, 200)[None]
            for n in shape.numbers:
                low, high = n.bounds(span)
                assert low < high and all(low <= v <= high for v in n.grid(span)), shape.name
            middle = {n.name: float(np.median(list(n.grid(span)))) for n in shape.numbers}
            found = shape.values(span, u, middle, time)
            assert found.shape == (len(shape.sizes), 1, 200), shape.name
            assert np.isfinite(found).all() and np.ptp(found) > 0.0 or kind == NONE, shape.name


def test_file_does_what_the_search_saw():
    """The written effect and the curve of the search give the same forces."""
    said = sentence("fx", PLACE, "bump", "driving")
    effect = effect_of(said)
    model = probe_of(effect)
    u = model.data.coordinate("plank position")
    basis = said.shape.values(said.site.coordinate.span, u, said.numbers)
    curve = effect_of_curve(said.site, basis)
    base = np.array([p.null for p in model.parameters])
    named = {"amount": 30.0}
    written = model.predict([ParameterSet(base, ((effect, effect.vector(named)),))])
    curved = model.predict([ParameterSet(base, ((curve, np.array([30.0])),))])
    assert np.allclose(written, curved, atol=1e-3)
    assert np.ptp(written - model.predict([ParameterSet(base)])) > 20.0


def test_a_delay_is_nothing_while_time_stands():
    """Runs whose plank begins later than others have several nodes at one time."""
    effect = effect_of(sentence("delay", PLACE, "ramp"))
    model = deepcopy(probe_of(effect))  # the probe is one for all
    model.data.runs.time[:, :4] = model.data.runs.time[:, 3:4]
    base = np.array([p.null for p in model.parameters])
    predicted = model.predict([ParameterSet(base, ((effect, effect.vector({"amount": 0.1})),))])
    assert np.isfinite(predicted).all()


def test_a_long_delay_is_a_shift_by_its_whole_length():
    """Not only its first order: three tenths of a second beside a relaxation of one."""
    said = sentence("delay", PLACE, "ramp")
    effect = effect_of(said)
    model = probe_of(effect)
    base = np.array([p.null for p in model.parameters])
    (plain,) = model.predict([ParameterSet(base)])
    (late,) = model.predict([ParameterSet(base, ((effect, effect.vector({"amount": 0.6})),))])
    span, time = said.site.coordinate.span, model.data.runs.time
    delay = 0.6 * (model.data.coordinate(said.site.coordinate.name) - span.middle) / span.width
    fx = model.data.runs.channels.index("fx")
    wanted = [np.interp(t - d, t, v) for t, d, v in zip(time, delay, plain[fx], strict=True)]
    assert np.ptp(delay) > 0.5
    assert np.ptp(plain[fx] - wanted) > 20.0
    np.testing.assert_allclose(late[fx], wanted, atol=1e-6)


def test_many_sizes_at_once_are_as_one_by_one():
    """What only the sensors show needs the forces of the tire once."""
    for hook in ("fx", "gain", "load"):
        effect = effect_of(sentence(hook, PLACE, "bump"))
        model = probe_of(effect)
        base = np.array([p.null for p in model.parameters])
        sets = [
            ParameterSet(base, ((effect, effect.vector({"amount": a})),)) for a in (0.0, 0.1, 9.0)
        ]
        alone = np.concatenate([model.predict([one]) for one in sets])
        assert np.array_equal(model.predict(sets), alone), hook
        assert not np.array_equal(alone[0], alone[2]), hook


def test_sites_are_what_the_runs_can_show():
    data = probe_of(effect_of(sentence("fx", PLACE, "bump"))).data
    places = varying_coordinates(data)
    names = [p.name for p in places]
    assert "plank position" in names and "slip level" not in names
    assert set(names[1:]) <= set(coordinates_of(data))
    sites = sites_of(data, places)
    keys = {s.key for s in sites}
    assert len(keys) == len(sites)
    # a constant is the base's own, unless something turns it on and off
    assert {("friction", "", "driving"), ("gain", "", "braking")} <= keys
    assert ("fx", "", "") not in keys
    # a load over itself is a power of it
    assert ("fx", "load", "load") not in keys


def test_conditions_one_after_the_other_are_no_run_order():
    """What differs between conditions would pass for a change with time."""
    mixed = list(campaign(Truth(seed=74, slips=(-0.05, -0.01, 0.0, 0.01, 0.05))))
    assert "run order" in [p.name for p in varying_coordinates(from_tables(mixed))]
    sorted_ = [
        t.with_info(run_index=i) for i, t in enumerate(sorted(mixed, key=lambda t: t.info.kappa))
    ]
    assert "run order" not in [p.name for p in varying_coordinates(from_tables(sorted_))]


def test_a_proposal_gets_the_name_of_its_cause(tmp_path):
    said = renamed(sentence("fx", PLACE, "bump"), "cable_drag")
    file = tmp_path / "cable_drag.yaml"
    file.write_text(text_of(said))
    (effect,) = load_file(file)
    assert (effect.identifier, effect.__name__) == ("cable_drag", "CableDrag")
    assert check_effect(effect) == []
    with pytest.raises(FlatplankError, match="no identifier"):
        renamed(said, "Cable drag")
