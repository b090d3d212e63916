# SPDX-License-Identifier: Apache-2.0
"""The checks of an effect's contract, the made-up campaign that they use, and the library."""

from __future__ import annotations

from dataclasses import make_dataclass
from types import SimpleNamespace

import numpy as np
import pytest

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects import checks, consent, registry
from flatplank_analysis.effects.base import TireEffect
from flatplank_analysis.effects.registry import library
from flatplank_data.errors import FlatplankError

PLAIN = {
    "identifier": "plain_one", "title": "t", "kind": "machine", "coordinate": "time",
    "source": "s", "what": "w", "check": "c", "removes": "r",
}  # fmt: skip


def effect_of(size=None, hook=None, more=(), **texts):
    """An effect that keeps the contract but for this."""
    size = size or param(0.0, unit="N", bounds=(-9.0, 9.0), screen=1.0, matters=0.5)
    fields = [("force", float, size), *more]
    made = make_dataclass("Plain", fields, bases=(TireEffect,), frozen=True,
                          namespace=dict(PLAIN) | texts)  # fmt: skip

    def act(self, signal):
        signal.fx = signal.fx + self.force

    made.signal = hook or act
    return made


def number(**changes) -> object:
    return param(**dict(null=0.0, unit="N", bounds=(-9.0, 9.0), screen=1.0, matters=0.5) | changes)


def breaks_at_eight(self, signal):
    signal.fx = signal.fx + np.where(self.force > 8.0, np.nan, self.force)


@pytest.mark.parametrize(
    ("effect", "fault"),
    [
        *[({name: " "}, f"'{name}' is missing") for name in checks.TEXTS if name != "coordinate"],
        ({"kind": "magic"}, "kind 'magic' is not one of machine, sensor, tire"),
        ({"identifier": "Plain"}, "identifier: small letters"),
        ({"identifier": "pl-ain"}, "identifier: small letters"),
        ({"identifier": "wear"}, "identifier: 'wear' is an effect of the library already"),
        ({"coordinate": "nowhere"}, "coordinate 'nowhere' is not one of"),
        ({"size": number(screen=0.0)}, "no parameter has a screening step"),
        ({"size": number(unit="")}, "force: no unit"),
        ({"size": number(null=10.0)}, "force: the null 10 is outside of -9 .. 9"),
        ({"size": number(screen=9.5)}, "force: the screening step leaves the range"),
        ({"size": number(matters=0.0)}, "force: no size that matters"),
        ({"variants": classmethod(lambda cls, r, e: [])}, "variants() gave nothing"),
        ({"held": classmethod(lambda cls: ("gone",))}, "held() names 'gone'"),
        ({"size": number(), "starts": classmethod(lambda cls: ())}, "starts() gave nothing"),
        ({"scanned": classmethod(lambda cls, r: 0)}, "scanned() is below 1"),
        ({"more": [("idle", float, number())]}, "idle: nothing changes at the screening step"),
        ({"hook": breaks_at_eight}, "gives NaN or infinity at force = 9"),
        ({}, None),
    ],
)  # fmt: skip
def test_every_fault_of_the_contract_is_told(effect, fault):
    told = checks.check_effect(effect_of(**effect))
    assert (told == []) if fault is None else told and told[0].startswith(fault), told


def test_the_size_of_an_effect_must_be_a_number():
    made = effect_of()
    made.size = classmethod(lambda cls, values: np.nan)
    assert checks.check_effect(made) == ["size() is not finite at the null"]


def test_columns_that_an_effect_has_seen_go_through_their_range():
    made = effect_of(ranges={"oil": (20.0, 40.0)}, coordinate="oil")
    assert checks.check_effect(made) == []
    seen = checks.probe_of(made).data.further["oil"].values
    assert seen.shape == checks.probe_model().data.position.shape
    assert (seen[:, 0] == 20.0).all() and (seen[:, -1] == 40.0).all()
    assert checks.probe_of(effect_of()) is checks.probe_model()


def test_plug_ins_and_names_of_the_library(monkeypatch, tmp_path):
    point = SimpleNamespace(name="p", load=lambda: library()["wear"])
    assert registry._from_entry(point) == [library()["wear"]]

    def broken():
        raise ImportError("gone")

    with pytest.raises(FlatplankError, match="cannot be loaded"):
        registry._from_entry(SimpleNamespace(name="p", load=broken))
    with pytest.raises(FlatplankError, match="flatplank effects lists them"):
        registry.find("qqqqqqqqqq")
    assert registry.find("wear") is library()["wear"]
    assert library()["wear"].file == ""
    assert list(library()) == sorted(library())
    text = tmp_path / "mine.txt"
    text.write_text("x = 1")
    with pytest.raises(FlatplankError, match="is no effect file"):
        registry.load_file(text)
    own = tmp_path / "mine.py"
    own.write_text(
        "from dataclasses import dataclass\n"
        "from flatplank_analysis.discovery.parameters import param\n"
        "from flatplank_analysis.effects.base import TireEffect\n"
        "@dataclass(frozen=True)\nclass Mine(TireEffect):\n    identifier = 'wear'\n"
        "    a: float = param(0.0, unit='1', bounds=(0.0, 1.0), screen=0.1)\n"
    )
    consent.give([own])
    with pytest.raises(FlatplankError, match="is taken by flatplank_analysis.effects.road"):
        library([own])
    own.write_text(own.read_text().replace("'wear'", "'my_own'"))
    consent.give([own])
    assert library([own, tmp_path / "." / "mine.py"])["my_own"].identifier == "my_own"
    broken_file = tmp_path / "broken.py"
    broken_file.write_text("raise ValueError('no')")
    consent.give([broken_file])
    with pytest.raises(FlatplankError, match="ValueError: no"):
        checks.sound_library([broken_file])
    with pytest.raises(FlatplankError, match="'title' is missing"):
        checks.sound_library([own])
