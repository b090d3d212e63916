# SPDX-License-Identifier: Apache-2.0
"""Programs that are killed in the middle of their work (kill -9), and what they leave."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Sequence
from contextlib import closing, redirect_stdout, suppress
from pathlib import Path
from socket import socket

from flatplank_analysis.discovery.modelfile import load_model
from flatplank_data.campaign import Campaign
from flatplank_sim.cli.simulate import main as simulate

PLAN = """format: flatplank-plan/1
name: killed
tire: TOY
attempts: 1
common: {step_position: 0.3, end_position: 0.6}
quality: {settling: 10000, load_error: 1, load_drift: 1, force_error: 1000, plateau: 10,
          repeatability: 10000, speed_error: 1, once_per_turn: 10000}
runs:
- measurement: slip
  kappa: [0.02, -0.02, 0.05]
  start: [1]
"""
RUNS = 4
"""the three of the plan and the one that gives r_e"""
PATIENCE_S = 600.0
"""a program that takes longer hangs [s]"""


def verb(*words: str | Path) -> list[str]:
    """Command line of a verb of `flatplank`."""
    return [sys.executable, "-m", "flatplank_analysis.cli.main", *map(str, words)]


def started(words: Sequence[str], log: Path) -> subprocess.Popen:
    """A program in a group of its own; what it says goes to a file."""
    with log.open("w") as out:
        return subprocess.Popen(words, start_new_session=True, stdout=out, stderr=out)


def end(process: subprocess.Popen) -> None:
    """Kill a program and its workers."""
    with suppress(ProcessLookupError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()


def killed_after(words: Sequence[str], seconds: float, log: Path) -> int:
    """Start a program, kill it after a time; its exit code, negative when it was killed."""
    process = started(words, log)
    with suppress(subprocess.TimeoutExpired):
        process.wait(seconds)
    end(process)
    return process.returncode


def whole(words: Sequence[str], log: Path) -> tuple[str, float]:
    """Empty, or the last line of a program that did not end well; and its time [s]."""
    began, process = time.monotonic(), started(words, log)
    try:
        code = process.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        code = -1
    end(process)
    lines = log.read_text(errors="replace").splitlines() or [""]
    return ("" if code == 0 else f"exit {code}: {lines[-1]}"), time.monotonic() - began


def campaign(folder: Path) -> Path:
    """A small campaign of the twin."""
    words = [str(folder), "--slips", "2,-2", "--starts", "1,2", "--at", "0.3", "--jobs", "1"]
    with redirect_stdout(sys.stderr):  # what is printed there may be read by programs
        code = simulate(words)
    if code != 0:
        raise RuntimeError("the twin has made no campaign")
    return folder


def broken(folder: Path) -> str:
    """Empty when campaign and model of a folder can be read, every listed run with them."""
    try:
        found = Campaign.load(folder)
        tables = sum(1 for _ in found.tables())
        if (folder / "model.yaml").exists():
            load_model(folder / "model.yaml")
    except (OSError, ValueError) as error:
        return f"{type(error).__name__}: {error}"
    fatal = [str(p) for p in found.problems if p.fatal]
    return "; ".join(fatal) or ("" if tables == len(found.runs) else "runs without samples")


def contents(folder: Path) -> dict[str, bytes]:
    """Name -> content of the files of a folder."""
    return {p.name: p.read_bytes() for p in sorted(folder.iterdir()) if p.is_file()}


def free_port() -> int:
    """A port of this machine that nobody has."""
    with closing(socket()) as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


def answers(port: int, process: subprocess.Popen, token: str) -> str:
    """Empty when a page answers, or what is wrong."""
    request = urllib.request.Request(f"http://127.0.0.1:{port}/")
    request.add_header("Cookie", f"flatplank_token_{port}={token}")
    last, began = "", time.monotonic()
    while process.poll() is None and time.monotonic() - began < PATIENCE_S:
        try:
            with urllib.request.urlopen(request, timeout=60.0) as answer:
                return "" if answer.status == 200 else f"status {answer.status}"
        except (urllib.error.URLError, OSError) as error:
            last = str(error)
            time.sleep(0.2)
    return f"no page: {last or process.returncode}"
