# SPDX-License-Identifier: Apache-2.0
"""Whatever is broken, the user of a verb sees one line and an exit code, never a traceback."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import time
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import pytest

from flatplank_analysis.cli import main as failures
from flatplank_analysis.cli.main import run_reporting_errors
from flatplank_analysis.cli.verbs import installed

HERE = Path(__file__).parent
ROOT = HERE.parents[1]

ARGUMENTS: dict[str, list[str]] = {
    "add": ["drive_backlash", "nowhere"],
    "bench": ["--sim", "--plant", "nowhere.yaml"],
    "bench-blind": ["--out", "nowhere/blind", "--nonsense"],
    "bench-discovery": ["--nonsense"],
    "bench-fits": ["--nonsense"],
    "bench-hold": ["--nonsense"],
    "bench-investigate": ["--nonsense"],
    "bench-oracle": ["nowhere.jsonl"],
    "bench-propose": ["--nonsense"],
    "bench-speed": ["nonsense"],
    "bench-start": ["--nonsense"],
    "bench-sweeps": ["--count", "0"],
    "bench-trust": ["--nonsense"],
    "bench-unchanged": ["nonsense"],
    "bench-scale": ["--nonsense"],
    "calibrate": ["nonsense"],
    "catalogue": ["nowhere"],
    "compare": ["nowhere"],
    "demo": ["--out", "made"],
    "confirm": ["drive_backlash", "nowhere", "--with", "nowhere"],
    "diagnose": ["nowhere"],
    "doctor": [],
    "effects": ["check", "nowhere.py"],
    "esi": ["nowhere.xml"],
    "explain": ["nowhere"],
    "fit": ["nowhere"],
    "fmu": ["nowhere.tir", "made.fmu"],
    "investigate": ["made", "--minutes", "-1"],
    "panel": ["--data", "made", "--port", "1"],
    "propose": ["nowhere"],
    "publish": ["nowhere"],
    "remove": ["drive_backlash", "nowhere"],
    "repair": ["nowhere", "made"],
    "report": ["nowhere"],
    "reveal": ["nowhere"],
    "road-map": ["nowhere"],
    "run": ["nowhere.yaml"],
    "simulate": ["made", "--slips", "5"],
    "slip": ["5", "--re", "0.31"],
    "sweeps": ["nowhere.mat"],
    "table": ["nowhere"],
    "test": ["--nonsense"],
    "thesis": ["--chapter", "8"],
    "tire": ["nowhere"],
    "tune": ["--nonsense"],
    "undo": ["nowhere"],
}
"""verb -> arguments with which it soon needs ROS, a folder or the disk, or finds no input"""

REAL_WORK = {"no ros": {"demo", "slip"}, "read only": {"demo"}, "full disk": {"demo", "bench"}}
"""environment -> verbs that get as far as what is broken; these must fail"""


def in_broken(cases: list[tuple[str, list[str], str]], folder: Path) -> list[tuple]:
    command = [sys.executable, str(HERE / "broken.py"), str(folder)]
    env = os.environ | {"TMPDIR": str(folder)}
    done = subprocess.run(
        command, input=json.dumps(cases), capture_output=True, text=True, env=env
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_every_verb_is_walked() -> None:
    assert ARGUMENTS.keys() == installed().keys()


@pytest.mark.timeout(1800)  # forty verbs, one after the other
@pytest.mark.parametrize("broken", REAL_WORK)
def test_a_broken_environment_is_one_line(broken: str, tmp_path: Path) -> None:
    skipped = {"simulate", "panel", "test"} if broken == "no ros" else {"test"}
    cases = [(v, a, broken) for v, a in ARGUMENTS.items() if v not in skipped]
    for (verb, _, _), (code, said) in zip(cases, in_broken(cases, tmp_path), strict=True):
        assert "Traceback" not in said, f"{verb}: {said}"
        assert code in (0, 1, 2), f"{verb}: exit code {code}: {said}"
        if code:
            lines = said.splitlines()
            assert any(line.startswith(f"flatplank {verb}:") for line in lines), f"{verb}: {said}"
        assert "usage:" not in said and "Errno" not in said, f"{verb}: {said}"
        if verb in REAL_WORK[broken]:
            assert code == 1, f"{verb}: {said}"
            assert len(said.strip().splitlines()) == 1, f"{verb}: {said}"


PANEL = ROOT / "ros_ws/install/flatplank_panel/lib/flatplank_panel/panel"
"""what `ros2 run flatplank_panel panel` starts"""


@pytest.mark.parametrize("command", [[ROOT / "flatplank", "panel"], [PANEL]])
def test_a_taken_port_is_one_line(command: list[Path], tmp_path: Path) -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        # NiceGUI believes itself in a test of its own when it sees pytest's variable
        env = {k: v for k, v in os.environ.items() if k != "PYTEST_CURRENT_TEST"}
        done = subprocess.run(
            [*command, "--port", port, "--data", tmp_path],
            capture_output=True, text=True, timeout=280, env=env,
        )  # fmt: skip
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert port in done.stderr.strip().splitlines()[-1]


def children(pid: int) -> list[int]:
    found = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    return [int(child) for child in found]


def worker_of(pid: int) -> int | None:
    """A process of the pool that has begun to work: the imports of its work are done.

    Not before: until Python 3.12 a pool whose first process dies while it starts the next one may
    wait for ever (its `submit` and its ending of a broken pool did not lock each other out).
    """
    for child in (own for server in children(pid) for own in children(server)):
        try:
            forked = b"forkserver" in Path(f"/proc/{child}/cmdline").read_bytes()
            if forked and "scipy" in Path(f"/proc/{child}/maps").read_text():
                return child
        except OSError:  # ended meanwhile
            continue
    return None


def test_the_work_of_a_killed_child_is_done_again(tmp_path: Path) -> None:
    command = [
        sys.executable,
        "-m",
        "flatplank_analysis.cli.main",
        "simulate",
        str(tmp_path / "c"),
    ]
    process = subprocess.Popen(
        [*command, "--jobs", "2", "--slips=-2,0,2"],
        stderr=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
    )
    end = time.monotonic() + 250.0
    while (worker := worker_of(process.pid)) is None:
        assert process.poll() is None and time.monotonic() < end
        time.sleep(0.02)
    os.kill(worker, signal.SIGKILL)
    _, said = process.communicate(timeout=250)
    assert process.returncode == 0, said
    assert "Traceback" not in said
    assert len(list((tmp_path / "c").glob("*.parquet"))) == 9


def test_what_is_foreseen_is_one_line_and_says_what_to_do() -> None:
    full = OSError(28, "No space left on device", "bags/run.mcap")
    assert failures.error_line("run", full) == (
        "run: bags/run.mcap: No space left on device; free some space, or name a folder on "
        "another disk",
        1,
    )
    line, code = failures.error_line("demo", ModuleNotFoundError("No module named 'rclpy'"))
    assert (line, code) == (
        "demo: No module named 'rclpy'; ./flatplank doctor says what is missing",
        1,
    )
    assert failures.error_line("fit", BrokenProcessPool("died"))[1] == 1


def test_everything_else_is_one_line_with_the_file_of_its_trace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))

    def work() -> int:
        return {}["two\nlines"]

    assert run_reporting_errors("fit", work) == failures.UNEXPECTED == 70
    (line,) = capsys.readouterr().err.splitlines()
    (trace,) = tmp_path.iterdir()
    assert line.startswith("flatplank fit: unexpected KeyError: ")
    assert line.endswith(str(trace))
    assert 'return {}["two' in trace.read_text()


def test_without_a_place_for_the_trace_it_is_still_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", "/proc/nowhere")
    assert run_reporting_errors("fit", lambda: 1 // 0) == 70
    (line,) = capsys.readouterr().err.splitlines()
    assert line.endswith("its trace could not be written anywhere")
