# SPDX-License-Identifier: Apache-2.0
"""An investigation in the lab: an operator at a terminal does what he reads and presses a key."""

from __future__ import annotations

import json
import os
import pty
import signal
import subprocess
import sys

import pytest
from bench_graph import graph
from test_lab import Hands

from flatplank_control.investigate.opening import NAME

pytestmark = [pytest.mark.graph, pytest.mark.long, pytest.mark.timeout(3600)]
VERB = (
    "import sys; from flatplank_control.cli.investigate import main; sys.exit(main(sys.argv[1:]))"
)


def test_prompts_are_answered_at_a_terminal_and_ctrl_c_ends_safely(tmp_path, monkeypatch):
    folder = tmp_path / "data"
    command = [sys.executable, "-c", VERB, str(folder), "--lab", "--minutes", "60"]
    own, terminal = pty.openpty()
    said: list[str] = []
    with graph(tmp_path, monkeypatch) as bench:
        hands = Hands(bench)
        with subprocess.Popen(
            command, stdin=terminal, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        ) as process:
            try:
                for line in process.stderr:
                    said.append(line.rstrip())
                    prompt = line.rsplit("; ", 1)[0]
                    if prompt.startswith(("lift", "lower", "turn", "set the")):
                        hands.obey(prompt)
                        os.write(own, b"c")
                    if "_2perc_" in line:  # the second run: the first one is made
                        process.send_signal(signal.SIGINT)
                        break
                told, errors = process.communicate(timeout=120.0)
            finally:
                process.kill()
    os.close(own)
    os.close(terminal)
    said += errors.splitlines()
    assert process.returncode == 130, said
    assert any("keys: c confirm what was asked for" in line for line in said)
    assert any(line == "confirm what was asked for" for line in said)
    assert "the same command continues it" in said[-1]
    assert "batch 1: six runs to begin with" in told
    assert (folder / "batch_01.journal.jsonl").exists()
    assert json.loads((folder / NAME).read_text().splitlines()[-1])["event"] == "batch"
