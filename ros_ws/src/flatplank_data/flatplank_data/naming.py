# SPDX-License-Identifier: Apache-2.0
"""Names of measurements, thesis Appendix F: `TOY_REL_LNG_5perc_T_p25_Fz5550_2`."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from flatplank_data.errors import RecordingError

STEPS = ("", "step", "constant")
"""waveforms that hold one slip to the end of the run; names of the thesis imply these"""
SETTINGS = {
    "REL_LNG": ("kappa",),
    "REL_LNG_CAM": ("gamma_deg", "kappa"),
    "REL_COM": ("alpha_deg", "kappa"),
    "REL_COM_CAM": ("gamma_deg", "alpha_deg", "kappa"),
    "ERR_REL_LNG": (),
    "ERR_REL_LNG_CAM": ("gamma_deg",),
    "ERR_REL_COM": ("alpha_deg",),
    "ERR_REL_COM_CAM": ("gamma_deg", "alpha_deg"),
    "STF": (),
    "REP_REL": ("alpha_deg", "kappa"),
}
"""Kind in a name -> settings in the name, in this order. A repeat (REP_REL) in pure longitudinal
slip has no angle in its name; the camber of repeats is zero."""
FOLDERS = frozenset(("ERR", "REL_COM", "REL_COM_CAM", "REL_LNG", "REL_LNG_CAM", "REP_REL", "STF"))
"""folders of a campaign that is stored as Appendix F has it: one per type of measurement"""
_KINDS = {
    "slip": "REL",
    "free_rolling": "ERR_REL",
    "stiffness": "STF",
    "stiffness_vertical": "STF",
    "stiffness_longitudinal": "STF_LNG",
    "stiffness_lateral": "STF_LAT",
    "repeat": "REP_REL",
}
_MEASUREMENTS = {kind: name for name, kind in reversed(_KINDS.items())} | {
    "ERR": "free_rolling",
    "REP_REL": "slip",
}
"""Kind in a name -> measurement; repeats of the thesis are evaluated as the slip steps they are"""
_LETTERS = re.compile(r"(?:[A-Z]+(?:_|$))*")
_TAIL = re.compile(
    r"_T_p(?P<p>\d+(?:\.\d+)?)_Fz(?P<fz>\d+(?:\.\d+)?)_(?P<start>\d+)(?:_r(?P<repeat>\d+))?$",
    re.IGNORECASE,
)
_SETTING = re.compile(r"(-?[\d.]+)(perc|deg)")
_SAFE = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9._+-]{0,198}[A-Za-z0-9_+-])?")


def name_of(record: Mapping[str, Any]) -> str:
    """Name of the run that a complete record describes, without a repeat number."""
    kind = kind_of(record)
    words = [record["tire"] or "XXX", kind]
    for key in settings_of(kind):
        value = record[key]
        if key == "kappa":
            words.append(f"{_text(100.0 * value)}perc")
        elif value or kind != "REP_REL":
            words.append(f"{_text(value)}deg")
    pressure, load = _text(record["pressure"] * 10), _text(record["fz"])
    return check_name("_".join([*words, "T", f"p{pressure}", f"Fz{load}", str(record["start"])]))


def _text(value: float) -> str:
    """The value as text; an unknown value is 0."""
    return "0" if math.isnan(value) else f"{value + 0.0:.10g}"


def numbered(name: str, number: int) -> str:
    """Name of the run with this number; repeats get _r02, _r03, ..."""
    return f"{name}_r{number:02d}" if number > 1 else name


def kind_of(record: Mapping[str, Any]) -> str:
    """Kind in the name of a run, by its measurement, angles and waveform."""
    measurement = record["measurement"]
    kind = _KINDS.get(measurement, re.sub(r"[^A-Z]+", "_", measurement.upper()).strip("_"))
    if kind not in ("REL", "ERR_REL"):
        return kind
    kind += ("_COM" if record["alpha_deg"] else "_LNG") + ("_CAM" if record["gamma_deg"] else "")
    waveform = str((record["waveform"] or {}).get("name", ""))
    shaped = measurement == "slip" and waveform not in STEPS
    return f"{kind}_{waveform.upper()}" if shaped else kind


def _known_kind(text: str, kinds: Iterable[str] = SETTINGS) -> str:
    known = [k for k in kinds if text == k or text.startswith(f"{k}_")]
    return max(known, key=len, default="")


def _measurement(rest: str) -> str:
    """Measurement by the capital letters after the tire; a slip step without them."""
    known = _known_kind(rest, _MEASUREMENTS)
    letters = _LETTERS.match(rest)[0].strip("_").lower()  # type: ignore[index]
    return _MEASUREMENTS.get(known, letters or "slip")


def settings_of(kind: str) -> tuple[str, ...]:
    """Settings in the names of a kind; a waveform suffix (REL_LNG_SINE) does not change them."""
    return SETTINGS.get(_known_kind(kind), ())


def facts_of_name(stem: str) -> dict[str, Any]:
    """Keys of the run record that a name contains; empty when it does not have this form."""
    match = _TAIL.search(stem)
    if match is None:
        return {}
    tire, _, rest = stem[: match.start()].partition("_")
    kind = _known_kind(rest)
    facts: dict[str, Any] = {
        "tire": tire,
        "pressure": float(match["p"]) / 10.0,
        "fz": float(match["fz"]),
        "start": int(match["start"]),
        "repeat": int(match["repeat"] or 1),
        "measurement": _measurement(rest),
    }
    words = rest.removeprefix(kind).strip("_").split("_")
    shape = [w for w in words if w.isalpha()] if kind.startswith("REL") else []
    if shape:
        facts["waveform"] = {"name": "_".join(shape).lower()}
    return facts | _settings(kind, words)


def _settings(kind: str, words: list[str]) -> dict[str, float]:
    """Slip, side slip and camber from the name; with `_CAM` the first angle is the camber."""
    given = [m for w in words if (m := _SETTING.fullmatch(w))]
    slips = [float(m[1]) / 100.0 for m in given if m[2] == "perc"]
    angles = [float(m[1]) for m in given if m[2] == "deg"]
    keys = [key for key in ("gamma_deg", "alpha_deg") if key == "alpha_deg" or "_CAM" in kind]
    return dict(zip(keys, angles, strict=False)) | dict(zip(["kappa"], slips, strict=False))


def check_name(name: str) -> str:
    """The name itself when it is one plain folder name; otherwise an error."""
    if not isinstance(name, str) or not _SAFE.fullmatch(name):
        raise RecordingError(
            f"{name!r}: not a name for a measurement; use letters, digits and . _ + - "
            "(at most 200, a letter or digit first)"
        )
    return name


def free_name(folder: Path, name: str) -> str:
    """`name`, or the first of `name_r02`, `name_r03`, ... that does not exist in the folder."""
    check_name(name)
    base, _, run = name.rpartition("_r")
    first = int(run) if base and run.isdigit() else 1
    stem = base if first > 1 else name
    candidate, number = name, max(first, 1)
    while (folder / candidate).exists():
        number += 1
        candidate = numbered(stem, number)
    return check_name(candidate)
