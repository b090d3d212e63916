# SPDX-License-Identifier: Apache-2.0
"""`./flatplank doctor` and the dispatch of verbs, as a user calls them."""

from __future__ import annotations

import json
import os
import resource
import subprocess
from pathlib import Path

from flatplank_control.cli import doctor

ROOT = Path(__file__).resolve().parents[2]


def flatplank(*arguments: str, cwd: Path = ROOT, **variables: str) -> subprocess.CompletedProcess:
    command = [str(ROOT / "flatplank"), *arguments]
    env = os.environ | variables
    return subprocess.run(command, capture_output=True, text=True, cwd=cwd, env=env)


def test_doctor_finds_what_the_tests_run_on() -> None:
    done = flatplank("doctor", "--json")
    findings = json.loads(done.stdout)
    assert done.returncode == 0
    assert all(item["there"] for item in findings.values() if item["needed"])


def test_doctor_tells_what_is_missing(monkeypatch, capsys, tmp_path) -> None:
    absent = doctor.Finding(False, "no such thing", "get one")
    monkeypatch.setitem(doctor.NEEDED, "rclpy", lambda: absent)
    assert doctor.main([]) == 1
    assert "MISSING  rclpy       no such thing -> get one" in capsys.readouterr().out


def test_a_second_start_costs_less_than_a_second() -> None:
    flatplank("help")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    assert flatplank("help").returncode == 0
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    # processor time: it does not depend on what else runs
    assert after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime < 1.0


def test_unknown_verb_is_one_line_and_names_the_nearest() -> None:
    done = flatplank("docto")
    assert done.returncode == 2
    assert done.stderr == "flatplank: no verb 'docto': did you mean doctor?\n"


def test_the_callers_folder_shadows_nothing(tmp_path: Path) -> None:
    (tmp_path / "numpy.py").write_text("raise SystemExit('shadowed')\n")
    assert flatplank("doctor", cwd=tmp_path).returncode == 0


def test_exports_for_a_shell_keep_what_was_sourced() -> None:
    done = flatplank("env", CMAKE_PREFIX_PATH="/other/underlay")
    line = next(s for s in done.stdout.splitlines() if s.startswith("export CMAKE_PREFIX_PATH="))
    assert line.endswith(":/other/underlay")
