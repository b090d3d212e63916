# SPDX-License-Identifier: Apache-2.0
"""What each effect does to motion, tire and signal, on numbers without a tire; the waves and
delays they are made of; what they are looked for in; and the checks of their contract.
"""

from __future__ import annotations

from dataclasses import make_dataclass, replace
from types import SimpleNamespace

import numpy as np
import pytest
from shapes import measured

from flatplank_analysis.contact_patch.data import from_tables
from flatplank_analysis.contact_patch.tire_runs import References
from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.discovery.runs import Coordinate
from flatplank_analysis.effects import checks, registry
from flatplank_analysis.effects.base import Block, TireEffect
from flatplank_analysis.effects.crosstalk import other
from flatplank_analysis.effects.force_channel import lagged, shifted
from flatplank_analysis.effects.gaps import distance
from flatplank_analysis.effects.plank_waves import periods, spectrum
from flatplank_analysis.effects.registry import library
from flatplank_analysis.effects.wheel_angle import wave
from flatplank_data.errors import FlatplankError

LOOKED_FOR = {
    # name: sizes from which a refit starts, price of looking, settings that no residual suggests
    "road_play": (
        (1.0, 2.5), 4, [{"kept": k, "at": at} for k in (0.0, 1.0) for at in (0.0, 50.0)],
    ),
    "drive_backlash": ((1.0, 2.5), 1, [{}]),
    "rack_backlash": (
        (1.0, 2.5), 3, [{"held_fast": 0.0}, {"held_fast": 1.0}, {"held_fast": 1.0, "at": 50.0}],
    ),
    "force_lag": ((1.0, 4.0), 1, [{}]),
    "load_loss_braking": ((1.0,), 2, [{"seen": 0.0}]),
    "carcass_creep": ((1.0,), 1, [{"time": 4.0}, {"time": 15.0}]),
    "crosstalk_fz": ((1.0,), 1, [{"tared": 1.0}, {"tared": 0.0}]),
    "crosstalk_mx": ((1.0,), 1, [{"tared": 1.0}]),
    "crosstalk_mz": ((1.0,), 1, [{"tared": 1.0}]),
}  # fmt: skip
HELD = {
    "road_play": ("kept",),
    "rack_backlash": ("held_fast",),
    "load_loss_braking": ("seen",),
} | {f"crosstalk_{c}": ("tared",) for c in ("fy", "fz", "mx", "mz")}
FROM_DATA = ("worn_patch", "mesh_ripple", "load_undulation", "measured_load", "crosstalk_fy")
"""what they are looked for in depends on the runs"""


@pytest.mark.parametrize("name", [n for n in library() if n not in FROM_DATA])
def test_what_an_effect_is_looked_for_in(name):
    """The price of looking is what the level is divided by: no less than the settings."""
    effect, runs = library()[name], measured(0).runs
    starts, price, settings = LOOKED_FOR.get(name, ((1.0,), 1, [{}]))
    assert effect.starts() == starts and effect.scanned(runs) == price
    assert effect.variants(runs, runs.measured) == settings
    assert effect.held() == HELD.get(name, ())


def placed(values: np.ndarray, channels=("fx", "fy", "fz"), **facts):
    """Runs with a plank position of 4 m and these values in the first channel."""
    runs = measured(0).runs
    place = np.broadcast_to(np.linspace(0.0, 4.0, values.shape[1]), values.shape).copy()
    whole = np.zeros((len(channels), *values.shape))
    whole[0] = values
    coordinates = {"plank position": Coordinate(place, "m", local=True),
                   "load": Coordinate(place * 0.0 + 3e3, "N")}  # fmt: skip
    return replace(runs, measured=whole, channels=channels, time=place, coordinates=coordinates,
                   facts=facts)  # fmt: skip


