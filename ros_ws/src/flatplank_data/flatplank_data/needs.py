# SPDX-License-Identifier: Apache-2.0
"""Which parameters a campaign can tell, and which runs are missing for the others."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from flatplank_data.run_record import RunRecord

Infos = Sequence[RunRecord]


@dataclass(frozen=True)
class Need:
    """Parameters and what is missing for them; nothing missing is an empty text."""

    parameters: str
    meaning: str
    missing: Callable[[Infos], str]


NEEDS: list[Need] = []


def need(parameters: str, meaning: str) -> Callable[[Callable[[Infos], str]], Callable]:
    """Register what a group of parameters needs."""

    def register(function: Callable[[Infos], str]) -> Callable[[Infos], str]:
        NEEDS.append(Need(parameters, meaning, function))
        return function

    return register


def what_is_missing(infos: Infos) -> list[dict[str, str]]:
    """Every group of parameters with its verdict."""
    return [
        {"parameters": n.parameters, "meaning": n.meaning, "missing": n.missing(infos)}
        for n in NEEDS
    ]


def _steps(infos: Infos) -> list[RunRecord]:
    return [i for i in infos if i.measurement == "slip"]


def _levels(infos: Infos, name: str) -> int:
    return len({getattr(i, name) for i in infos})


def _most_slips(infos: Infos) -> int:
    points: dict[object, set[float]] = {}
    for info in _steps(infos):
        points.setdefault(info.condition.operating_point, set()).add(info.kappa)
    return max((len(levels) for levels in points.values()), default=0)


@need("sigma_x, C'_Fk", "linear transient model per run")
def _linear(infos: Infos) -> str:
    return "" if any(i.kappa for i in _steps(infos)) else "slip steps with kappa other than 0"


@need("c_cx", "carcass stiffness per operating point")
def _carcass(infos: Infos) -> str:
    lack = 3 - _most_slips(infos)
    return "" if lack <= 0 else f"{lack} more slip level(s) at one operating point"


@need("r_e", "effective rolling radius")
def _radius(infos: Infos) -> str:
    rolling = [i for i in infos if i.measurement in ("free_rolling", "slip")]
    return "" if rolling else "a free-rolling run"


@need("QRE0, BREFF, DREFF, FREFF", "rolling radius over load")
def _radius_load(infos: Infos) -> str:
    lack = 3 - _levels([i for i in infos if i.measurement in ("free_rolling", "slip")], "fz")
    return "" if lack <= 0 else f"rolling runs at {lack} more load(s)"


@need("PCX1, PDX1, PEX1, PKX1, PHX1, PVX1", "longitudinal curve at nominal load")
def _pure_fx(infos: Infos) -> str:
    lack = 5 - _most_slips(infos)
    return "" if lack <= 0 else f"{lack} more slip level(s), braking and driving"


@need("PDX2, PKX2, PKX3, PEX2, PEX3", "longitudinal curve over load")
def _fx_load(infos: Infos) -> str:
    lack = 3 - _levels(_steps(infos), "fz")
    return "" if lack <= 0 else f"slip steps at {lack} more load(s)"


@need("PPX1 and PPX2, PPX3 and PPX4", "longitudinal curve over pressure, apart")
def _fx_pressure(infos: Infos) -> str:
    lack = 3 - _levels(_steps(infos), "pressure")
    return "" if lack <= 0 else f"slip steps at {lack} more pressure(s): two cannot separate them"


@need("PDX3, PKY6, PHY3", "camber")
def _camber(infos: Infos) -> str:
    return "" if _levels(infos, "gamma_deg") >= 2 else "runs at another camber angle"


@need("PCY1, PDY1, PEY1, PKY1", "lateral curve")
def _pure_fy(infos: Infos) -> str:
    lack = 4 - _levels(_steps(infos), "alpha_deg")
    return "" if lack <= 0 else f"runs at {lack} more side slip angle(s)"


@need("PHY1, PVY1 and the steering zero", "lateral offset of the tire or of the machine")
def _offset(infos: Infos) -> str:
    angles = {i.alpha_deg for i in _steps(infos)}
    both = any(a < 0 for a in angles) and any(a > 0 for a in angles)
    return "" if both else "side slip of both signs, or the tire turned round on its rim"


@need("RBX1, RBX2, RCX1, RBY1, RBY2, RCY1", "combined slip")
def _combined(infos: Infos) -> str:
    lack = 2 - _levels([i for i in _steps(infos) if i.alpha_deg and i.kappa], "alpha_deg")
    return "" if lack <= 0 else f"slip steps at {lack} more side slip angle(s) other than 0"


@need("C_z, PFZ1", "vertical stiffness, over pressure")
def _vertical(infos: Infos) -> str:
    runs = [i for i in infos if i.measurement in ("stiffness", "stiffness_vertical")]
    if not runs:
        return "a vertical stiffness run at two pressures"
    return "" if _levels(runs, "pressure") >= 2 else "a vertical stiffness run at another pressure"


@need("C_x, C_y at rest", "stiffness of the standing tire along and across")
def _standing(infos: Infos) -> str:
    kinds = {i.measurement for i in infos}
    lack = [k for k in ("stiffness_longitudinal", "stiffness_lateral") if k not in kinds]
    return f"a run of the kind {' and one of '.join(lack)}" if lack else ""


@need("q_ra1, q_ra2", "contact length")
def _contact(infos: Infos) -> str:
    tables = any(i.measurement == "footprint" for i in infos)
    return "" if tables else "footprints at two loads or more"


@need("M_F, eta", "friction and efficiency of the wheel drive")
def _drive(infos: Infos) -> str:
    turns = any(i.measurement == "unloaded_turn" for i in infos)
    return "" if turns else "a turn with the wheel hanging free, at several speeds"


@need("repeatability", "scatter from run to run")
def _repeats(infos: Infos) -> str:
    groups: dict[object, int] = {}
    for info in _steps(infos):
        groups[(info.condition, info.start)] = groups.get((info.condition, info.start), 0) + 1
    if max(groups.values(), default=0) >= 2:
        return ""
    return "a run repeated from the same start angle: start angles mix it with non-uniformity"
