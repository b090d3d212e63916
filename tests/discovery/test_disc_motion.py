# SPDX-License-Identifier: Apache-2.0
"""Motions, what they may lack, and their records: against formulas, and bad input in one line."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

import flatplank_analysis as fp
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.machines.records import step_of


class Oscillator(fp.Motion):
    """A mass on a spring."""

    stiffness = fp.param(40.0, unit="1/s2", bounds=(0.0, 1e3), screen=1.0)
    viscous = fp.param(0.8, unit="1/s", bounds=(0.0, 1e9), screen=0.1)
    dry = fp.param(0.0, unit="m/s2", bounds=(0.0, 10.0), screen=0.1)

    def force(self, p, s):
        return -p.stiffness * s.x + s.pull

    def damping(self, p, s):
        return p.viscous

    def friction(self, p, s):
        return p.dry


class OilFilm(fp.Missing):
    """A film of oil. It resists in proportion
    to the speed.
    """

    check = "Wipe it off."
    c = fp.param(0.0, unit="1/s", bounds=(0.0, 10.0), screen=0.1)
    damping = staticmethod(lambda p, s: p.c)


class Magnet(fp.Missing):
    """A magnet that pulls."""

    check = "Take it away."
    a = fp.param(0.0, unit="m/s2", bounds=(-10.0, 10.0), screen=0.1)
    force = staticmethod(lambda p, s: p.a * s.near)


def records(pull=0.0, start=1.0):
    time = np.linspace(0.0, 4.0, 401)
    pulls = pull * np.ones_like(time)
    return [
        fp.Record(f"{near}", time, start + 0.0 * time, {"pull": pulls}, {"near": near})
        for near in (0.0, 1.0)
    ]


def model(**kind) -> Oscillator:
    return Oscillator(fp.table_of(records(**kind), "x", "m", nodes=81))


def test_a_motion_is_that_of_the_formula():
    here = model()
    (x,) = here.predict([ParameterSet(np.array([40.0, 0.8, 0.0]))])[0, :, 0]
    t, omega = here.runs.time[0], np.sqrt(40.0 - 0.16)
    wanted = np.exp(-0.4 * t) * (np.cos(omega * t) + 0.4 / omega * np.sin(omega * t))
    assert np.abs(x - wanted).max() < 4e-3


def test_dry_friction_takes_equal_steps_and_holds():
    """Each half swing ends 2 mu / k lower (Coulomb), and what is held does not move at all."""
    (x,) = model().predict([ParameterSet(np.array([40.0, 0.0, 2.0]))])[0, :, 0]
    half = np.pi / np.sqrt(40.0)
    at = np.interp(half * np.arange(1, 6), model().runs.time[0], x)
    assert np.abs(at) == pytest.approx(1.0 - 0.1 * np.arange(1, 6), abs=0.01)
    still = model(pull=1.9, start=0.0).predict([ParameterSet(np.array([40.0, 0.0, 2.0]))])
    assert np.all(still == 0.0)
    moved = model(pull=2.1, start=0.0).predict([ParameterSet(np.array([40.0, 0.0, 2.0]))])
    assert moved[..., -1].min() > 0.0


def test_no_number_makes_it_unstable():
    x = model().predict([ParameterSet(np.array([40.0, 1e8, 0.0]))])
    assert np.isfinite(x).all() and np.abs(x).max() <= 1.0


def test_an_effect_is_what_the_model_would_have():
    base = np.array([40.0, 0.8, 0.0])
    sets = [
        ParameterSet(base),
        ParameterSet(base, ((OilFilm, np.array([0.5])),)),
        ParameterSet(base, ((OilFilm, np.array([0.2])), (OilFilm, np.array([0.3])))),
        ParameterSet(base, ((Magnet, np.array([3.0])),)),
        ParameterSet(base + [0.0, 0.5, 0.0]),
    ]
    plain, oiled, twice, pulled, thick = model().predict(sets)[:, 0]
    assert oiled == pytest.approx(thick) and twice == pytest.approx(thick)
    # the fact of a record decides where it acts
    assert pulled[0] == pytest.approx(plain[0])
    assert pulled[1, -1] - plain[1, -1] == pytest.approx(3.0 / 40.0, rel=0.3)
    alone = model().predict(sets[3:4])[0, 0]
    assert alone == pytest.approx(pulled)


def test_a_class_says_what_it_is():
    assert OilFilm.identifier == "oil_film" and OilFilm.title == "A film of oil"
    assert OilFilm.what == "It resists in proportion to the speed."
    assert [p.name for p in OilFilm.parameters()] == ["c"]
    assert Magnet.what == "A magnet that pulls."
    assert [p.name for p in Oscillator.parameters] == ["stiffness", "viscous", "dry"]


def test_inputs_act_between_the_nodes_as_recorded():
    time = np.linspace(0.0, 1.0, 1001)
    pull = np.where(time < 0.05, 20.0, 0.0)
    runs = fp.table_of(
        [fp.Record("push", time, 0.0 * time, {"pull": pull}, {"near": 0.0})], "x", "m", nodes=11
    )
    (x,) = Oscillator(runs).predict([ParameterSet(np.zeros(3))])[0, 0]
    assert x[-1] == pytest.approx(1.0 * (1.0 - 0.025), rel=0.03)


@pytest.mark.parametrize(
    ("shape", "between"),
    [("line", lambda t: t), ("held", np.floor), ("spline", lambda t: t**2)],
)
def test_an_input_is_a_line_held_or_a_spline_between_its_samples(shape, between):
    time = np.arange(5.0)
    given = {"held": time, "line": time, "spline": time**2}[shape]
    record = fp.Record("one", time, 0.0 * time, {"pull": given})
    runs = fp.table_of([record], "x", "m", nodes=9, inputs={"pull": shape})
    half = np.arange(0.0, 4.5, 0.5)
    assert runs.inputs["pull"][0] == pytest.approx(between(half))
    fine = np.linspace(0.0, 4.0, 8 * 20 + 1)
    assert runs.facts["pull between nodes"][0] == pytest.approx(between(fine + 1e-9), abs=1e-6)


def fallen(seed: int, height: float) -> fp.Record:
    """A drop with air drag of 0.02 1/m, as a camera sees it: closed form."""
    time = np.arange(0.0, 1.6, 0.02)
    z = height - np.log(np.cosh(time * np.sqrt(9.81 * 0.02))) / 0.02
    z += 0.005 * np.random.default_rng(seed).standard_normal(len(time))
    return fp.Record(f"drop {seed}", time, z, condition=f"{height} m", begin=(height, 0.0))


class Ball(fp.Motion):
    """Height of a ball, with a spring that no drop shows."""

    g = fp.param(9.0, unit="m/s2", bounds=(5.0, 15.0), screen=0.1)
    spring = fp.param(1.0, unit="1/s2", bounds=(0.0, 5.0), screen=0.1)

    def force(self, p, s):
        return -p.g - p.spring * np.maximum(-100.0 - s.x, 0.0)


class Drag(fp.Missing):
    """Air resistance."""

    k = fp.param(0.0, unit="1/m", bounds=(0.0, 0.5), screen=0.01, matters=0.002)
    damping = staticmethod(lambda p, s: p.k * np.abs(s.v))


def test_a_diagnosis_of_any_machine_goes_on_with_the_effect_in_its_model():
    drops = [fallen(10 * h + n, float(h)) for h in range(14, 26, 2) for n in (1, 2)]
    before = fp.explain(Ball(fp.table_of(drops, "height", "m", nodes=40)), [Drag])
    assert before.verdict == "found" and before.effects.name.tolist() == ["drag"]
    assert list(before.conditions.condition) == [f"{h}.0 m" for h in range(14, 26, 2)]
    assert (before.conditions.floors < 1.5).all()
    assert any("no sample of these runs shows spring" in n for n in before.result.notes)
    after = before.add("drag")
    assert (after.verdict, len(after.effects)) == ("at floor", 0)
    assert after.result.rmse_before == pytest.approx(before.result.rmse_after, rel=1e-3)
    fitted = after.parameters.set_index("name")
    assert fitted.loc["g", "value"] == pytest.approx(9.81, rel=0.01)
    assert fitted.loc["k", "value"] == pytest.approx(0.02, rel=0.05)
    assert fitted.loc["k", ["of", "unit"]].tolist() == ["drag", "1/m"]
    assert "tire" not in f"{before!r} {after!r}".lower()
    with pytest.raises(fp.FlatplankError, match="no effect 'drga'.*the nearest is 'drag'"):
        before.add("drga")
    with pytest.raises(fp.FlatplankError, match="in the model already"):
        after.add("drag")


def test_records_end_with_the_shortest_and_repeat_by_their_condition():
    long, short = np.linspace(0.0, 3.0, 301), np.linspace(1.0, 3.0, 101)
    runs = fp.table_of(
        [fp.Record("a", long, np.round(long, 1), condition="x"),
         fp.Record("b", short, short, condition="x")], "x", "m", nodes=5,
    )  # fmt: skip
    assert runs.time.tolist() == [[0.0, 0.5, 1.0, 1.5, 2.0]] * 2
    assert runs.condition.tolist() == [0, 0] and runs.repeated
    assert runs.coordinates["speed"].unit == "m/s"


def test_the_step_of_a_record():
    t = np.linspace(0.0, 10.0, 5000)
    assert step_of(np.round(np.sin(t) / 0.01) * 0.01) == pytest.approx(0.01)
    assert step_of(np.ones(10)) == 0.0


def test_tables_of_any_file_are_alike(tmp_path):
    time, x = np.arange(5.0), np.arange(5.0) ** 2
    (tmp_path / "a.csv").write_text(
        "time, x\n" + "".join(f"{t},{v}\n" for t, v in zip(time, x, strict=True))
    )
    savemat(tmp_path / "a.mat", {"time": time, "x": x, "mass": 2.0})
    signal = {"time": time, "signals": {"values": x}}
    savemat(tmp_path / "b.mat", {"x": signal})
    rows = [{"time": t, "x": v} for t, v in zip(time, x, strict=True)]
    (tmp_path / "a.json").write_text(json.dumps({"mass": 2.0, "tags": ["a"], "entries": rows}))
    for name in ("a.csv", "a.mat", "b.mat", "a.json"):
        table = fp.read_table(tmp_path / name)
        assert fp.column(table, "t", "time").tolist() == time.tolist()
        assert fp.column(table, "x").tolist() == x.tolist()
    for name in ("a.json", "a.mat"):
        assert fp.read_table(tmp_path / name).attrs["mass"] == 2.0
    text = (tmp_path / "a.csv").read_text().replace(", ", ";").replace(",", ";")
    (tmp_path / "b.csv").write_text(text)
    (tmp_path / "b.txt").write_text(text.replace(";", "\t").replace("time", "Time"))
    for name in ("b.csv", "b.txt"):
        assert fp.column(fp.read_table(tmp_path / name), "time").tolist() == time.tolist()


@pytest.mark.parametrize(
    ("name", "content", "line"),
    [
        ("a.xls", "", "'.xls' is no kind of file"),
        ("no.csv", None, "no such file"),
        ("a.json", "{", "cannot be read: "),
        ("a.json", "{}", "cannot be read: "),
        ("a.json", "[]", "holds no table"),
        ("a.mat", "no mat", "cannot be read: "),
        ("a.csv", "time,x\n", "holds no table"),
    ],
)
def test_a_bad_file_is_one_line(name, content, line, tmp_path):
    if content is not None:
        (tmp_path / name).write_text(content)
    with pytest.raises(fp.FlatplankError, match=line) as raised:
        fp.read_table(tmp_path / name)
    assert "\n" not in str(raised.value) and name in str(raised.value)


def test_bad_records_are_one_line():
    time = np.linspace(0.0, 1.0, 11)
    with pytest.raises(fp.FlatplankError, match="no column y.*it has time, x"):
        fp.column(pd.DataFrame({"time": time, "x": time}), "y")
    with pytest.raises(fp.FlatplankError, match="column x holds no numbers"):
        fp.column(pd.DataFrame({"x": ["a"]}), "x")
    with pytest.raises(fp.FlatplankError, match="no records"):
        fp.table_of([], "x", "m", nodes=5)
    with pytest.raises(fp.FlatplankError, match="record short: 2 positions for 11 times"):
        fp.table_of([fp.Record("short", time, time[:2])], "x", "m", nodes=5)
    with pytest.raises(fp.FlatplankError, match="record b: no fact 'mass', which a has"):
        fp.table_of([fp.Record("a", time, time, facts={"mass": 1.0}), fp.Record("b", time, time)],
                    "x", "m", nodes=5)  # fmt: skip
    one = fp.Record("one", time, time, inputs={"pull": time})
    with pytest.raises(fp.FlatplankError, match="no input 'pul'.*there: pull"):
        fp.table_of([one], "x", "m", nodes=5, inputs={"pul": "held"})
    with pytest.raises(fp.FlatplankError, match="input pull: unknown shape 'step'.*known: line, "):
        fp.table_of([one], "x", "m", nodes=5, inputs={"pull": "step"})
    with pytest.raises(fp.FlatplankError, match="record back: time does not rise"):
        fp.table_of([fp.Record("back", time[::-1], time)], "x", "m", nodes=5)
