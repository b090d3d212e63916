# SPDX-License-Identifier: Apache-2.0
"""The adapters of examples/ on data of their kind, simulated with other code."""

from __future__ import annotations

import ast
import importlib.util
import json
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from machines import servo, swing
from scipy.io import savemat

from flatplank_analysis.discovery.verdict import FOUND

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def _module(name: str):
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / name / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look there
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def pendulum():
    yield _module("pendulum")
    del sys.modules["pendulum"]


@pytest.fixture(scope="module")
def bench():
    yield _module("servo")
    del sys.modules["servo"]


def named(result) -> list[str]:
    return [f.decision.term.effect.identifier for f in result.found]


def holds(result, effect: str, size: float) -> bool:
    (found,) = [f for f in result.found if f.decision.term.effect.identifier == effect]
    low, high = found.decision.interval
    return low <= size <= high


@pytest.mark.parametrize(
    ("truth", "effect", "size"),
    [
        ({"mu": 0.5, "viscous": 0.1}, "coulomb", 0.5),
        ({"viscous": 0.1, "air": 0.3}, "air_drag", 0.3),
    ],
)
def test_what_slows_a_pendulum_is_named_and_nothing_else(pendulum, tmp_path, truth, effect, size):
    result = pendulum.main([str(swing(tmp_path / "swing.csv", **truth))]).result
    assert named(result) == [effect] and holds(result, effect, size)
    assert result.rmse_after < 0.1 * result.rmse_before
    assert result.held_out_after < 1.1 * result.rmse_after
    # no swing comes twice: the floor is a lower bound, and says so
    assert result.source.identifier == "resolution" and not result.verdict.startswith(FOUND)


def test_viscous_friction_alone_needs_nothing(pendulum, tmp_path, capsys):
    path = swing(tmp_path / "swing.csv", viscous=0.4)
    result = pendulum.main([str(path)]).result
    assert named(result) == [] and result.verdict == "at floor"
    assert "resolution of what was recorded (lower bound)" in capsys.readouterr().out
    time, angle = np.loadtxt(path, delimiter=",", skiprows=1).T
    savemat(tmp_path / "swing.mat", {"time": time, "theta": angle + np.pi})
    again = pendulum.main([str(tmp_path / "swing.mat")]).result
    assert again.rmse_before == pytest.approx(result.rmse_before, rel=1e-3)


@pytest.mark.long
def test_friction_by_load_of_a_servo_is_named_and_neither_decoy(bench, tmp_path):
    result = bench.main(str(servo(tmp_path / "logs", load=0.15))).result
    assert named(result) == ["load_friction"] and holds(result, "load_friction", 0.15)
    assert result.rmse_after < 0.2 * result.rmse_before
    assert result.held_out_after < 1.2 * result.rmse_after
    assert result.source.lower_bound and not result.verdict.startswith(FOUND)


@pytest.mark.long
def test_a_servo_with_a_stribeck_curve_is_not_said_to_feel_its_load(bench, tmp_path):
    result = bench.main(str(servo(tmp_path / "logs", stribeck=0.15))).result
    assert "load_friction" not in named(result)


def test_logs_may_lack_what_only_some_recorders_write(bench, tmp_path):
    folder = servo(tmp_path / "logs")
    path = sorted(folder.glob("*.json"))[0]
    log = json.loads(path.read_text())
    log["arm-mass"] = log.pop("arm_mass")
    del log["trajectory"]
    path.write_text(json.dumps(log))
    record = bench.read(path)
    assert record.facts.keys() == bench.read(sorted(folder.glob("*.json"))[1]).facts.keys()
    assert record.facts["weight"] > 0.4 * 9.8 * 0.1


@pytest.mark.parametrize("name", ["pendulum", "servo"])
def test_without_data_an_example_says_what_it_wants(name):
    script = EXAMPLES / name / f"{name}.py"
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=100)
    assert done.returncode == 1 and f"python examples/{name}/{name}.py" in done.stderr


@pytest.mark.parametrize(
    ("name", "given", "line"),
    [
        ("pendulum", "swing.csv", "no column theta or Theta1 or angle or position"),
        ("pendulum", "no.csv", "no such file"),
        ("servo", "logs", "the data have no 'mass'"),
        ("servo", "nothing", "no records"),
    ],
)
def test_bad_data_are_one_line(name, given, line, tmp_path, monkeypatch):
    (tmp_path / "swing.csv").write_text("time,x\n0,1\n1,2\n")
    (tmp_path / "logs").mkdir()
    (tmp_path / "logs" / "a.json").write_text('{"entries": [{"position": 1.0}]}')
    monkeypatch.setattr(sys, "argv", [name, str(tmp_path / given)])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(EXAMPLES / name / f"{name}.py"), run_name="__main__")
    assert line in str(ended.value.code) and "\n" not in str(ended.value.code)


def test_an_adapter_is_short():
    """What is general is in the package: classes, reader and call of every example."""
    for path in EXAMPLES.glob("*/*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        lines = set()
        for node in ast.walk(tree):
            if isinstance(node, ast.stmt) and not _is_text(node):
                lines |= {node.lineno, *range(node.lineno, _end(node) + 1)}
        assert len(lines) <= 66, (path.name, len(lines))


def _is_text(node: ast.stmt) -> bool:
    return isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)


def _end(node: ast.stmt) -> int:
    return node.body[0].lineno - 1 if hasattr(node, "body") else node.end_lineno
