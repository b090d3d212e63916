# SPDX-License-Identifier: Apache-2.0
"""Makes a challenge: nine slips, three starts, a hidden effect, a sealed answer."""

from __future__ import annotations

import math
import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.signal import lfilter

from flatplank_control.bench.results import write_campaign
from flatplank_control.runner.measurement import START_ANGLES
from flatplank_data.campaign import CAMPAIGN_FILE
from flatplank_data.errors import FlatplankError
from flatplank_data.exporters import export_campaign, write_parquet
from flatplank_data.machine import FAST, SLOW
from flatplank_data.run_record import RunRecord
from flatplank_data.table import MeasurementTable
from flatplank_data.yaml_text import load_yaml
from flatplank_sim.plant.campaign import COLUMNS, Campaign, CampaignRun
from flatplank_sim.plant.config import PlantConfig
from flatplank_sim.sealed.conditions import LOAD, PRESSURE, STEP, Run, Setting
from flatplank_sim.sealed.menu import CLOSE, MENU, OUTSIDE, Defects, Force, Hidden
from flatplank_sim.sealed.seal import seal, seal_plant, unseal
from flatplank_sim.twin.campaign import SLIPS

NAME = "TOY"
PLANT = {"tire": "toyo"}
"""the simulated bench, as the records of the runs state it"""
TIRE_SCATTER = 0.01
"""standard deviation of friction and stiffness from run to run [-]"""
NOISE = 15.0
"""standard deviation of the slow noise of the forces [N]; thesis 6.3 finds 24 N at no slip"""
NOISE_TIME = 0.3
"""correlation time of that noise [s]"""
SHORT_SLIPS, SHORT_STARTS = (-0.05, -0.01, 0.01, 0.05), (1, 2)
"""runs of a short campaign: eight, a third of the usual plan"""
OUTSIDE_SIZES = (60.0, 120.0)
"""range of a force that no effect of the library explains [N]"""
Progress = Callable[[int, int, str], None]


def ignore_progress(_done: int, _all: int, _name: str) -> None:
    """Progress callback that shows nothing."""


@dataclass(frozen=True)
class Machine:
    """The machine of a challenge, and the hidden effect."""

    seed: int
    hidden: Hidden
    size: float
    force: Force
    outside_location: dict[str, Any] | None
    """location of a force that no effect of the library explains"""


def make_challenge(
    folder: Path, seed: int, progress: Progress = ignore_progress, outside: str = "",
    close: str = "",
) -> Path:  # fmt: skip
    """Make a campaign folder with `answer.sealed`; the same seed makes the same challenge.

    outside: hide a force of `menu.OUTSIDE`, which no effect of the library explains, instead of a
    defect; close: hide a defect of `menu.CLOSE` in a short campaign.
    """
    random = np.random.default_rng(seed)
    machine = _machine(seed, outside, close, random)
    plan = (SHORT_SLIPS, SHORT_STARTS) if close else (SLIPS, START_ANGLES)
    pairs = [(kappa, start) for kappa in plan[0] for start in plan[1]]
    order = [pairs[which] for which in random.permutation(len(pairs))]
    export_campaign(_measure(machine, _steps(order, STEP), 0, (), progress), folder)
    effects = []
    if machine.hidden.names:
        first, *others = machine.hidden.names
        unit = machine.hidden.unit
        hidden = {"name": first, "size": machine.size, "unit": unit, "class": others}
        effects = [hidden | ({"runs": machine.hidden.runs} if machine.hidden.runs else {})]
    answer = {"seed": seed, "tire": "toyo", "effects": effects}
    forced = {"outside": machine.outside_location, "force": outside, "close": close}
    seal(answer | forced, folder)
    if not outside:  # a force outside the library is added to the signals, not to the plant
        seal_plant({"defects": machine.hidden.defects(machine.size)}, folder)
    return folder


def more_runs(
    folder: Path, challenge: Path, runs: Sequence[tuple[float, int]], step: float,
    progress: Progress = ignore_progress,
) -> Path:  # fmt: skip
    """Make more runs of the machine of a challenge, in another folder.

    runs: slip [-] and start (1, 2, 3) of each, in their order; step: plank position of the step
    [m]. Run numbers continue after the challenge; the name of the folder seeds the noise.

    Raises:
        FlatplankError: the challenge has no answer, or is older than this.
    """
    machine = _machine_of(challenge)
    first = len(SLIPS) * len(START_ANGLES)
    stream = (zlib.crc32(folder.name.encode()),)
    return export_campaign(_measure(machine, _steps(runs, step), first, stream, progress), folder)


def measure_next(
    challenge: Path, settings: Mapping[str, Any], repeats: int,
    progress: Progress = ignore_progress,
) -> None:  # fmt: skip
    """Make the proposed next run of a diagnosis on the machine of a challenge, and add it to the
    campaign.

    settings: those of `next_run` in the JSON of the diagnosis [SI, bar].

    Raises:
        FlatplankError: the challenge has no answer, or is older than this, or this machine cannot
            make the run.
    """
    machine = _machine_of(challenge)
    one = dict(settings)
    starts = one.pop("starts", None) or [one.pop("start", 1)]
    if unknown := sorted(set(one) - set(_Planned._fields)):
        raise FlatplankError(
            f"no run with {', '.join(unknown)}", str(challenge),
            f"known: starts, {', '.join(_Planned._fields)}",
        )  # fmt: skip
    known = load_yaml((challenge / CAMPAIGN_FILE).read_bytes(), CAMPAIGN_FILE)["runs"]
    planned = [_Planned(**one, start=start) for start in starts] * repeats
    for table in _measure(machine, planned, len(known), (len(known),), progress):
        record = table.info.to_dict()
        write_parquet(table, challenge / table.info.file)
        write_campaign(challenge, NAME, [(record, table.info.file)])


