# SPDX-License-Identifier: Apache-2.0
"""Parasitic signal of the preloaded shaft, Appendix C: y = A sin(B x + C) + D per channel over the
wheel angle.

The angle is that of the wheel encoder's own counter. A fit holds until the encoder loses its zero
or the wheel is remounted, so each mounting has its own file.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from flatplank_data.files import read_text
from flatplank_data.limits import Limit
from flatplank_data.names import nearest_hint
from flatplank_data.yaml_text import dump_yaml, load_yaml

FORMAT = "flatplank-parasitic-fit/1"
CHANNELS = ("C1", "C2", "C3", "C5", "C6")
INDEX = (0, 1, 2, 4, 5)
"""indices of the channels in the bridge volts"""


class Sine(NamedTuple):
    """Parameters of (C.1) of one channel."""

    amplitude: float
    """A [V]"""
    frequency: float
    """B [1/rad of the wheel]"""
    phase: float
    """C [rad]"""
    offset: float
    """D [V]"""
    residual_rms: float
    """rms of the residual of the fit [V]"""


LIMITS: dict[str, Limit] = {
    "amplitude_v": Limit(0.0, 10.0, "V"),
    "frequency": Limit(0.1, 10.0, "1/rad"),
    "phase_rad": Limit(-1e3, 1e3, "rad"),
    "offset_v": Limit(-10.0, 10.0, "V"),
    "residual_rms_v": Limit(0.0, 10.0, "V"),
}
"""key in a file -> range, in the order of `Sine`"""


@dataclass(frozen=True)
class ParasiticFit:
    """The fit of one mounting."""

    mounting: str
    date: str
    sines: tuple[Sine, ...]
    """five sines, in the order of `CHANNELS`"""

    def signal(self) -> Callable[[float], tuple[float, float, float, float, float]]:
        """A sin(B x + C) of the channels [V] as a function of the wheel angle x [rad], without
        D."""
        sin = math.sin
        (a1, b1, c1), (a2, b2, c2), (a3, b3, c3), (a5, b5, c5), (a6, b6, c6) = (
            s[:3] for s in self.sines
        )
        return lambda x: (
            a1 * sin(b1 * x + c1),
            a2 * sin(b2 * x + c2),
            a3 * sin(b3 * x + c3),
            a5 * sin(b5 * x + c5),
            a6 * sin(b6 * x + c6),
        )

    @property
    def offsets(self) -> tuple[float, float, float, float, float]:
        """D of the channels [V]."""
        a, b, c, d, e = self.sines
        return (a.offset, b.offset, c.offset, d.offset, e.offset)


def fit_to_text(fit: ParasiticFit) -> str:
    """The YAML of one mounting."""
    channels = {
        name: {key: float(value) for key, value in zip(LIMITS, sine, strict=True)}
        for name, sine in zip(CHANNELS, fit.sines, strict=True)
    }
    content = {"format": FORMAT, "mounting": fit.mounting, "date": fit.date, "channels": channels}
    return dump_yaml(content)


def fit_from_text(text: str, where: str) -> ParasiticFit:
    """Read the YAML of one mounting; ValueError names the place and what is wrong."""
    content = load_yaml(text, where)
    if not isinstance(content, dict) or content.get("format") != FORMAT:
        raise ValueError(f"{where}: not a parasitic fit; expected 'format: {FORMAT}'")
    _keys(content, {"format", "mounting", "date", "channels"}, where)
    channels = content["channels"]
    if not isinstance(channels, dict):
        raise ValueError(f"{where}: 'channels' must hold {', '.join(CHANNELS)}")
    _keys(channels, set(CHANNELS), f"{where}: channels")
    sines = tuple(_sine(channels[name], f"{where}: {name}") for name in CHANNELS)
    return ParasiticFit(str(content["mounting"]), str(content["date"]), sines)


def load_fit(path: str | Path) -> ParasiticFit:
    """The fit of a file; ValueError when it cannot be used."""
    return fit_from_text(read_text(path), str(path))


def _keys(mapping: dict[str, Any], wanted: set[str], where: str) -> None:
    for key in mapping:
        if key not in wanted:
            raise ValueError(f"{where}: unknown key '{key}'{nearest_hint(str(key), wanted)}")
    missing = sorted(wanted - set(mapping))
    if missing:
        raise ValueError(f"{where}: missing {', '.join(missing)}; identify the fit again")


def _sine(values: Any, where: str) -> Sine:
    if not isinstance(values, dict):
        raise ValueError(f"{where}: expected {', '.join(LIMITS)}")
    _keys(values, set(LIMITS), where)
    for key, limit in LIMITS.items():
        value = values[key]
        if not isinstance(value, (int, float)) or isinstance(value, bool):
            raise ValueError(f"{where}: {key} is {value!r}, must be a number")
        if reason := limit.refusal(key, value):
            raise ValueError(f"{where}: {reason}")
    return Sine(*(float(values[key]) for key in LIMITS))
