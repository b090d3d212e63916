# SPDX-License-Identifier: Apache-2.0
"""MATLAB files are parsed in a process of their own, which may die."""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import textwrap
import zlib

import numpy as np
import pytest

from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.guard import DamagedError
from flatplank_data.native import child, parent
from flatplank_data.readers.mat import variables
from flatplank_validation.trust.rows.table_files import RUN, mat


@pytest.mark.parametrize("packed", [False, True])
def test_values_come_as_scipy_reads_them(packed):
    found = variables(mat(packed, **RUN), "run.mat")
    for name in ("time", "fx", "fz", "grid", "flag"):
        np.testing.assert_array_equal(found[name], RUN[name])
    assert found["units"] == RUN["units"] and found["deep"] == RUN["deep"]
    assert (found["kappa"], found["tire"], found["names"]) == (0.05, "TOY", ["a", "bcd"])


def test_one_process_serves_many_files_and_a_crash_starts_another(monkeypatch):
    data = mat(x=np.arange(3.0))
    parent.stop()
    first = parent.parse("matlab", data), parent._PARSER._process.pid
    assert parent.parse("matlab", data) and parent._PARSER._process.pid == first[1]
    parent._PARSER._process.kill()
    with pytest.raises(DamagedError, match="its parser ended with SIGKILL"):
        parent.parse("matlab", data)
    np.testing.assert_array_equal(parent.parse("matlab", data)["x"], np.arange(3.0))
    assert parent._PARSER._process.pid != first[1]


def test_a_fork_of_the_program_has_a_process_of_its_own():
    ours = parent.parse("matlab", mat(x=1.0)), parent._PARSER._process.pid
    read, write = os.pipe()
    forked = os.fork()
    if not forked:  # no assertion in here: pytest would go on in the fork
        value = parent.parse("matlab", mat(x=2.0))["x"]
        os.write(write, f"{value} {parent._PARSER._process.pid != ours[1]}".encode())
        parent.stop()
        os._exit(0)
    os.waitpid(forked, 0)
    assert os.read(read, 100) == b"2.0 True"
    assert parent.parse("matlab", mat(x=3.0))["x"] == 3.0
    assert parent._PARSER._process.pid == ours[1]


def test_a_file_that_kills_the_parser_is_refused_in_one_line(tmp_path, monkeypatch):
    """Crashes of scipy differ from version to version: here one that is sure."""
    program = textwrap.dedent("""
        import os, sys
        from flatplank_data.native import child
        child.PARSERS = {"matlab": lambda data: os.abort()}
        child.serve(sys.stdin.buffer, os.fdopen(os.dup(1), "wb"))
    """)
    started = subprocess.Popen
    monkeypatch.setattr(
        parent.subprocess, "Popen",
        lambda command, **more: started([sys.executable, "-c", program], **more),
    )  # fmt: skip
    parent.stop()
    (tmp_path / "TOY_REL_LNG_5perc_T_p25_Fz3700_1.mat").write_bytes(mat(**RUN))
    with pytest.raises(FlatplankError, match="not a whole MATLAB file .*SIGABRT") as caught:
        Campaign.load(tmp_path).runs[0].table()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("limit", "parser", "told"),
    [
        ("MEMORY", "lambda data: bytearray(1 << 40)", "MemoryError"),
        ("SECONDS", "endless", "SIGXCPU"),
    ],
)
def test_memory_and_time_of_the_parser_are_bounded(monkeypatch, limit, parser, told):
    program = textwrap.dedent(f"""
        import os, sys
        from flatplank_data.native import child
        def endless(data):
            while True:
                pass
        child.{limit} = {getattr(child, limit) if limit == "MEMORY" else 0}
        child.PARSERS = {{"matlab": {parser}}}
        child.serve(sys.stdin.buffer, os.fdopen(os.dup(1), "wb"))
    """)
    started = subprocess.Popen
    monkeypatch.setattr(
        parent.subprocess, "Popen",
        lambda command, **more: started([sys.executable, "-c", program], **more),
    )  # fmt: skip
    parent.stop()
    with pytest.raises(DamagedError, match=told):
        parent.parse("matlab", b"")
    parent.stop()


def test_a_bomb_is_refused():
    """A packed element that says 4 GB of zeros, of which 100 MB are there."""
    packer = zlib.compressobj(9)
    head = struct.pack("<IIIIIIIIII", 14, 2**32 - 8, 6, 8, 6, 0, 5, 8, 1, 2**29)
    body = packer.compress(head) + b"".join(packer.compress(bytes(1 << 24)) for _ in range(6))
    body += packer.flush()
    data = mat(x=1.0)[:128] + struct.pack("<II", 15, len(body)) + body
    with pytest.raises(FlatplankError, match="not a whole MATLAB file"):
        variables(data, "bomb.mat")
