# SPDX-License-Identifier: Apache-2.0
"""Of small faults in search, effects, models, fits and bench nine of ten are noticed by a
test."""

from __future__ import annotations

import mutate
import pytest


@pytest.mark.parametrize("area", mutate.AREAS, ids=lambda a: a.name)
def test_a_sample_is_fair_and_can_be_repeated(area):
    for tests in area.tests:
        assert (mutate.ROOT / tests).exists(), tests
    one, two = (list(mutate.sample([area], 30, seed)) for seed in (1, 1))
    assert [m.name for _, m in one] == [m.name for _, m in two]
    assert len({m.source for _, m in one}) == 30
    files = {m.file for m in mutate.all_of(area)}
    assert len({m.file for _, m in one}) == min(len(files), 30)


NAMED = {
    "Fz of -9000 N counts as unloaded": (
        "drive", "drive/safety.py", "-p.unloaded_fz < s.fz < p.unloaded_fz",
        "s.fz < p.unloaded_fz", "tests/drive/test_drive_rules.py",
    ),
    "a reference that is no number counts": (
        "drive", "drive/axis.py", "reason = self._mode.refusal(reference.value)",
        'reason = ""', "tests/drive/test_drive_gate.py",
    ),
    "a reference from before the enabling counts": (
        "drive", "drive/axis.py",
        "self._reference, self._asked_at = 0, None, self._stamp",
        "self._reference, self._asked_at = 0, self._reference, self._stamp",
        "tests/drive/test_drive_gate.py",
    ),
    "the start torque is added twice": (
        "free_rolling", "free_rolling/controller.py", "wanted = lead + p.start_torque",
        "wanted = lead + 2.0 * p.start_torque", "tests/control/test_control_free_rolling.py",
    ),
    "a page of another port of this machine is let in": (
        "panel", "access.py", 'urlsplit(origin).netloc != headers.get("host", "")',
        "urlsplit(origin).hostname != host", "tests/panel/test_panel_access.py",
    ),
}  # fmt: skip
"""what goes wrong -> area, file, code, faulty code, tests that must notice it"""


@pytest.mark.long
@pytest.mark.parametrize("name", NAMED)
def test_a_fault_that_would_be_dangerous_is_noticed(name, tmp_path):
    area, file, old, new, tests = NAMED[name]
    (chosen,) = [a for a in mutate.AREAS if a.name == area]
    copied = mutate.Copy(tmp_path, [chosen])
    assert copied.first_failure([tests], 600.0) == ""
    path = tmp_path / chosen.package / file
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))
    assert copied.first_failure([tests], 600.0) not in ("", "too slow")


@pytest.mark.long
@pytest.mark.timeout(3 * 3600)
def test_nine_of_ten_faults_are_noticed():
    count = 12 * len(mutate.AREAS)
    results = mutate.run(mutate.AREAS, count, 1, 2.5 * 3600.0)
    print(mutate.summary(results))
    assert len(results) == count
    assert mutate.share(results) >= 0.9, mutate.summary(results)
