# SPDX-License-Identifier: Apache-2.0
"""Completes a run record from the bench: constants, calibrations, changed parameters, machine and
software."""

from __future__ import annotations

import datetime
import subprocess
from collections.abc import Mapping
from functools import lru_cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from flatplank_control.calibration.book import CALIBRATED, CalibrationBook
from flatplank_control.free_rolling import FreeRollingParameters
from flatplank_control.runner.conditions import SET_UP
from flatplank_control.sequencer import SequencerParameters
from flatplank_data.params import parameter_infos
from flatplank_data.run_record import RunRecord
from flatplank_hw.drive import DriveParameters
from flatplank_hw.encoders import EncoderParameters
from flatplank_hw.hub import HubParameters

InForce = Mapping[str, Mapping[str, Any]]
"""node -> parameter -> present value, for running nodes"""
MEASURING: dict[str, type] = {
    "measurement_hub": HubParameters,
    "encoders": EncoderParameters,
    "wheel_drive": DriveParameters,
    "free_rolling_controller": FreeRollingParameters,
    "slip_sequencer": SequencerParameters,
}
"""node -> class of the parameters that affect a measurement"""
MACHINE = ("tire", "preset", "config", "seed")
"""parameters of a node that simulates the machine, for the run record"""
SIMULATED = dict.fromkeys(("simulated_plant", "ethercat_bus"), MACHINE)
"""nodes that may simulate the machine; a real bus has none of these parameters"""
ASKED = {
    node: tuple(p.name for p in parameter_infos(kind)) for node, kind in MEASURING.items()
} | SIMULATED
"""node -> parameters that go into a run record"""
GIT_TIMEOUT_S = 5.0
"""time-out of git [s]"""


def complete_record(
    record: RunRecord, in_force: InForce, book: CalibrationBook, today: datetime.date
) -> RunRecord:
    """The record, completed from the parameters of the nodes and the calibration book.

    Raises ValueError when a file that the book names is missing.
    """
    of_the_set_up = {
        key: in_force[node][key]
        for node, keys in SET_UP.items()
        if node in in_force
        for key in keys
    }
    own = {
        node: changed_parameters(node, in_force[node]) for node in MEASURING if node in in_force
    }
    return record.with_changes(
        **of_the_set_up,
        calibration=book.record(today, in_force),
        parameters={**record.parameters, **{node: found for node, found in own.items() if found}},
        plant=simulated_by(in_force),
        software_version=software_version(),
    )


def changed_parameters(node: str, values: Mapping[str, Any]) -> dict[str, Any]:
    """Parameters that differ from their defaults, except those stored elsewhere in the record."""
    elsewhere = {*SET_UP.get(node, ()), *CALIBRATED.get(node, ())}
    found = {}
    for p in parameter_infos(MEASURING[node]):
        value = values[p.name]
        same = (tuple(value) if isinstance(p.default, tuple) else value) == p.default
        if not same and p.name not in elsewhere:
            found[p.name] = value
    return found


def simulated_by(in_force: InForce) -> dict[str, Any] | None:
    """The simulated machine; None for a real one."""
    for node in SIMULATED:
        values = in_force.get(node, {})
        if values:
            return {key: values[key] for key in MACHINE}
    return None


def utc_now() -> str:
    """Present time as a run record has it."""
    return datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")


@lru_cache(maxsize=1)
def software_version() -> str:
    """Version of this package, with the commit when it runs from its repository."""
    here = Path(__file__).resolve()
    number = version("flatplank_control")
    if _git(here, "ls-files", "--error-unmatch", here.name) is None:
        return number  # installed package: a repository around it is not ours
    commit = _git(here, "describe", "--always", "--dirty=, changed", "--exclude=*")
    return f"{number} ({commit})" if commit else number


def _git(file: Path, *words: str) -> str | None:
    """Output of git in the folder of a file; None without git or repository."""
    try:
        done = subprocess.run(
            ["git", *words], cwd=file.parent, capture_output=True, text=True, timeout=GIT_TIMEOUT_S
        )
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() if done.returncode == 0 else None