class _Planned(NamedTuple):
    """A run to make."""

    kappa: float
    """slip after the step [-]"""
    start: float
    """start of the wheel, 120 deg apart"""
    step_position: float
    """plank position of the step [m]"""
    fz: float = LOAD
    pressure: float = PRESSURE
    """[bar]"""
    preload: float = 0.0
    """slip before the step [-]"""
    speed: float = FAST
    """speed of the plank [m/s]"""

    @property
    def angle(self) -> float:
        """Wheel angle at the start [deg]."""
        return 120.0 * (self.start - 1.0)

    @property
    def changes(self) -> dict[str, Any]:
        """Keys of the record in which the run differs from a usual slip step."""
        out: dict[str, Any] = {}
        if self.start in START_ANGLES:
            out["start"] = int(self.start)
        else:
            out["start_angle_deg"] = self.angle
        if self.preload:
            slips = {"kappa_1": self.preload, "kappa_2": self.kappa, "length": self.step_position}
            out |= {"step_position": 0.0, "waveform": {"name": "double_step", **slips}}
        return out


def _steps(runs: Sequence[tuple[float, int]], step: float) -> list[_Planned]:
    return [_Planned(kappa, start, step) for kappa, start in runs]


def _machine_of(challenge: Path) -> Machine:
    """The machine of a challenge; FlatplankError when it has no answer, or an older one."""
    answer = unseal(challenge)
    if "force" not in answer:
        raise FlatplankError(
            "does not state which force was hidden", str(challenge), "make the challenge again"
        )
    seed = int(answer["seed"])
    random = np.random.default_rng(seed)
    return _machine(seed, answer["force"], answer.get("close", ""), random)


def _machine(seed: int, outside: str, close: str, random: np.random.Generator) -> Machine:
    if close:
        hidden = CLOSE[close]
    else:
        hidden = MENU["nothing" if outside else str(random.choice(sorted(MENU)))]
    return Machine(seed, hidden, hidden.draw(random), *_outside_force(outside, random))


def _measure(
    machine: Machine, runs: Sequence[_Planned], first: int, stream: tuple[int, ...],
    progress: Progress,
) -> Iterator[MeasurementTable]:  # fmt: skip
    """Measure runs; `first` is the number of the first one, `stream` seeds their noise."""
    plain = PlantConfig.load(PLANT["tire"])
    stiffness = plain.tire.vertical_stiffness
    for done, p in enumerate(runs, start=1):
        index = first + done - 1
        radius = round(Campaign(plain).true_radius(p.fz, stiffness), 5)
        known: dict[str, Any] = {
            "kappa": p.kappa, "fz": p.fz, "pressure": p.pressure, "run_index": index,
            "effective_rolling_radius": radius, "step_position": p.step_position,
        }  # fmt: skip
        own = np.random.default_rng((machine.seed, index, *stream))
        defects = machine.hidden.defects(machine.size)
        columns = Campaign(_scattered(plain, defects, own)).run(_run_of(p, known), own)
        _add_noise(columns, own)
        sought = Run(Setting(p.kappa, p.fz, p.pressure), int(p.start), index)
        columns["fx"] = columns["fx"] + machine.force(columns, sought)
        known |= p.changes
        label = f"{NAME}_REL_LNG_{100 * p.kappa:g}perc_T_p25_Fz{p.fz:g}_{p.start:g}"
        if stream:
            label += f"_run{index}"
        info = RunRecord(file=f"{label}.parquet", tire=NAME, plant=PLANT, **known)
        progress(done, len(runs), label)
        yield MeasurementTable({c: columns[c] for c in COLUMNS}, info)


def _run_of(p: _Planned, known: Mapping[str, Any]) -> CampaignRun:
    """The run of the simulated plant."""
    step = p.step_position
    profile = ((0.0, p.preload), (step, p.preload), (step, p.kappa)) if p.preload else ()
    return CampaignRun(
        start_angle=math.radians(p.angle), profile=profile, fast=p.speed > SLOW, **known
    )


def _outside_force(name: str, random: np.random.Generator) -> tuple[Force, dict[str, Any] | None]:
    """A force outside the library and its location; without a name zero force and None."""
    if not name:
        return (lambda _columns, _run: np.zeros(1)), None
    return OUTSIDE[name](float(random.uniform(*OUTSIDE_SIZES)), random)


def _scattered(plain: PlantConfig, defects: Defects, random: np.random.Generator) -> PlantConfig:
    """Configuration of the bench for one run, with random scatter of the tire."""
    names = ("friction", "tread_stiffness_x", "carcass_stiffness_x")
    tire = {n: getattr(plain.tire, n) * (1 + TIRE_SCATTER * random.normal()) for n in names}
    return PlantConfig.load(PLANT["tire"], overrides={"defects": defects, "tire": tire})


def _add_noise(columns: dict[str, np.ndarray], random: np.random.Generator) -> None:
    """Add slow noise to the forces, a first-order process."""
    keep = math.exp(-float(columns["time"][1] - columns["time"][0]) / NOISE_TIME)
    for name in ("fx", "fy", "fz"):
        white = random.normal(0.0, NOISE * math.sqrt(1.0 - keep**2), len(columns[name]))
        columns[name] = columns[name] + lfilter([1.0], [1.0, -keep], white)
