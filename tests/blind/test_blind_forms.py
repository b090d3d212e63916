# SPDX-License-Identifier: Apache-2.0
"""The machine of other forms: what its sizes mean, and that its forms are others indeed."""

from __future__ import annotations

import numpy as np
import pytest

from flatplank_sim.sealed.conditions import Run, Setting
from flatplank_validation.blind.forms import MENU_OF_FORMS, FormsMachine, measure
from flatplank_validation.blind.menu import MENU
from flatplank_validation.blind.plan import runs_of
from flatplank_validation.blind.second import SecondTire
from flatplank_validation.blind.worlds import WORLDS, Scatter

PLACES = np.arange(0.05, 4.1, 0.01)
CALM = np.zeros(4)
AROUND = ("crosstalk_fz",)
"""what needs a load that waves, without a fault, too"""


def one(kappa=0.02, index=0, count=27, **machine):
    run = Run(Setting(kappa), 1, index)
    return measure(SecondTire(), FormsMachine(**machine), run, count, 1.0, 0.1, CALM)


def campaign(world, sizes, design):
    made = WORLDS[world](None)
    runs = runs_of(design, np.random.default_rng(5))
    out = made.run(runs, sizes, np.random.default_rng(1), Scatter.none(len(runs)))
    rows = [
        [np.interp(PLACES, c["plank_position"], c[n]) for n in ("fx", "fy", "fz")] for c in out
    ]
    return np.array(rows)


@pytest.mark.parametrize("name", sorted(set(MENU_OF_FORMS) - set(AROUND)))
def test_at_size_zero_nothing_is_wrong(name):
    plain, none = campaign("forms", {}, "small"), campaign("forms", {name: 0.0}, "small")
    np.testing.assert_allclose(plain, none, atol=1e-9)


def other_share(name):
    """Share of an effect that no size of the other machine's can imitate."""
    item, changes = MENU[name], []
    for world in ("forms", "second"):
        plain = campaign(world, {name: 0.0}, item.design)
        change = campaign(world, {name: item.typical}, item.design) - plain
        # a constant pull tells nothing of a form
        changes.append((change - change.mean(axis=(0, 2), keepdims=True)).ravel())
    a, b = changes
    return 1.0 - (a @ b) ** 2 / ((a @ a) * (b @ b))


@pytest.mark.parametrize(
    "name",
    [
        "road_play", "drive_backlash", "rack_backlash", "support_play_y", "support_play_z",
        "load_loss_braking", "carcass_softening", "carcass_creep",
        "wear", "parasitic_force", "nonuniformity_1", "runout_1", "zero_drift", "worn_patch",
        "crosstalk_fx_fy", "crosstalk_fz",
    ],
)  # fmt: skip
def test_the_form_is_another(name):
    """The rest is alike at these sizes whatever its form: short lags, a delay, two pressures."""
    assert other_share(name) > 0.01


def test_crosstalk_bends_only_when_it_is_large():
    for force, share in ((200.0, 1.0), (3000.0, 0.9)):
        mixed = one(0.1, mix={("fx", "fy"): 0.1})
        at = np.argmin(np.abs(mixed["fx"] - force))
        told = (mixed["fy"][at] - one(0.1)["fy"][at]) / (0.1 * mixed["fx"][at])
        assert told == pytest.approx(1.0, abs=0.01) if share == 1.0 else told < share


def test_a_gap_is_the_way_from_stop_to_stop():
    """Between driving and braking the same force comes later by the gap, in travel of the slip."""
    gap, late = 1e-3, 0.0
    for kappa in (0.05, -0.05):
        plain, loose = one(kappa), one(kappa, kernel={"road_gap": gap})
        for level in (1500.0, 2000.0):
            places = [
                np.interp(level, np.sign(kappa) * c["fx"][960:1400], c["plank_position"][960:1400])
                for c in (plain, loose)
                if np.all(np.isfinite(c["fx"]))
            ]
            late += (places[1] - places[0]) * abs(kappa) / 2.0
    assert late == pytest.approx(gap, rel=0.2)


def test_drifts_wear_and_lag_come_to_their_size():
    drift = one(drift=0.5)["fx"] - one()["fx"]
    time = one()["time"]
    assert drift[-1] == pytest.approx(0.5 * time[-1]) and drift[len(drift) // 2] > 0.6 * drift[-1]
    first, last = (one(index=i, drift_runs=60.0)["fx"][0] for i in (0, 26))
    assert last - first == pytest.approx(60.0)
    grip = [one(0.1, index=i, wear=0.2)["fx"][-100:].mean() for i in (0, 9, 26)]
    assert grip[2] / grip[0] == pytest.approx(0.8, abs=0.03)
    assert (grip[0] - grip[1]) / (grip[0] - grip[2]) > 0.6
    plain, late = one(0.02), one(0.02, lag=0.4)
    rise = slice(1050, 1200)
    shift = np.sum(plain["fx"][rise] - late["fx"][rise]) * 0.05
    assert shift == pytest.approx(0.4 * np.ptp(plain["fx"][rise]), rel=0.1)
