# SPDX-License-Identifier: Apache-2.0
"""Parasitic signal of the preloaded shaft, Appendix C: y = A sin(B x + C) + D per channel over the
wheel angle.

The angle is that of the wheel encoder's own counter. A fit holds until the encoder loses its zero
or the wheel is remounted, so each mounting has its own file.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import MISSING, asdict, dataclass
from pathlib import Path

from flatplank_data.files import read_text
from flatplank_data.params import from_mapping, param
from flatplank_data.yaml_text import dump_yaml, load_format

FORMAT = "flatplank-parasitic-fit/1"
CHANNELS = ("C1", "C2", "C3", "C5", "C6")
INDEX = (0, 1, 2, 4, 5)
"""indices of the channels in the bridge volts"""


@dataclass(frozen=True)
class Sine:
    """Parameters of (C.1) of one channel, named as in a file."""

    amplitude_v: float = param(MISSING, "A", unit="V", bounds=(0.0, 10.0))
    frequency: float = param(MISSING, "B, of the wheel", unit="1/rad", bounds=(0.1, 10.0))
    phase_rad: float = param(MISSING, "C", unit="rad", bounds=(-1e3, 1e3))
    offset_v: float = param(MISSING, "D", unit="V", bounds=(-10.0, 10.0))
    residual_rms_v: float = param(MISSING, "rms residual", unit="V", bounds=(0.0, 10.0))


@dataclass(frozen=True)
class _Channels:
    C1: Sine
    C2: Sine
    C3: Sine
    C5: Sine
    C6: Sine


@dataclass(frozen=True)
class _File:
    mounting: str
    date: str
    channels: _Channels


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
            (s.amplitude_v, s.frequency, s.phase_rad) for s in self.sines
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
        return (a.offset_v, b.offset_v, c.offset_v, d.offset_v, e.offset_v)


def fit_to_text(fit: ParasiticFit) -> str:
    """The YAML of one mounting."""
    content = asdict(_File(fit.mounting, fit.date, _Channels(*fit.sines)))
    return dump_yaml({"format": FORMAT, **content})


def fit_from_text(text: str, where: str) -> ParasiticFit:
    """Read the YAML of one mounting; FlatplankError names the place and what is wrong."""
    found = from_mapping(_File, load_format(text, where, FORMAT), where)
    sines = tuple(getattr(found.channels, name) for name in CHANNELS)
    return ParasiticFit(found.mounting, found.date, sines)


def load_fit(path: str | Path) -> ParasiticFit:
    """The fit of a file; ValueError when it cannot be used."""
    return fit_from_text(read_text(path), str(path))
