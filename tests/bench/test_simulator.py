# SPDX-License-Identifier: Apache-2.0
"""Control finds the simulated bench where it is installed; else one line says what to do."""

from __future__ import annotations

import pytest

from flatplank_control.bench import simulator as port
from flatplank_control.bench.setup import BenchSetup
from flatplank_data.errors import FlatplankError


def test_it_has_all_that_is_asked_of_it() -> None:
    found = port.simulator()
    asked = [name for name in vars(port.Simulator) if not name.startswith("_")]
    assert len(asked) == 9
    assert all(callable(getattr(found, name)) for name in asked)


def test_without_it_one_line_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(port, "entry_points", lambda group: [])
    port.simulator.cache_clear()
    with pytest.raises(FlatplankError, match="the simulated bench is not installed"):
        BenchSetup().of(next(n for n in BenchSetup().nodes() if n.name == "wheel_drive"))
    lab = BenchSetup(kind="lab", interface="eth9")
    assert all(isinstance(lab.of(node), dict) for node in lab.nodes())
