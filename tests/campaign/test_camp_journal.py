# SPDX-License-Identifier: Apache-2.0
"""Journals of campaigns and investigations: a torn tail is repaired by whoever writes next."""

from __future__ import annotations

import errno
import json
import resource
import subprocess
import sys
from pathlib import Path

import pytest

from flatplank_control.investigate.opening import FORMAT, NAME, DiskLog
from flatplank_control.runner.campaign.journal import Journal, write_line, write_note
from flatplank_data.journals import read_lines

WHOLE = [{"event": "plan", "name": "p", "digest": "d"}, {"event": "skip", "run": "a", "why": "b"}]
TAILS = [b'{"event": "end", "ru', b"\x00" * 40, '{"event": "note", "text": "\u00e4'.encode()[:-1]]


@pytest.fixture
def path(tmp_path: Path) -> Path:
    made = tmp_path / "p.journal.jsonl"
    made.write_bytes(b"".join(json.dumps(line).encode() + b"\n" for line in WHOLE))
    return made


@pytest.mark.parametrize("tail", TAILS)
def test_a_note_after_a_crash_is_not_lost_with_the_torn_line(path: Path, tail: bytes) -> None:
    path.write_bytes(path.read_bytes() + tail)
    assert read_lines(path) == WHOLE
    write_note(path, "the oil was changed")
    assert read_lines(path) == [*WHOLE, {"event": "note", "text": "the oil was changed"}]


@pytest.mark.parametrize("tail", TAILS)
def test_journal_and_log_go_on_after_a_torn_line(path: Path, tail: bytes, tmp_path: Path) -> None:
    path.write_bytes(path.read_bytes() + tail)
    Journal(path, "p", "d").begin("b", 1)
    assert read_lines(path)[2:] == [{"event": "begin", "run": "b", "attempt": 1}]
    first = {"format": FORMAT, "event": "begin"}
    (tmp_path / NAME).write_bytes(json.dumps(first).encode() + b"\n" + tail)
    DiskLog(tmp_path).write({"event": "batch"})
    assert DiskLog(tmp_path).events == [first, {"event": "batch"}]


def test_a_damaged_line_in_the_midst_is_told(path: Path) -> None:
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(lines[0] + b"\x00\x01\n" + lines[1])
    with pytest.raises(ValueError, match=r"p\.journal\.jsonl: line 2 is damaged; restore"):
        Journal(path, "p", "d")


def test_a_line_that_does_not_fit_on_the_disk_is_taken_back(path: Path) -> None:
    before = path.read_bytes()
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (len(before) + 10, limits[1]))
    try:
        with pytest.raises(OSError) as refused:
            write_line(path, {"event": "note", "text": "longer than ten bytes"})
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert refused.value.errno in (errno.ENOSPC, errno.EFBIG) and path.read_bytes() == before


WRITER = """
import sys
from pathlib import Path
from flatplank_control.runner.campaign.journal import write_line
for i in range(30):
    write_line(Path(sys.argv[1]), {"event": "note", "text": f"{sys.argv[2]} {i} " + "x" * 5000})
"""


def test_lines_of_several_programs_do_not_mix(path: Path) -> None:
    writers = [
        subprocess.Popen([sys.executable, "-c", WRITER, str(path), name]) for name in "abcd"
    ]
    assert [writer.wait(120) for writer in writers] == [0] * 4
    told = [line["text"].split()[:2] for line in read_lines(path)[2:]]
    assert sorted(told) == sorted([n, str(i)] for n in "abcd" for i in range(30))
