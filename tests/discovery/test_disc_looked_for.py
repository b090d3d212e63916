# SPDX-License-Identifier: Apache-2.0
"""What effects are looked for in, and the waves that are looked for in the residual."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shapes import measured

from flatplank_analysis.contact_patch.data import roughness_of
from flatplank_analysis.discovery.runs import Coordinate
from flatplank_analysis.effects.plank_waves import periods, spectrum
from flatplank_analysis.effects.registry import library
from flatplank_analysis.effects.wheel_angle import wave


def test_a_torn_weld_is_looked_for_where_the_runs_drive():
    """A crack holds a share of the largest driving force; runs that brake show none."""
    effect, runs = library()["torn_weld"], measured(0).runs
    most = runs.measured[0].max()
    holds = [v["hold"] for v in effect.variants(runs, runs.measured)]
    assert len(holds) == effect.scanned(runs) and 0.0 < min(holds) < max(holds) < most
    assert effect.separable(runs)
    assert not effect.separable(replace(runs, measured=-abs(runs.measured)))


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

    whole = [0.21 + 0.14 * i for i in range(28)]
    # the first 0.3 m are the start of all runs, unless some of them slip there already
    every = whole[1:]
    assert places() == pytest.approx(every)
    assert places(step=np.linspace(0.1, 2.0, 24)) == pytest.approx(whole)
    assert [v["width"] for v in patch(runs, runs.measured)] == pytest.approx([0.21] * len(every))
    free = [p for p in every if p < 1.9 or p > 2.2]
    assert places(step=np.full(24, 2.0)) == pytest.approx(free)
    assert places(step=np.linspace(2.0, 2.1, 24)) == pytest.approx(every)
    assert places(step=np.full(24, np.nan)) == pytest.approx(every)
    # with side slip, all runs have the transient of the side force at their start, too
    turned = dict(step=np.full(24, 2.0), alpha=np.repeat([0.0, 0.09], 12))
    assert places(**turned) == pytest.approx([p for p in free if p > 0.6])
    at = {"position": 0.4, "width": 0.2}
    assert known["worn_patch"].separable(runs, at)
    assert not known["worn_patch"].separable(runs, at | {"position": 0.15})
    assert not known["worn_patch"].separable(placed(np.zeros((24, 400)), **turned), at)
    # a creep within a relaxation length is the transient, unless the speed changes
    creep = known["carcass_creep"].separable
    for speed, told in ((np.full(24, 0.03), False), (np.repeat([0.03, 0.0015], 12), True)):
        crept = placed(np.zeros((24, 400)), speed=speed)
        assert creep(crept, {"share": 0.05, "time": 2.2}) is told
        assert creep(crept, {"share": 0.05, "time": 8.0}) and creep(crept)
    # a ripple that all runs show at the same place
    place = runs.coordinates["plank position"].values
    rough = np.cumsum(np.random.default_rng(1).standard_normal(400)) * 0.01
    hum = np.cos(2.0 * np.pi * place / 0.2)[None] + rough + 0.0 * runs.measured
    assert known["mesh_ripple"].variants(runs, hum)[0]["period"] == pytest.approx(0.2, rel=0.02)
    fy = known["crosstalk_fy"].variants
    assert fy(replace(runs, measured=runs.measured + 101.0), None) == [{"tared": 1.0}]
    assert fy(replace(runs, measured=runs.measured + 99.0), None) == []
    assert fy(placed(np.zeros((24, 400)), ("fx",)), None) == []
    assert known["load_loss_braking"].variants(runs, None) == [{"seen": 1.0}, {"seen": 0.0}]


@pytest.mark.parametrize("size", [0.35, 1.0, 3.0])
def test_lengths_and_forces_of_the_limits_are_those_of_the_tire(size):
    """A tire with `size` times the contact length carries the square of that load."""
    known, load = library(), 3700.0 * size**2
    zero, facts = np.zeros((24, 400)), {"nominal": np.full(24, load)}
    stepped = placed(zero, step=np.full(24, 2.0), **facts)
    for near, told in ((-0.11, True), (-0.09, False), (0.19, False), (0.21, True)):
        at = {"position": 2.0 + near * size, "width": 0.2}
        assert known["worn_patch"].separable(stepped, at) is told
    crept = placed(zero, speed=np.full(24, 0.03), **facts)
    for travel, told in ((0.09, False), (0.11, True)):
        assert known["carcass_creep"].separable(crept, {"time": travel * size / 0.03}) is told
    side = replace(stepped, measured=stepped.measured + 0.026 * load)
    assert known["crosstalk_fy"].variants(side, None) == []
    side = replace(stepped, measured=stepped.measured + 0.028 * load)
    assert known["crosstalk_fy"].variants(side, None) == [{"tared": 1.0}]
    place = np.array([[0.079, 0.081]]) * size
    assert list(roughness_of(place, load)[0]) == [2.5, 1.0]


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


def test_a_load_that_undulates_is_looked_for_where_driving_and_braking_differ_in_sign():
    """In the mean over all runs driving and braking cancel; a force of the machine, the same in
    every run, is left, and hid the period."""
    x = np.linspace(0.0, 4.0, 900)
    drawn = np.random.default_rng(5)
    force = np.tile([1500.0, -1500.0, 3000.0, -3000.0], 6)[:, None]
    wave_ = 0.01 * np.sin(2.0 * np.pi * x / 0.44 + 1.0)
    same = 15.0 * np.sin(2.0 * np.pi * x / 1.9) + drawn.standard_normal((24, 900))
    runs = placed(force * (1.0 + wave_) + same)
    settings = library()["load_undulation"].variants(runs, (force * wave_ + same)[None])
    found = [setting["period"] for setting in settings]
    assert found[0] == pytest.approx(0.44, rel=0.02) and found[-3:] == [0.35, 0.7, 1.4]


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
