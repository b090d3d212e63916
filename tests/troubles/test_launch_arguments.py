# SPDX-License-Identifier: Apache-2.0
"""What `ros2 launch` is given is checked in plain words before a node starts."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from flatplank_control.bench.launching import ARGUMENTS, check_argument_names, setup_of, why_ended

DEFAULTS = {name: argument.default for name, argument in ARGUMENTS.items()}


def asked(tmp_path: Path, **given: str):
    return setup_of({**DEFAULTS, "data": str(tmp_path), **given})


def test_the_arguments_become_the_bench(tmp_path):
    book = tmp_path / "book.yaml"
    book.touch()
    setup = asked(
        tmp_path, sim="true", seed="7", pace="lockstep", rate_hz="500", batch="4",
        axes="plank, steer", calibration=str(book), preset="thesis2023",
    )  # fmt: skip
    assert (setup.kind, setup.seed, setup.pace, setup.rate_hz, setup.batch) == (
        "sim", 7, "lockstep", 500, 4,
    )  # fmt: skip
    assert setup.axes == ("plank", "steer") and setup.calibration == str(book)
    assert asked(tmp_path, interface="eth7", bus="bench_five_axes").kind == "lab"


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({}, "interface is empty"),
        ({"sim": "1"}, "sim:=1: must be one of true, false"),
        ({"sim": "True"}, "sim:=True"),
        ({"pace": "fast"}, "pace:=fast"),
        ({"seed": "foo"}, "seed:=foo: must be a whole number"),
        ({"seed": "-1"}, "seed:=-1: must be within 0"),
        ({"rate_hz": "5"}, "rate_hz:=5: must be within 50 .. 1000"),
        ({"batch": "2.5"}, "batch:=2.5: must be a whole number"),
        ({"axes": "plank,foo"}, "unknown axis 'foo'"),
        ({"axes": "vertcal"}, "the nearest is 'vertical'"),
        ({"calibration": "nope.yaml"}, "calibration:=nope.yaml: no such file"),
        ({"tire": "tojo"}, "the nearest is 'toyo'"),
        ({"preset": "thesis"}, "the nearest is 'thesis2023'"),
        ({"sim": "false", "interface": "eth7", "bus": "nope.yaml"}, "no such bus file"),
    ],
)
def test_a_wrong_argument_is_one_line_with_what_to_do(tmp_path, given, reason):
    with pytest.raises(ValueError) as refused:
        asked(tmp_path, **({"sim": "true"} if given else {}) | given)
    assert reason in str(refused.value) and "\n" not in str(refused.value)


def test_data_that_is_a_file_is_refused(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(ValueError, match="is a file; give a folder"):
        setup_of({**DEFAULTS, "sim": "true", "data": str(tmp_path / "file")})


def test_an_argument_that_is_none_is_refused():
    with pytest.raises(ValueError, match="unknown argument 'simm'; the nearest is 'sim'"):
        check_argument_names(
            ["ros2", "launch", "flatplank_control", "bench.launch.py", "simm:=true"]
        )
    check_argument_names(
        ["ros2", "launch", "bench.launch.py", *(f"{name}:=x" for name in ARGUMENTS)]
    )


def test_the_end_of_a_node_says_which_and_how():
    assert "recorder, ended by SIGKILL" in why_ended("recorder", -signal.SIGKILL)
    assert "ethercat_bus, exit code 1" in why_ended("ethercat_bus", 1)
    assert "start the bench again" in why_ended("recorder", 1)
