# SPDX-License-Identifier: Apache-2.0
"""Check of the signs of measured columns against physics (ISO W), before any fit.

No sign is changed here: a column with the wrong sign is reported with the evidence and the
line that corrects it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from flatplank_data.params import ParameterError, from_mapping
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_data.waveforms import WAVEFORMS, Constant, Step

CLEAR = 0.8
"""least share of the runs, weighted by their force, that must contradict a sign"""
SLIP, ANGLE, CAMBER = 0.005, 0.4, 0.9
"""[1], [deg], [deg]: smaller values do not determine a sign"""
SEEN = 0.03
"""force over load below which a force does not determine a sign"""


@dataclass(frozen=True)
class WrongSign:
    """A column, or a key of the run record, with the wrong sign."""

    names: tuple[str, ...]
    """names that may be wrong: changing the sign of one of them is enough"""
    evidence: str
    """evidence in words, with numbers"""

    @property
    def remedy(self) -> str:
        """The line of campaign.yaml, or of a mapping file, that changes the sign."""
        first = f"`mapping: {{turn: [{self.names[0]}]}}` in campaign.yaml changes its sign"
        others = "".join(f", or [{n}]" for n in self.names[1:])
        return first + others

    def __str__(self) -> str:
        return f"sign of {' or '.join(self.names)}: {self.evidence}; {self.remedy}"


@dataclass(frozen=True)
class _Run:
    """Means of one run; forces [N]."""

    kappa: float
    """largest slip that was commanded; NaN where the commanded waveform is not known"""
    rolled: float
    """slip by the encoders, its mean in the direction of the commanded slip of each sample"""
    alpha: float
    gamma: float
    load: float
    turned: float
    """wheel angle times plank travel"""
    pulled: float
    """change of Fx by the slip, its mean in the direction of the commanded slip"""
    side: float
    """Fy before the step; without one, Fy of the second half"""
    fz: float


def wrong_signs(tables: Sequence[MeasurementTable]) -> tuple[WrongSign, ...]:
    """Wrong signs in the runs of a campaign; () when all agree with ISO W."""
    runs = [_run(t) for t in tables]
    return (
        *_sign_of(("fz",), [(1.0, r.fz) for r in runs],
               "Fz < 0 in {}, a loaded tire has Fz > 0"),
        *_sign_of(("wheel_angle", "plank_position"), [(1.0, r.turned) for r in runs if r.turned],
               "wheel and plank have opposite signs in {}"),
        *_slip(runs),
        *_sign_of(("alpha_deg", "fy"), [*_by_angle(runs)],
               "Fy has the sign of alpha in {}; ISO W: alpha > 0 gives Fy < 0"
               " (in SAE tables alpha > 0 gives Fy > 0)"),
        *_sign_of(("gamma_deg", "fy"), [*_by_camber(runs)],
               "camber thrust has the sign of gamma in {}; ISO W: the other"),
    )  # fmt: skip


def _run(table: MeasurementTable) -> _Run:
    info = table.info
    place = np.abs(table["plank_position"] - table["plank_position"][0])
    end = float(np.nanmax(place))
    step = info.step_position if np.isfinite(info.step_position) else np.nan
    stepped = np.isfinite(step) and 0.3 < step < end - 0.3
    late = place > (0.5 * (step + end) if stepped else 0.5 * end)
    early = (place > 0.5 * step) & (place < step) if stepped else late

    def mean(name: str, where: np.ndarray) -> float:
        values = table[name][where] if table.has(name) else np.array([np.nan])
        return float(np.nanmean(values)) if np.isfinite(values).any() else np.nan

    fz = mean("fz", late)
    command = _commanded(info, place - step) if stepped else np.full(len(place), np.nan)
    return _Run(
        kappa=float(np.abs(command).max()),
        rolled=_along(command, _slip_of(table, place, early)),
        alpha=info.alpha_deg,
        gamma=info.gamma_deg,
        load=info.fz if np.isfinite(info.fz) else abs(fz),
        turned=float(np.ptp(place))
        * _change_of(table, "wheel_angle")
        * _change_of(table, "plank_position"),
        pulled=_along(command, table["fx"] - mean("fx", early)) if table.has("fx") else np.nan,
        side=mean("fy", early),
        fz=fz,
    )


def _commanded(info: RunRecord, distance: np.ndarray) -> np.ndarray:
    """Slip that was asked for at distances from its start [m]; NaN where it is not known."""
    given = dict(info.waveform or {})
    kind = WAVEFORMS.get(str(given.pop("name", "") or "step"))
    if kind in (Constant, Step):
        given["kappa"] = info.kappa
    try:
        wave = from_mapping(kind, given, "waveform") if kind and given else None
    except ParameterError:
        wave = None
    if wave is None:
        return np.full(len(distance), np.nan)
    return np.array([wave.slip(float(d)) if d >= 0.0 else 0.0 for d in distance])


def _slip_of(table: MeasurementTable, place: np.ndarray, free: np.ndarray) -> np.ndarray:
    """Slip of each sample by the encoders, against the wheel turn where the tire rolls freely."""
    turn = np.abs(np.diff(table["wheel_angle"], append=np.nan))
    way = np.abs(np.diff(place, append=np.nan))
    return turn / _rolled(table, free) - way


def _along(command: np.ndarray, seen: np.ndarray) -> float:
    """Mean of what was seen, in the direction of the command; NaN without a command."""
    good = np.isfinite(command) & np.isfinite(seen)
    weight = float(np.abs(command[good]).sum())
    return float(command[good] @ seen[good]) / weight if weight > 0.0 else np.nan


def _change_of(table: MeasurementTable, name: str) -> float:
    if not table.has(name):
        return 0.0
    values = table[name][np.isfinite(table[name])]
    return float(values[-1] - values[0]) if len(values) > 1 else 0.0


def _rolled(table: MeasurementTable, where: np.ndarray) -> float:
    """Wheel turn per plank travel, both as absolute values."""
    angle, place = table["wheel_angle"][where], table["plank_position"][where]
    good = np.isfinite(angle) & np.isfinite(place)
    if good.sum() < 3:
        return np.nan
    angle, place = angle[good], place[good]
    return float(abs((angle[-1] - angle[0]) / ((place[-1] - place[0]) or np.nan)))


def _contradictions(pairs: Sequence[tuple[float, float]]) -> tuple[int, int]:
    """Number of pairs (given, force) with opposite signs, and of pairs; 0 when unclear."""
    good = [(a, b) for a, b in pairs if np.isfinite(a) and np.isfinite(b) and a != 0.0]
    weight = sum(abs(b) for _, b in good)
    wrong = [(a, b) for a, b in good if a * b < 0.0]
    clear = bool(good) and sum(abs(b) for _, b in wrong) > CLEAR * weight
    return (len(wrong) if clear else 0), len(good)


def _sign_of(
    names: tuple[str, ...], pairs: Sequence[tuple[float, float]], text: str
) -> Iterator[WrongSign]:
    """A wrong sign for these names, where the pairs (given, force) clearly have opposite signs."""
    wrong, count = _contradictions(pairs)
    if wrong:
        yield WrongSign(names, text.format(f"{wrong} of {count} runs"))


def _slip(runs: Sequence[_Run]) -> Iterator[WrongSign]:
    """Compare the commanded slip, the slip of the encoders and Fx, sample by sample: two decide
    against one."""
    slipped = [r for r in runs if r.kappa >= SLIP and abs(r.pulled) > SEEN * r.load]
    wrong, count = _contradictions([(1.0, r.pulled) for r in slipped])
    turned, seen = _contradictions([(1.0, r.rolled) for r in slipped])
    if wrong and not turned:
        text = f"driving slip lowers Fx in {wrong} of {count} runs, it must raise Fx"
        yield WrongSign(("fx",), text)
    elif turned:
        text = f"the encoders show the other slip than kappa says in {turned} of {seen} runs"
        both = " and Fx goes with the encoders" if wrong else " and Fx goes with kappa"
        yield WrongSign(("kappa",) if wrong else ("kappa", "fx"), text + both)


def _by_angle(runs: Sequence[_Run]) -> Iterator[tuple[float, float]]:
    """Pairs of side slip and lateral force relative to straight wheels."""
    straight = [r.side for r in runs if abs(r.alpha) < ANGLE and abs(r.gamma) < CAMBER]
    zero = float(np.nanmean(straight)) if len(straight) and np.isfinite(straight).any() else 0.0
    for r in runs:
        if abs(r.alpha) >= ANGLE and abs(r.side - zero) > SEEN * r.load:
            yield -r.alpha, r.side - zero


def _by_camber(runs: Sequence[_Run]) -> Iterator[tuple[float, float]]:
    """Pairs of camber and lateral force, from runs that differ in the camber only."""
    for r in runs:
        like = [q for q in runs if q.alpha == r.alpha and q.load == r.load]
        sides = [q.side for q in like]
        if abs(r.gamma) < CAMBER or not np.isfinite(sides).any():
            continue
        away = r.gamma - float(np.mean([q.gamma for q in like]))
        thrust = r.side - float(np.nanmean(sides))
        if abs(away) >= CAMBER and abs(thrust) > SEEN * r.load:
            yield -away, thrust
