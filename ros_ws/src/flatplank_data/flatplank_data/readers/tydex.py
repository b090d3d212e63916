# SPDX-License-Identifier: Apache-2.0
"""Reads TYDEX files as measurement tables: channel names, units and sign conventions.

The W axis system of TYDEX is ISO W. Forces in C or H axes are not transformed.
"""

from __future__ import annotations

import math

import numpy as np

from flatplank_data.errors import FlatplankError
from flatplank_data.readers.base import Loaded, Request, left_out, reader
from flatplank_data.table import COLUMN_UNITS
from flatplank_data.units import to_si
from flatplank_tire.numbers import number_of
from flatplank_tire.text import decode_text
from flatplank_tire.tydex import TydexFile, parse_tydex

#: TYDEX channel -> our column
CHANNELS = {
    "RUNTIME": "time",
    "TRAVDIST": "plank_position",
    "TRAVDISC": "plank_position",
    "LONGVEL": "plank_velocity",
    "TRAJVELW": "plank_velocity",
    "WHROTANG": "wheel_angle",
    "WHROTSPD": "wheel_velocity",
    "FX": "fx",
    "FXW": "fx",
    "FY": "fy",
    "FYW": "fy",
    "FZ": "fz",
    "FZW": "fz",
    "MX": "mx",
    "MXW": "mx",
    "MY": "my",
    "MYW": "my",
    "MZ": "mz",
    "MZW": "mz",
    "DSTGRWHC": "loaded_radius",
    "LONGSLIP": "slip_actual",
    "SLIPANGL": "side_slip_angle",
    "INCLANGL": "camber_angle",
    "INFLPRES": "pressure",
    # not in the standard; our exporter writes these so that no column is lost
    "MOTROTSP": "motor_velocity",
    "MOTTORQ": "motor_torque",
    "TRIGGER": "motion_trigger",
}

_OTHER_AXES = {f"{kind}{axis}{system}" for kind in "FM" for axis in "XYZ" for system in "CH"}

#: constant -> (key of the run record, SI unit, factor from SI to the key's unit)
CONSTANTS = {
    "LONGSLIP": ("kappa", "1", 1.0),
    "FZW": ("fz", "N", 1.0),
    "INFLPRES": ("pressure", "Pa", 1e-5),
    "SLIPANGL": ("alpha_deg", "rad", 180.0 / math.pi),
    "INCLANGL": ("gamma_deg", "rad", 180.0 / math.pi),
    "LONGVEL": ("speed", "m/s", 1.0),
    "EFFROLRA": ("effective_rolling_radius", "m", 1.0),
    "STEPPOS": ("step_position", "m", 1.0),
    "STARTPOS": ("start", "1", 1.0),
    "RUNINDEX": ("run_index", "1", 1.0),
}


@reader(".tdx", ".tydex")
def read_tydex(request: Request) -> Loaded:
    """Read one measurement."""
    with request.store.open(request.name) as stream:
        text = decode_text(stream.read(), request.name)
    file = parse_tydex(text, request.name)
    columns, remarks = _columns(file, request)
    return Loaded(columns, _facts(file, request.name), remarks)


def _columns(file: TydexFile, request: Request) -> tuple[dict[str, np.ndarray], list[str]]:
    columns: dict[str, np.ndarray] = {}
    remarks = []
    foreign = dict((request.mapping or {}).get("columns") or {})
    for index, channel in enumerate(file.channels):
        ours = str(foreign.get(channel.name) or CHANNELS.get(channel.name, ""))
        if ours not in COLUMN_UNITS:
            hint = " (C and H axes are not turned to W)" if channel.name in _OTHER_AXES else ""
            remarks.append(f"channel '{channel.name}' is not known and was left out{hint}")
            continue
        if ours in columns:
            raise FlatplankError(
                f"two channels give '{ours}'", f"{request.name}, {channel.name}", "remove one"
            )
        if request.wants(ours):
            cells = file.not_numbers.get(channel.name)
            if cells:
                remarks.append(left_out(request, channel.name, ours, cells))
            where = f"{request.name}, channel {channel.name}"
            columns[ours] = to_si(file.data[:, index], channel.unit, COLUMN_UNITS[ours], where)
    return columns, remarks


def _facts(file: TydexFile, name: str) -> dict[str, float | int | str]:
    facts: dict[str, float | int | str] = {}
    for key, (ours, si, factor) in CONSTANTS.items():
        quantity = file.constants.get(key)
        if quantity is None or not quantity.value:
            continue
        where = f"{name}, constant {key}"
        value = number_of(quantity.value)
        if value is None:
            raise FlatplankError(f"'{quantity.value}' is not a number", where, "write one number")
        converted = float(to_si(np.array([value]), quantity.unit or si, si, where)[0]) * factor
        facts[ours] = round(converted) if ours in ("start", "run_index") else converted
    for key, ours in (("DATE", "date"), ("SUPPLIER", "operator")):
        if file.header.get(key):
            facts[ours] = file.header[key]
    return facts
