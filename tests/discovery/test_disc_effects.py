# SPDX-License-Identifier: Apache-2.0
"""Every registered effect keeps the contract; so does, or does not, a file of the user."""

from __future__ import annotations

import re
import sys
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np
import pytest
from bristles import Truth, campaign

from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.model import ParameterSet
from flatplank_analysis.discovery.modelfile import ModelFile
from flatplank_analysis.effects import consent, registry
from flatplank_analysis.effects.checks import check_effect, probe_model
from flatplank_analysis.effects.registry import GROUP, find, library, load_file
from flatplank_data.errors import FlatplankError
from flatplank_data.table import MeasurementTable

OWN = '''
"""Rail friction: the plank guide takes a part of the force, whatever the slip."""
from dataclasses import dataclass
import numpy as np
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Signal, TireEffect

@dataclass(frozen=True)
class RailFriction(TireEffect):
    identifier = "rail_friction"
    title = "Friction of the plank guide"
    kind = "machine"
    coordinate = "slip level"
    source = "own thought"
    what = "The guide rubs."
    check = "Pull the plank."
    removes = "Grease."
    force: float = param(0.0, unit="N", bounds=(-100.0, 100.0), screen=10.0, matters=5.0)

    def signal(self, signal: Signal) -> None:
        signal.fx = signal.fx + self.force * np.tanh(signal.true_fx / 50.0)
'''


@pytest.mark.parametrize("name", list(library()))
def test_contract(name):
    assert check_effect(library()[name]) == []


def test_identifiers_and_texts_are_there():
    known = library()
    for name in ("road_play", "drive_backlash", "rack_backlash", "mesh_ripple", "worn_patch"):
        assert name in known
    assert {e.kind for e in known.values()} == {"machine", "sensor", "tire"}


def test_unknown_effect_names_the_nearest():
    with pytest.raises(FlatplankError, match="road_play"):
        find("roadplay")


def _own(tmp_path, text=OWN, name="mine.py"):
    path = tmp_path / name
    path.write_text(text)
    consent.give([path])
    return path


def test_own_effect_is_loaded_and_keeps_the_contract(tmp_path):
    (effect,) = load_file(_own(tmp_path))
    assert check_effect(effect) == []
    assert library([tmp_path / "mine.py"])["rail_friction"].identifier == "rail_friction"


@pytest.fixture
def from_contributing(tmp_path):
    """The file that CONTRIBUTING shows, and its lines for setup.py."""
    text = (Path(__file__).resolve().parents[2] / "CONTRIBUTING.md").read_text(encoding="utf-8")
    code, lines = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    return _own(tmp_path, code, "cable_drag.py"), lines


def test_example_of_contributing_finds_its_force(from_contributing):
    """20 to 25 lines that pass the contract and find a force which the library does not hold."""
    file, _ = from_contributing
    assert len([line for line in file.read_text().splitlines() if line.strip()]) <= 25
    (effect,) = load_file(file)
    assert check_effect(effect) == []
    tables = []
    for table in campaign(Truth(seed=43, slips=(-0.05, -0.01, 0.01, 0.05), repeats=2)):
        place = np.clip((table.columns["plank_position"] - 2.5) / 0.7, -0.5, 0.5)
        force = 80.0 * np.cos(np.pi * place) * (table.info.kappa < 0.0)
        columns = dict(table.columns) | {"fx": table.columns["fx"] + force}
        tables.append(MeasurementTable(columns, table.info))
    session = Session.of_tables(tables, library([file]), (str(file),))
    _, _, numbers = session.add(ModelFile(), "cable_drag")
    assert numbers["size"] == pytest.approx(80.0, rel=0.15)
    assert numbers["rmse_before"] > 1.3 * numbers["rmse"]
    assert numbers["unexplained"] < 0.3 * numbers["floor"]


def test_entry_point_of_contributing(from_contributing, monkeypatch):
    file, lines = from_contributing
    ((name, value),) = re.findall(r'"flatplank.effects": \["(\w+) = (\w+)"\]', lines)
    monkeypatch.syspath_prepend(file.parent)
    point = EntryPoint(name, value, GROUP)
    monkeypatch.setattr(registry, "entry_points", lambda group: [point] * (group == GROUP))
    registry._shipped.cache_clear()
    try:
        assert library()["cable_drag"].__module__ == "cable_drag"
    finally:
        registry._shipped.cache_clear()
        sys.modules.pop("cable_drag", None)


