# SPDX-License-Identifier: Apache-2.0
"""A part of the demo in a process of its own, printed in its turn."""

from __future__ import annotations

import os

import pytest

from flatplank_data.errors import FlatplankError
from flatplank_sim.cli.beside import Beside, Steps
from flatplank_sim.cli.step_printer import StepPrinter


def two_steps(folder: str, steps: Steps) -> list[str]:
    """A part beside others; the folder names its end."""
    steps.step("first")
    steps.count(3, 3, "runs")
    steps.step("second")
    if folder == "dies":
        os._exit(1)
    if folder == "fails":
        raise FlatplankError("no runs", folder, "measure some")
    return [f"made {folder}"]


def test_steps_beside_others_are_printed_in_their_turn(capsys):
    with Beside(two_steps, "a") as beside, StepPrinter(3) as printer:
        printer.step("meanwhile")
        printer.close(beside.print_steps(printer))
    lines = [line.strip() for line in capsys.readouterr().out.splitlines()]
    numbered = ["[1/3] meanwhile", "[2/3] first", "3/3 runs", "[3/3] second", "made a"]
    assert [line for line in lines if line in numbered] == numbered
    assert [text for text, _ in printer.took] == ["meanwhile", "first", "second"]
    assert all(seconds >= 0.0 for _, seconds in printer.took)
    assert sum(line.endswith("s  [1] meanwhile") for line in lines) == 1


@pytest.mark.parametrize(
    ("how", "told"), [("fails", "no runs"), ("dies", "its process has ended")]
)
def test_a_part_that_ends_beside_others_ends_the_whole(how, told):
    with (
        Beside(two_steps, how) as beside,
        StepPrinter(3) as printer,
        pytest.raises(FlatplankError, match=told),
    ):
        beside.print_steps(printer)
