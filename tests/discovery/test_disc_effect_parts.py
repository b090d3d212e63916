# SPDX-License-Identifier: Apache-2.0
"""What each effect does to motion, tire and signal, on numbers without a tire."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from flatplank_analysis.contact_patch.tire_runs import References
from flatplank_analysis.effects.base import Block
from flatplank_analysis.effects.crosstalk import other
from flatplank_analysis.effects.force_channel import lagged, shifted
from flatplank_analysis.effects.gaps import play_distance
from flatplank_analysis.effects.registry import library


def test_a_delay_is_a_shift_with_the_ends_held():
    time = np.vstack([np.linspace(0.0, 5.0, 51), np.linspace(0.0, 10.0, 51)])
    values = np.stack([3.0 * time, -time, time + 1.0])
    delays = np.array([0.5, 0.0, -0.4]).reshape(3, 1, 1)
    found = shifted(values, time, delays)
    np.testing.assert_allclose(found[0], np.maximum(3.0 * (time - 0.5), 0.0), atol=1e-12)
    np.testing.assert_allclose(found[1], values[1])
    np.testing.assert_allclose(found[2], np.minimum(time + 1.4, time[:, -1:] + 1.0))
    one = shifted(values, time, np.full((1, 1, 1), 0.5))
    np.testing.assert_allclose(one[1], np.minimum(0.5 - time, 0.0), atol=1e-12)


def test_a_lag_of_a_ramp():
    """slope (t - T (1 - exp(-t/T))) after it began to rise, whatever the steps."""
    time = np.concatenate([[0.0], np.cumsum(np.random.default_rng(1).uniform(0.02, 0.3, 60))])
    step = np.diff(time, prepend=time[0])[None]
    lags = np.array([0.7, 0.0]).reshape(2, 1, 1)
    found = lagged(np.stack([2.0 * time[None] + 5.0] * 2), step, lags)
    wanted = 5.0 + 2.0 * (time - 0.7 * -np.expm1(-time / 0.7))
    np.testing.assert_allclose(found[0, 0], wanted)
    np.testing.assert_allclose(found[1, 0], 2.0 * time + 5.0, atol=1e-6)


def test_a_follower_is_dragged_through_a_gap():
    ahead = np.array([0.0, 1.0, 3.0, 2.0, -2.0, -1.0]).reshape(1, 1, 6)
    lost = np.empty_like(ahead)
    play_distance.py_func(ahead, np.array([[1.5]]), np.zeros((1, 1)), lost)
    # output: 0, 0, 1.5, 1.5, -0.5, -0.5
    np.testing.assert_allclose(lost[0, 0], [0.0, 1.0, 1.5, 0.5, -1.5, -0.5])


class Numbers:
    """Numbers of the tire that an effect may change; all one at first."""

    def __init__(self) -> None:
        object.__setattr__(self, "changed", {})

    def __getattr__(self, name):
        return self.changed.get(name, 1.0)

    def __setattr__(self, name, value):
        self.changed[name] = value


def acting(name: str, **values: float):
    """An instance with these values, as a model makes it."""
    effect = library()[name]
    vector = effect.vector(values)[None]
    made = effect.with_values(vector, 2)
    object.__setattr__(made, "per_run", effect.with_values(vector, 1))
    return made


ORDER = np.array([4.0, 0.0, 2.0])
DATA = SimpleNamespace(
    position=np.array([[-0.1, 0.0, 0.005, 1.0]] * 3),
    since_step=np.array([[-1.0, -0.3, -0.1, 0.5]] * 3),
    wheel_turn=np.array([[0.0, 0.5, 1.0, 1.5]] * 3),
    turned=np.array([[0.0, 0.5, 0.5, 0.5]] * 3),
    load=np.array([[2000.0], [3000.0], [4000.0]]) * np.ones(4),
    nominal=np.array([2000.0, 3000.0, 4000.0]),
    pressure=np.array([2.0, 2.5, 3.5]),
    gamma=np.array([0.0, 0.1, -0.1]),
    side_before=np.array([-1.0, 0.0, 1.0]),
    signals={"fz": np.array([[1.0, 1.0, 1.0, 1.0, 1.0, 4.0, 6.0]])},
    runs=SimpleNamespace(order=ORDER, time=np.array([[0.0, 1.0, 2.0, 3.0]] * 3)),
)  # fmt: skip
DATA.reference = References.of(DATA)
DATA.relative_load = DATA.nominal / DATA.reference.load
DATA.relative_pressure = DATA.pressure / DATA.reference.pressure


def tire(name: str, load=None, **values: float):
    what = SimpleNamespace(data=DATA, load=np.ones((1, 3, 4)) if load is None else load,
                           friction=np.ones((1, 3, 4)), x=Numbers(), y=Numbers())  # fmt: skip
    acting(name, **values).tire(what)
    return what


def signal(name: str, **values: float):
    force = np.array([[-400.0, -10.0, 0.0, 400.0]] * 3)[None]
    what = SimpleNamespace(data=DATA, fx=force.copy(), fy=0.0 * force, fz=0.0 * force,
                           true_fx=force, true_fy=0.0 * force)  # fmt: skip
    acting(name, **values).signal(what)
    return what


def motion(name: str, **values: float):
    two = np.full((1, 3, 4), 2.0)
    what = SimpleNamespace(data=DATA, travel=two, rolled=two.copy(), lateral=0.0 * two)
    acting(name, **values).motion(what)
    return what


@pytest.mark.parametrize(
    ("name", "values", "x", "y"),
    [
        ("combined_slip", {"share": 0.4}, {"other_slip": 1.4}, {"other_slip": 1.4}),
        ("road_play", {"gap": 2e-3, "rest": 0.5, "at": 40.0},
         {"play": 1.002, "play_rest": 1.5, "play_at": 40.0, "play_hold": 0.0}, {}),
        ("road_play", {"gap": 2e-3, "rest": 0.5, "at": 40.0, "kept": 1.0},
         {"play": 1.002, "play_rest": 0.0, "play_at": 0.0, "play_hold": 40.0}, {}),
        ("rack_backlash", {"gap": 2e-3, "rest": 0.5, "at": 40.0, "held_fast": 1.0},
         {"play": 1.002, "play_rest": 1.5, "play_at": 41.0}, {}),
        ("rack_backlash", {"gap": 2e-3, "rest": 0.5, "at": 40.0, "held_fast": 0.0},
         {"play": 1.0, "play_rest": 1.0, "play_at": 1.0}, {}),
        ("carcass_creep", {"share": 0.3, "time": 7.0}, {"creep": 1.3, "creep_time": 7.0}, {}),
        ("load_loss_braking", {"loss": 0.1, "seen": 0.0}, {"loss_brake": 1.1}, {}),
        ("load_loss_braking", {"loss": 0.1, "seen": 1.0}, {"loss_brake": 1.0}, {}),
        ("crosstalk_fx_fz", {"share": 0.1}, {"loss_brake": 0.9, "loss_drive": 0.9}, {}),
        ("drive_brake_asymmetry", {"less": 0.1}, {"asym_peak": 1.1}, {}),
        ("drive_brake_stiffness", {"less": 0.1}, {"asym_stiff": 1.1}, {}),
    ],
)  # fmt: skip
def test_numbers_of_the_tire(name, values, x, y):
    what = tire(name, **values)
    for block, wanted in ((what.x, x), (what.y, y)):
        found = {k: float(np.ravel(v)[0]) for k, v in block.changed.items()}
        assert found == pytest.approx(wanted)


def test_carcass_over_load_and_pressure():
    found = tire("carcass_load", slope=0.6, bend=0.3)
    more = np.array([-1.0, 0.0, 1.0]) / 3.0
    wanted = 1.0 + 0.6 * more + 0.3 * more**2
    np.testing.assert_allclose(found.x.carcass, wanted[None])
    np.testing.assert_allclose(found.y.carcass, wanted[None])
    assert tire("carcass_load", slope=2.0, bend=-3.0).x.carcass[0, 0] == pytest.approx(0.1)
    found = tire("carcass_pressure", slope=0.5)
    np.testing.assert_allclose(found.x.carcass, 1.0 + 0.5 * np.array([[-0.2, 0.0, 0.4]]))
    np.testing.assert_allclose(found.y.carcass, found.x.carcass)


def test_load_and_friction():
    load = np.array([1.0, 2.0, 3.0, 6.0]) * np.ones((1, 3, 1))
    felt = tire("measured_load", load.copy(), share=0.25).load
    np.testing.assert_allclose(felt, load - 0.25 * (load - 3.0))
    waved = tire("load_undulation", load.copy(), cos=0.1, sin=0.05, period=2.0).load
    phase = np.pi * DATA.position
    np.testing.assert_allclose(
        waved[0], load[0] * (1.0 + 0.1 * np.cos(phase) + 0.05 * np.sin(phase))
    )
    para = tire("parasitic_force", load.copy(), fz_cos=0.3, fz_sin=0.4).load
    np.testing.assert_allclose(
        para[0, 0], load[0, 0] - 0.5 * np.cos(DATA.wheel_turn[0] - np.arctan2(4, 3))
    )
    np.testing.assert_allclose(tire("wear", loss=0.2).friction[0, :, 0], [0.8, 1.0, 0.9])
    # 1 m is the middle of a patch of 0.3 m; its edges come in over twice the blur
    worn = tire("worn_patch", depth=0.2, position=1.0, width=0.3, blur=0.1).friction
    np.testing.assert_allclose(worn[0, 0], [1.0, 1.0, 1.0, 0.8])
    for away, cover in ((0.15, 0.5), (0.2, 0.5 - 0.75 * 0.5 + 0.25 * 0.125), (0.26, 0.0)):
        for side in (-1.0, 1.0):
            worn = tire("worn_patch", depth=0.2, position=1.0 + side * away, width=0.3, blur=0.1)
            assert worn.friction[0, 0, 3] == pytest.approx(1.0 - 0.2 * cover)
    # of a patch shorter than the contact, the depth is what the contact sees
    for width in (0.03, 0.1, 0.2):
        worn = tire("worn_patch", depth=0.2, position=1.0, width=width, blur=0.1).friction
        np.testing.assert_allclose(worn[0, 0], [1.0, 1.0, 1.0, 0.8])


def test_signals():
    force = np.array([-400.0, -10.0, 0.0, 400.0])
    np.testing.assert_allclose(
        signal("conicity", share=0.01).fy[0, :, 2:], [[20.0] * 2, [30.0] * 2, [40.0] * 2]
    )
    assert not signal("conicity", share=0.01).fy[..., :2].any()
    rolls = np.array([0.0, 0.0, -np.expm1(-1.0), 1.0])
    np.testing.assert_allclose(
        signal("rolling_resistance", share=0.01).fx[0, 1], force - 30.0 * rolls
    )
    np.testing.assert_allclose(signal("zero_drift_runs", drift=10.0).fx[0, :, 2], [5.0, -5.0, 0.0])
    np.testing.assert_allclose(
        signal("zero_drift", drift=10.0).fx[0, 0], force + 10.0 * np.arange(4)
    )
    np.testing.assert_allclose(signal("hub_gain", gain=0.1).fx[0, 0], 1.1 * force)
    lost = signal("load_loss_braking", loss=0.1, seen=1.0)
    np.testing.assert_allclose(lost.fz[0, 0], [-40.0, -1.0, 0.0, 0.0])
    assert not signal("load_loss_braking", loss=0.1, seen=0.0).fz.any()
    # by its play to either side: 2.13e5 N/m
    drop = signal("support_play_z", gap=1e-3).fz[0, 0]
    np.testing.assert_allclose(drop, 0.5 * 213.0 * np.tanh(force / 200.0))
    np.testing.assert_allclose(signal("crosstalk_fx_fy", share=0.1).fy[0, 0], 0.1 * force)
    np.testing.assert_allclose(signal("crosstalk_fx_fz", share=0.1).fz[0, 0], 0.1 * force)
    turn = DATA.wheel_turn[0]
    grow = np.array([0.0, 0.0, 1.0, 1.0]) * 4.0 / 3.0
    for order in (1, 2, 3):
        found = signal(f"nonuniformity_{order}", fx_cos=3.0, fz_sin=2.0)
        np.testing.assert_allclose(found.fx[0, 2], force + grow * 3.0 * np.cos(order * turn))
        np.testing.assert_allclose(found.fz[0, 2], grow * 2.0 * np.sin(order * turn))
        found = signal(f"runout_{order}", cos=1e-3, radial=1e5)
        np.testing.assert_allclose(found.fz[0, 0], 100.0 * np.cos(order * turn))
        moved = motion(f"runout_{order}", sin=1e-3).rolled[0, 0]
        np.testing.assert_allclose(moved, 2.0 + 1e-3 * np.sin(order * turn) * DATA.turned[0])
    found = signal("parasitic_force", fx_cos=3.0, fz_sin=2.0)
    np.testing.assert_allclose(found.fx[0, 0], force + 3.0 * np.cos(turn))
    np.testing.assert_allclose(found.fz[0, 0], 2.0 * np.sin(turn))


def test_crosstalk_of_a_channel_with_and_without_its_zero():
    tared = np.array([0.0, 1.0, 0.5]).reshape(3, 1, 1)
    found = other(SimpleNamespace(signals=DATA.signals), "fz", tared)
    raw = DATA.signals["fz"][0]
    np.testing.assert_allclose(found[:, 0], [raw, raw - 1.0, raw - 0.5])
    none = other(DATA, "mx", tared)
    assert none.shape[1:] == DATA.position.shape and not none.any()


def test_motions():
    tilted = motion("camber_thrust", share=0.2).lateral[0]
    np.testing.assert_allclose(tilted[:, 0], -0.2 * np.sin(DATA.gamma) * 2.0)
    phase = 2.0 * np.pi * DATA.position[0] / 0.4
    # an eighth of a second of filter at 0.03 m/s is hardly seen at 0.4 m
    ripple = 1e-3 * (np.cos(phase) - 1.0) + 2e-3 * np.sin(phase)
    found = motion("mesh_ripple", cos=1e-3, sin=2e-3, period=0.4).travel[0, 0] - 2.0
    np.testing.assert_allclose(found, np.diff(ripple, prepend=ripple[0]), rtol=0.02, atol=1e-9)
    held = motion("rack_backlash", gap=1e-3, held_fast=1.0).travel
    np.testing.assert_allclose(held, 2.0)


def test_numbers_of_a_block_have_names():
    block = Block(np.arange(6.0).reshape(1, 2, 3), ("a", "b", "c"))
    np.testing.assert_allclose(block.b, [[1.0, 4.0]])
    block.c = block.a + 1.0
    np.testing.assert_allclose(block.c, [[1.0, 4.0]])
    for act in (lambda: block.d, lambda: setattr(block, "d", 1.0)):
        with pytest.raises(AttributeError, match="no parameter 'd'"):
            act()