def test_settings_that_depend_on_the_runs():
    known = library()
    runs = placed(np.zeros((24, 400)))
    assert known["worn_patch"].scanned(runs) == 30
    # the periods that 4 m resolve between 1/80 and 1.2 m, and somewhat closer
    assert known["mesh_ripple"].scanned(runs) == 530 > 4.0 * 79.0
    assert known["load_undulation"].scanned(runs) == 100 > 4.0 * 12.5

    patch = known["worn_patch"].variants

    def places(**facts):
        return [v["position"] for v in patch(placed(np.zeros((24, 400)), **facts), runs.measured)]

    every = [0.2 + 0.16 * i for i in range(24)]
    assert places() == pytest.approx(every)
    assert {v["width"] for v in patch(runs, runs.measured)} == {0.2}
    free = [p for p in every if p < 1.9 or p > 2.2]
    assert places(step=np.full(24, 2.0)) == pytest.approx(free)
    assert places(step=np.linspace(2.0, 2.1, 24)) == pytest.approx(every)
    assert places(step=np.full(24, np.nan)) == pytest.approx(every)
    # a ripple that all runs show at the same place
    place = runs.coordinates["plank position"].values
    rough = np.cumsum(np.random.default_rng(1).standard_normal(400)) * 0.01
    hum = np.cos(2.0 * np.pi * place / 0.2)[None] + rough + 0.0 * runs.measured
    assert known["mesh_ripple"].variants(runs, hum)[0]["period"] == pytest.approx(0.2, rel=0.02)
    found = [v["period"] for v in known["load_undulation"].variants(runs, hum)]
    assert found[0] == pytest.approx(0.2, rel=0.02) and found[-3:] == [0.35, 0.7, 1.4]
    fy = known["crosstalk_fy"].variants
    assert fy(replace(runs, measured=runs.measured + 101.0), None) == [{"tared": 1.0}]
    assert fy(replace(runs, measured=runs.measured + 99.0), None) == []
    assert fy(placed(np.zeros((24, 400)), ("fx",)), None) == []
    assert known["load_loss_braking"].variants(runs, None) == [{"seen": 1.0}, {"seen": 0.0}]


def test_sizes_of_two_parts_are_amplitudes():
    for name in ("mesh_ripple", "load_undulation", "runout_2"):
        assert library()[name].size({"cos": 3e-3, "sin": -4e-3}) == pytest.approx(5e-3), name


def test_waves():
    angle = np.linspace(0.0, 7.0, 50)
    np.testing.assert_allclose(wave(angle, 3, 2.0 * np.cos(0.4), 2.0 * np.sin(0.4)),
                               2.0 * np.cos(3.0 * angle - 0.4))  # fmt: skip


def test_the_spectrum_of_what_all_runs_show():
    values = 3.0 * np.cos(2.0 * np.pi * np.linspace(0.0, 4.0, 900) / 0.25 + 0.3) + 7.0
    runs = placed(np.tile(values, (24, 1)))
    frequencies, level = spectrum(runs, runs.measured[0], "plank position")
    assert frequencies[1] == pytest.approx(1.0 / (4.0 * 4.0), rel=0.01)
    best = int(np.argmax(level))
    assert frequencies[best] == pytest.approx(4.0, abs=0.04)
    assert level[best] == pytest.approx(3.0, rel=0.02)
    assert level[0] < 0.01
    signs = np.where(np.arange(24) % 2, 1.0, -1.0)[:, None]
    assert spectrum(runs, (values - 7.0) * signs, "plank position")[1].max() < 1e-6
    # runs that begin later share what they have in common
    later = runs.coordinates["plank position"].values + np.linspace(0.0, 0.5, 24)[:, None]
    cut = replace(runs, coordinates={"plank position": Coordinate(later, "m")})
    same = 3.0 * np.cos(2.0 * np.pi * later / 0.25)
    frequencies, level = spectrum(cut, same, "plank position")
    assert level.max() == pytest.approx(3.0, rel=0.02)
    assert frequencies[np.argmax(level)] == pytest.approx(4.0, abs=0.05)


