# SPDX-License-Identifier: Apache-2.0
"""Names of measurements, thesis Appendix F: `TOY_REL_LNG_5perc_T_p25_Fz5550_2`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

from flatplank_data.errors import RecordingError

_SAFE = re.compile(r"[A-Za-z0-9](?:[A-Za-z0-9._+-]{0,198}[A-Za-z0-9_+-])?")
_NUMBER = r"-?\d+(?:\.\d+)?"

SETTINGS = {
    "REL_LNG": ("kappa_percent",),
    "REL_LNG_CAM": ("gamma_deg", "kappa_percent"),
    "REL_COM": ("alpha_deg", "kappa_percent"),
    "REL_COM_CAM": ("gamma_deg", "alpha_deg", "kappa_percent"),
    "ERR_REL_LNG": (),
    "ERR_REL_LNG_CAM": ("gamma_deg",),
    "ERR_REL_COM": ("alpha_deg",),
    "ERR_REL_COM_CAM": ("gamma_deg", "alpha_deg"),
    "STF": (),
    "REP_REL": ("alpha_deg", "kappa_percent"),
}
"""Kind of measurement -> what its name says, in this order. A repeat in pure longitudinal slip
leaves the angle out; the thesis calls the angle of the others A, but their camber is zero."""

_UNITS = {"kappa_percent": "perc", "alpha_deg": "deg", "gamma_deg": "deg"}
_PATTERN = re.compile(
    r"(?P<tire>[A-Za-z0-9-]+)_(?P<kind>[A-Z]+(?:_[A-Z]+)*?)"
    rf"(?P<settings>(?:_{_NUMBER}(?:deg|perc))*)"
    rf"_T_p(?P<pressure>{_NUMBER})_Fz(?P<fz>{_NUMBER})_(?P<start>\d)(?:_r(?P<run>\d{{2,}}))?"
)


STEPS = ("", "step", "constant")
"""waveforms that the thesis's names stand for"""


def settings_of(kind: str) -> tuple[str, ...]:
    """What the name of a kind says; a waveform at its end (REL_LNG_SINE) changes nothing."""
    known = [k for k in SETTINGS if kind == k or kind.startswith(f"{k}_")]
    return SETTINGS[max(known, key=len)] if known else ()


@dataclass(frozen=True)
class MeasurementName:
    """What a name says; kinds that Appendix F does not know carry no settings."""

    tire: str
    kind: str
    pressure: float
    """[bar]"""
    fz: float
    """[N]"""
    start: int
    """1, 2, 3: wheel at 0, 120, 240 deg"""
    kappa_percent: float = 0.0
    alpha_deg: float = 0.0
    gamma_deg: float = 0.0
    run: int = 1
    """further runs of one name are 2, 3, ..."""

    def __str__(self) -> str:
        settings = [
            f"{_text(getattr(self, key))}{_UNITS[key]}"
            for key in settings_of(self.kind)
            if not (self.kind == "REP_REL" and key == "alpha_deg" and self.alpha_deg == 0.0)
        ]
        condition = ["T", f"p{_text(self.pressure * 10)}", f"Fz{_text(self.fz)}", str(self.start)]
        suffix = [f"r{self.run:02d}"] if self.run > 1 else []
        return check_name("_".join([self.tire, self.kind, *settings, *condition, *suffix]))


def _text(value: float) -> str:
    return f"{value + 0.0:.10g}"


def parse_name(name: str) -> MeasurementName:
    """The inverse of `str(MeasurementName)`."""
    match = _PATTERN.fullmatch(name)
    if match is None:
        raise RecordingError(
            f"{name!r}: not a name of Appendix F, such as TOY_REL_LNG_5perc_T_p25_Fz5550_2"
        )
    kind = match["kind"]
    keys = settings_of(kind)
    numbers = re.findall(rf"({_NUMBER})(deg|perc)", match["settings"])
    if kind == "REP_REL" and len(numbers) == 1:
        keys = ("kappa_percent",)
    if [unit for _, unit in numbers] != [_UNITS[key] for key in keys]:
        wanted = ", ".join(keys) or "no settings"
        raise RecordingError(f"{name!r}: {kind} is followed by {wanted}; correct the name")
    settings = {key: float(number) for key, (number, _) in zip(keys, numbers, strict=True)}
    return MeasurementName(
        tire=match["tire"],
        kind=kind,
        pressure=float(match["pressure"]) / 10,
        fz=float(match["fz"]),
        start=int(match["start"]),
        run=int(match["run"] or 1),
        **settings,
    )


def check_name(name: str) -> str:
    """The name itself when it is one folder name and nothing else."""
    if not isinstance(name, str) or not _SAFE.fullmatch(name):
        raise RecordingError(
            f"{name!r}: not a name for a measurement; use letters, digits and . _ + - "
            "(at most 200, a letter or digit first)"
        )
    return name


def free_name(folder: Path, name: str) -> str:
    """`name`, or the first of `name_r02`, `name_r03`, ... that the folder does not have yet."""
    check_name(name)
    base, _, run = name.rpartition("_r")
    first = int(run) if base and run.isdigit() else 1
    stem = base if first > 1 else name
    candidate, number = name, max(first, 1)
    while (folder / candidate).exists():
        number += 1
        candidate = f"{stem}_r{number:02d}"
    return check_name(candidate)


_KINDS = {
    "slip": "REL",
    "free_rolling": "ERR_REL",
    "stiffness": "STF",
    "stiffness_vertical": "STF",
    "stiffness_longitudinal": "STF_LNG",
    "stiffness_lateral": "STF_LAT",
    "repeat": "REP_REL",
}


def kind_of(
    measurement: str, alpha_deg: float = 0.0, gamma_deg: float = 0.0, waveform: str = ""
) -> str:
    """Kind for a measurement, its angles [deg] and waveform; others are called by their name."""
    kind = _KINDS.get(measurement, re.sub(r"[^A-Z]+", "_", measurement.upper()).strip("_"))
    if kind not in ("REL", "ERR_REL"):
        return kind
    kind += ("_COM" if alpha_deg else "_LNG") + ("_CAM" if gamma_deg else "")
    shaped = measurement == "slip" and waveform not in STEPS
    return f"{kind}_{waveform.upper()}" if shaped else kind
