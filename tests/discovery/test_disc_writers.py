# SPDX-License-Identifier: Apache-2.0
"""Several programs change one model file: a step that was told as written is in the file."""

from __future__ import annotations

import signal
import subprocess
import sys

import pytest

from flatplank_analysis.discovery.modelfile import ModelFile, load_model, save_model
from flatplank_data.errors import UnwritableError
from flatplank_data.files import only_writer

WRITER = """
import sys
from flatplank_analysis.discovery.modelfile import load_model, save_unchanged
from flatplank_data.errors import FlatplankError

path, name = sys.argv[1:]
print("ready", flush=True)
sys.stdin.readline()
written = []
for i in range(25):
    step = f"{name}_{i}"
    try:
        save_unchanged(load_model(path).with_step("add", step, {}), path)
    except FlatplankError as refused:
        assert "was changed meanwhile, nothing is written; repeat the step" in str(refused)
    else:
        written.append(step)
print(" ".join(written), flush=True)
"""


def test_no_step_that_was_told_as_written_is_lost(tmp_path):
    path = tmp_path / "model.yaml"
    save_model(ModelFile().with_step("start", "", {}), path)
    writers = [
        subprocess.Popen(
            [sys.executable, "-c", WRITER, str(path), f"w{i}"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )
        for i in range(6)
    ]  # fmt: skip
    for writer in writers:
        assert writer.stdout is not None and writer.stdout.readline() == "ready\n"
    for writer in writers:
        assert writer.stdin is not None
        writer.stdin.write("\n")
        writer.stdin.flush()
    told = [step for w in writers for step in w.communicate(timeout=120)[0].split()]
    assert all(writer.returncode == 0 for writer in writers)
    kept = [line["effect"] for line in load_model(path).history[1:]]
    assert len(told) >= 25 and sorted(kept) == sorted(told)


def test_a_lock_ends_with_its_program(tmp_path):
    killed = (
        "import os, signal, sys; from flatplank_data.files import only_writer\n"
        "with only_writer(sys.argv[1]): os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    program = [sys.executable, "-c", killed, str(tmp_path / "m")]
    assert subprocess.run(program).returncode == -signal.SIGKILL
    with only_writer(tmp_path / "m"):
        pass


def test_a_lock_that_cannot_be_made_is_one_line(tmp_path):
    with (
        pytest.raises(UnwritableError, match="cannot be written"),
        only_writer(tmp_path / "x" / "m"),
    ):
        pass