def test_periods_stand_out_of_their_neighbourhood():
    """The residual is red: a slow wave ten times as large is none of them."""
    x = np.linspace(0.0, 4.0, 900)
    rng = np.random.default_rng(3)
    red = np.cumsum(rng.standard_normal(900)) * 0.3
    values = red + 2.0 * np.cos(2.0 * np.pi * x / 0.11) + 1.5 * np.sin(2.0 * np.pi * x / 0.05)
    runs = placed(np.tile(values, (24, 1)))
    found = periods(runs, runs.measured, 0.03, 1.2)
    assert len(found) == 4 and len(periods(runs, runs.measured, 0.03, 1.2, 2)) == 2
    assert sorted(found[:2]) == pytest.approx([0.05, 0.11], rel=0.02)
    # each peak once, and only within what was asked for
    near = np.abs(1.0 / np.array(found)[:, None] - 1.0 / np.array(found)) + np.eye(4)
    assert near.min() > 6.0 / 16.2
    assert all(0.06 <= p <= 1.2 for p in periods(runs, runs.measured, 0.06, 1.2))
    assert all(0.03 <= p <= 0.08 for p in periods(runs, runs.measured, 0.03, 0.08))


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
    distance.py_func(ahead, np.array([[1.5]]), lost)
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


def test_the_made_up_campaign_has_all_that_an_effect_may_look_at():
    """Four slips at two starts; three loads, two pressures; each force with its own form."""
    data = checks.probe_model().data
    runs = data.runs
    assert runs.runs == 8 and not runs.repeated
    np.testing.assert_allclose(
        data.nominal, [3e3, 4.5e3, 6e3, 3e3, 4.5e3, 6e3, 3e3, 4.5e3], rtol=5e-3
    )
    assert sorted(set(np.round(np.asarray(data.pressure), 6))) == [2.5, 3.0]
    kappas = np.repeat([-0.1, -0.01, 0.01, 0.1], 2)
    np.testing.assert_allclose(runs.facts["kappa"], kappas)
    for i, kappa in enumerate(kappas):
        table = checks._probe_table(i, kappa, 1 + i % 2)
        get, x = table.columns, table.columns["plank_position"]
        assert (table.info.start, table.info.run_index) == (1 + i % 2, i)
        assert x[0] == x[20] == 0.0 and x[-1] == pytest.approx(0.085 * (49.95 - 1.0))
        after, late = np.maximum(x - 0.7, 0.0), x > 2.5
        # it rolls freely up to the step but for 1.5 mm, and slips by kappa after it
        slip = 0.31 * get["wheel_angle"] - np.maximum(x - 0.0015, 0.0)
        np.testing.assert_allclose(slip, kappa * after, atol=1e-9)
        wanted = 3000.0 * np.tanh(20.0 * kappa) * -np.expm1(-after / 0.3) - 100.0 * (x > 0.01)
        others = {
            "fy": -600.0 * -np.expm1(-x / 0.4),
            "fz": (3e3, 4.5e3, 6e3)[i % 3] + 20.0 * np.sin(2.0 * np.pi * x / 0.4),
            "mx": 10.0 * np.sin(x), "mz": 20.0 * np.cos(x), "fx": wanted,
        }  # fmt: skip
        for name, form in others.items():
            rest = get[name] - form
            assert np.std(rest) == pytest.approx(5.0, rel=0.1), name
            assert abs(rest[late].mean()) < 0.8, name
        assert not np.allclose(get["fx"] - wanted, get["fy"] - others["fy"])


PLAIN = {
    "identifier": "plain_one", "title": "t", "kind": "machine", "coordinate": "time",
    "source": "s", "what": "w", "check": "c", "removes": "r",
}  # fmt: skip


def effect_of(size=None, hook=None, more=(), **texts):
    """An effect that keeps the contract but for this."""
    size = size or param(0.0, unit="N", bounds=(-9.0, 9.0), screen=1.0, matters=0.5)
    fields = [("force", float, size), *more]
    made = make_dataclass("Plain", fields, bases=(TireEffect,), frozen=True,
                          namespace=dict(PLAIN) | texts)  # fmt: skip

    def act(self, signal):
        signal.fx = signal.fx + self.force

    made.signal = hook or act
    return made


def number(**changes) -> object:
    return param(**dict(null=0.0, unit="N", bounds=(-9.0, 9.0), screen=1.0, matters=0.5) | changes)


def breaks_at_eight(self, signal):
    signal.fx = signal.fx + np.where(self.force > 8.0, np.nan, self.force)