def test_own_effect_that_acts_at_its_null_is_refused(tmp_path):
    text = OWN.replace("self.force *", "(1.0 + self.force) *")
    (effect,) = load_file(_own(tmp_path, text, "shifted.py"))
    assert "null" in check_effect(effect)[0]


def test_own_effect_that_mixes_lanes_is_refused(tmp_path):
    text = OWN.replace("self.force *", "np.cumsum(self.force, axis=0) *")
    (effect,) = load_file(_own(tmp_path, text, "mixed.py"))
    assert "parameter sets" in check_effect(effect)[0]


def test_own_effect_with_nan_wrong_shape_or_error_is_told_in_one_line(tmp_path):
    base = "signal.fx + self.force * np.tanh(signal.true_fx / 50.0)"
    cases = {
        "signal.fx + np.sqrt(-np.abs(self.force)) * 1.0": "NaN",
        "signal.fx[:, :, 1:]": "shape",
        "signal.fx + self.missing": "AttributeError",
    }
    for i, (new, expected) in enumerate(cases.items()):
        text = OWN.replace(base, new)
        (effect,) = load_file(_own(tmp_path, text, f"bad{i}.py"))
        with np.errstate(invalid="ignore"):
            faults = check_effect(effect)
        assert faults and expected in faults[0], (new, faults)
        assert "\n" not in faults[0]


def test_broken_file_and_empty_file(tmp_path):
    with pytest.raises(FlatplankError, match="SyntaxError"):
        load_file(_own(tmp_path, "def (", "broken.py"))
    with pytest.raises(FlatplankError, match="holds no effect"):
        load_file(_own(tmp_path, "x = 1", "empty.py"))
    with pytest.raises(FlatplankError, match="no such file"):
        load_file(tmp_path / "nowhere.py")


def test_files_of_one_name_are_told_apart(tmp_path):
    files = {}
    for identifier in ("rail_friction", "seal_friction"):
        folder = tmp_path / identifier
        folder.mkdir()
        text = OWN.replace("rail_friction", identifier)
        files[identifier] = _own(folder, text, "mine.py")
    known = library(files.values())
    found = {name: known[name].file for name in files}
    assert found == {name: str(file) for name, file in files.items()}


def test_node_hook_gives_the_same_as_the_compiled_loop(tmp_path):
    """An effect that computes droop node by node equals the one that the kernel knows."""
    text = (
        OWN.replace("import Signal", "import Node")
        .replace(
            "def signal(self, signal: Signal) -> None:\n"
            "        signal.fx = signal.fx + self.force * np.tanh(signal.true_fx / 50.0)",
            "def node(self, node: Node) -> None:\n"
            "        node.slip = node.slip - 1e-8 * self.force * node.force_x * node.travel",
        )
        .replace("rail_friction", "droop_again")
    )
    (effect,) = load_file(_own(tmp_path, text, "node.py"))
    assert check_effect(effect) == []
    model = probe_model()
    base = np.array([p.null for p in model.parameters])
    droop = library()["speed_droop"]
    a = model.predict([ParameterSet(base, ((effect, np.array([40.0])),))])
    b = model.predict([ParameterSet(base, ((droop, np.array([4e-7])),))])
    np.testing.assert_allclose(a, b, atol=1e-6)


def test_lost_motion_is_the_gap():
    """Closed form: after the step the slip travel falls behind by the gap, no more."""
    from flatplank_analysis.effects.base import Motion
    from flatplank_analysis.effects.gaps import lost_motion

    data = probe_model().data
    rolled = (data.radius[:, None] * data.turned)[None]
    motion = Motion(data, data.travel[None].copy(), rolled, None)
    total = np.cumsum(lost_motion(motion, np.full((1, 1, 1), 5e-4)), axis=-1)
    big = np.abs(data.kappa) > 0.05
    np.testing.assert_allclose(np.abs(total[0, big, -1]), 5e-4, rtol=1e-6)
    before = data.since_step < 0.0
    assert np.abs(total[0][before]).max() == 0.0
