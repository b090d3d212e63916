# SPDX-License-Identifier: Apache-2.0
"""Properties of the tire that its nominal model lacks."""

from __future__ import annotations

from dataclasses import dataclass

from flatplank_sim.plant.defects.base import Defect, Site, defect_param


@dataclass(frozen=True)
class CarcassCreep(Defect):
    """Creep of the rubber: part of the carcass deflection is delayed.

    A Kelvin element acts in series with the carcass.
    """

    share: float = defect_param(
        0.15, "-", "delayed over elastic deflection", (0.0, 2.0), "tire.creep"
    )
    time: float = defect_param(
        5.0, "s", "constant of the creep", (0.01, 1000.0), "tire.creep_time"
    )

    source = "the tire itself, not the thesis's machine"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})


@dataclass(frozen=True)
class CarcassLoad(Defect):
    """The carcass stiffness depends more on load than in the nominal tire.

    The exponent adds to that of the longitudinal carcass stiffness over load.
    """

    exponent: float = defect_param(0.2, "-", "added", (-2.0, 2.0))

    source = "thesis 7.4"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        site.tire["cx_f"] += self.exponent


@dataclass(frozen=True)
class CarcassPressure(Defect):
    """The carcass stiffness depends more on pressure than in the nominal tire.

    The exponent adds to that of the longitudinal carcass stiffness over pressure.
    """

    exponent: float = defect_param(0.5, "-", "added", (-2.0, 2.0))

    source = "thesis 7.4"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})

    def install(self, site: Site) -> None:
        site.tire["cx_p"] += self.exponent


@dataclass(frozen=True)
class CarcassSoftening(Defect):
    """The carcass softens with deflection.

    Force = stiffness * u / (1 + softening |u|).
    """

    per_metre: float = defect_param(15.0, "1/m", "softening", (0.0, 200.0), "tire.softening")

    source = "the tire itself, not the thesis's machine"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})


@dataclass(frozen=True)
class Conicity(Defect):
    """Conicity of the tire.

    It acts as a constant additional camber.
    """

    camber: float = defect_param(0.01, "rad", "own camber", (-0.2, 0.2), "tire.conicity")

    source = "the tire itself, not the thesis's machine"
    touches = frozenset({"fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})


@dataclass(frozen=True)
class PlySteer(Defect):
    """Ply steer: the plies of the belt cause a lateral force.

    It acts as an additional side slip angle, independent of the mounting side.
    """

    angle: float = defect_param(0.003, "rad", "own side slip angle", (-0.1, 0.1), "tire.ply_steer")

    source = "the tire itself, not the thesis's machine"
    touches = frozenset({"fy"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts"})


@dataclass(frozen=True)
class DriveBrakeAsymmetry(Defect):
    """The friction of the tire is lower when braking.

    It reduces the friction of bristles deflected backward.
    """

    friction: float = defect_param(
        0.05, "-", "loss of friction when braking", (-0.5, 0.5), "tire.brake_friction"
    )

    source = "thesis 6.3, figure 6.3"
    touches = frozenset({"fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "fz", "lvdt_volts", "fy"})


@dataclass(frozen=True)
class TireNonuniformity(Defect):
    """The tire's stiffness varies over its circumference.

    Radial force variation of orders 1 to 3 of the wheel angle, with a rolling radius that
    follows it.
    """

    order1: float = defect_param(25.0, "N", "amplitude once per turn", (0.0, 1000.0), "nu1")
    order2: float = defect_param(12.0, "N", "twice per turn", (0.0, 1000.0), "nu2")
    order3: float = defect_param(8.0, "N", "three times per turn", (0.0, 1000.0), "nu3")
    phase: float = defect_param(0.7, "rad", "wheel angle of the peaks", into="nu_phase")
    rolling: float = defect_param(
        1e-6, "m/N", "rolling radius per radial force", (-1e-4, 1e-4), "nu_rolling"
    )

    source = "thesis 5.6 (three start angles)"
    touches = frozenset({"fz", "fx"})
    spares = frozenset({"plank_counts", "wheel_counts", "steer_counts", "lvdt_volts", "fy"})