@pytest.mark.parametrize(
    ("effect", "fault"),
    [
        *[({name: " "}, f"'{name}' is missing") for name in checks.TEXTS if name != "coordinate"],
        ({"kind": "magic"}, "kind 'magic' is not one of machine, sensor, tire"),
        ({"identifier": "Plain"}, "identifier: small letters"),
        ({"identifier": "pl-ain"}, "identifier: small letters"),
        ({"identifier": "wear"}, "identifier: 'wear' is an effect of the library already"),
        ({"coordinate": "nowhere"}, "coordinate 'nowhere' is not one of"),
        ({"size": number(screen=0.0)}, "no parameter has a screening step"),
        ({"size": number(unit="")}, "force: no unit"),
        ({"size": number(null=10.0)}, "force: the null 10 is outside of -9 .. 9"),
        ({"size": number(screen=9.5)}, "force: the screening step leaves the range"),
        ({"size": number(matters=0.0)}, "force: no size that matters"),
        ({"variants": classmethod(lambda cls, r, e: [])}, "variants() gave nothing"),
        ({"held": classmethod(lambda cls: ("gone",))}, "held() names 'gone'"),
        ({"size": number(), "starts": classmethod(lambda cls: ())}, "starts() gave nothing"),
        ({"scanned": classmethod(lambda cls, r: 0)}, "scanned() is below 1"),
        ({"more": [("idle", float, number())]}, "idle: nothing changes at the screening step"),
        ({"hook": breaks_at_eight}, "gives NaN or infinity at force = 9"),
        ({}, None),
    ],
)  # fmt: skip
def test_every_fault_of_the_contract_is_told(effect, fault):
    told = checks.check_effect(effect_of(**effect))
    assert (told == []) if fault is None else told and told[0].startswith(fault), told


def test_the_size_of_an_effect_must_be_a_number():
    made = effect_of()
    made.size = classmethod(lambda cls, values: np.nan)
    assert checks.check_effect(made) == ["size() is not finite at the null"]


def test_columns_that_an_effect_has_seen_go_through_their_range():
    made = effect_of(ranges={"oil": (20.0, 40.0)}, coordinate="oil")
    assert checks.check_effect(made) == []
    seen = checks.probe_of(made).data.further["oil"].values
    assert seen.shape == checks.probe_model().data.position.shape
    assert (seen[:, 0] == 20.0).all() and (seen[:, -1] == 40.0).all()
    assert checks.probe_of(effect_of()) is checks.probe_model()


def test_plug_ins_and_names_of_the_library(monkeypatch, tmp_path):
    point = SimpleNamespace(name="p", load=lambda: library()["wear"])
    assert registry._from_entry(point) == [library()["wear"]]

    def broken():
        raise ImportError("gone")

    with pytest.raises(FlatplankError, match="cannot be loaded"):
        registry._from_entry(SimpleNamespace(name="p", load=broken))
    with pytest.raises(FlatplankError, match="flatplank effects lists them"):
        registry.find("qqqqqqqqqq")
    assert registry.find("wear") is library()["wear"]
    assert registry.source_file(library()["wear"]) == ""
    assert list(library()) == sorted(library())
    text = tmp_path / "mine.txt"
    text.write_text("x = 1")
    with pytest.raises(FlatplankError, match="is not a Python file"):
        registry.load_file(text)
    own = tmp_path / "mine.py"
    own.write_text(
        "from dataclasses import dataclass\n"
        "from flatplank_analysis.discovery.parameters import param\n"
        "from flatplank_analysis.effects.base import TireEffect\n"
        "@dataclass(frozen=True)\nclass Mine(TireEffect):\n    identifier = 'wear'\n"
        "    a: float = param(0.0, unit='1', bounds=(0.0, 1.0), screen=0.1)\n"
    )
    with pytest.raises(FlatplankError, match="is taken by flatplank_analysis.effects.road"):
        library([own])
    own.write_text(own.read_text().replace("'wear'", "'my_own'"))
    assert library([own, tmp_path / "." / "mine.py"])["my_own"].identifier == "my_own"
    broken_file = tmp_path / "broken.py"
    broken_file.write_text("raise ValueError('no')")
    with pytest.raises(FlatplankError, match="ValueError: no"):
        checks.sound_library([broken_file])
    with pytest.raises(FlatplankError, match="'title' is missing"):
        checks.sound_library([own])


def test_the_probe_goes_through_the_same_reader_as_a_campaign():
    tables = [checks._probe_table(i, 0.01, 1) for i in range(2)]
    assert from_tables(tables).runs.runs == 2
