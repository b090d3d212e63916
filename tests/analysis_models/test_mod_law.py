# SPDX-License-Identifier: Apache-2.0
"""Steady laws of the contact patch."""

from __future__ import annotations

import numpy as np
import pytest
from mod_laws import SLIPS, law

from flatplank_analysis.models import nonlinear as nl
from flatplank_analysis.models.nonlinear import TableLaw, table_law
from flatplank_data.errors import FlatplankError


@pytest.mark.parametrize("force", [-2500.0, -40.0, 0.0, 1500.0])
def test_the_slip_that_gives_the_start_force(force):
    slip = nl.start_slip(law(), np.array([[force]]))
    assert law().force(slip)[0] == pytest.approx(force, abs=1e-6)
    assert abs(slip.item()) < 0.08
    # beyond the peak there is none: the search ends inside of the table's reach
    assert abs(nl.start_slip(law(), np.array([[9e9]])).item()) <= 0.2


def test_a_table_of_a_law():
    one = law()
    inner = np.array([[-0.1234, 0.0, 0.0321]])
    wanted = 3700.0 * np.sin(1.4 * np.arctan(9e4 / 1.4 / 3700.0 * inner))
    found, slope = one.force(inner)
    np.testing.assert_allclose(found, wanted, atol=1.5)
    numeric = (one.force(inner + 1e-4)[0] - one.force(inner - 1e-4)[0]) / 2e-4
    np.testing.assert_allclose(slope, numeric, rtol=0.02, atol=200.0)
    # straight beyond its ends
    ends = one.force(np.array([[0.15, 0.16, 0.17]]))[0][0]
    assert ends[2] - ends[1] == pytest.approx(ends[1] - ends[0])
    assert one.force(np.array([[-0.16]]))[0] == pytest.approx(
        2.0 * one.force(np.array([[-0.15]]))[0] - one.force(np.array([[-0.14]]))[0], rel=0.01
    )
    assert one.stiffness().item() == pytest.approx(
        (one.force(np.array([[0.005]]))[0] - one.force(np.array([[-0.005]]))[0]).item() / 0.01
    )
    sets = table_law(SLIPS, np.vstack([one.force(SLIPS[None])[0][0]] * 2) * [[1.0], [3.0]])
    found = sets.force(np.full((2, 1), 0.02))[0][:, 0]
    assert found[1] == pytest.approx(3.0 * found[0])
    assert sets.stiffness()[:, 0] == pytest.approx([1.0, 3.0] * one.stiffness()[0], rel=1e-3)
    rows = TableLaw(one.first, one.step, np.vstack([one.values, 2.0 * one.values]))
    both = rows.force(np.array([[0.02, 0.03]]))[0][0]
    assert both == pytest.approx([1.0, 2.0] * one.force(np.array([[0.02, 0.03]]))[0][0])
    for bad in ([0.0], [0.0, 0.0], [0.1, 0.0]):
        with pytest.raises(FlatplankError, match="increasing slips"):
            table_law(np.array(bad), np.zeros(len(bad)))


@pytest.mark.parametrize("shape", [(1,), (3,), (1, 1), (2, 1), (2, 3)])
def test_every_lane_and_run_has_its_own_table(shape):
    """Values (runs or 1, nodes) or (sets, runs or 1, nodes): each looked up alone."""
    rng = np.random.default_rng(1)
    values = rng.normal(size=(*shape, 9))
    one, slip = TableLaw(-0.04, 0.01, values), rng.uniform(-0.06, 0.06, (2, 3))
    full = np.broadcast_to(values if len(shape) == 2 else values[None], (2, 3, 9))
    nodes = -0.04 + 0.01 * np.arange(9)
    force, slope = one.force(slip)
    for index in range(2):
        for run in range(3):
            row, at = full[index, run], slip[index, run]
            cell = min(max(int((at + 0.04) // 0.01), 0), 7)
            rise = (row[cell + 1] - row[cell]) / 0.01
            assert slope[index, run] == pytest.approx(rise)
            assert force[index, run] == pytest.approx(row[cell] + rise * (at - nodes[cell]))
    ends = [np.array([[np.interp(s, nodes, row) for row in rows] for rows in full])
            for s in (0.005, -0.005)]  # fmt: skip
    np.testing.assert_allclose(np.broadcast_to(one.stiffness(), (2, 3)),
                               (ends[0] - ends[1]) / 0.01)  # fmt: skip


def test_a_table_goes_through_its_points_without_overshoot():
    slips, forces = np.array([-0.1, -0.02, 0.0, 0.03, 0.15]), np.array([-9.0, -9.0, 1.0, 8.0, 7.0])
    one = table_law(slips, forces)
    assert one.values.shape == (1, 2001) and one.first == -0.1
    assert one.first + 2000 * one.step == pytest.approx(0.15)
    np.testing.assert_allclose(one.force(slips[None])[0][0], forces, atol=1e-3)
    assert one.values.min() >= -9.0 and one.values.max() <= 8.0
    two = table_law(slips, np.vstack([forces, 2.0 * forces]))
    assert two.values.shape == (2, 1, 2001)
    np.testing.assert_allclose(two.values[1], 2.0 * two.values[0])
    for bad in ([0.0, 0.1, 0.1], [0.1, 0.0, 0.2]):
        with pytest.raises(FlatplankError, match="increasing slips"):
            table_law(np.array(bad), np.zeros(3))


def test_the_start_slip_is_sought_in_steps_of_two_percent_up_to_twenty():
    """Of a law without a slope it goes nowhere near infinity."""
    flat = TableLaw(-1.0, 0.5, np.zeros((1, 5)))
    assert np.abs(nl.start_slip(flat, np.array([[5.0, -5.0]]))) == pytest.approx(0.2)
    rising = TableLaw(-1.0, 0.5, 1e4 * np.linspace(-1.0, 1.0, 5)[None])
    np.testing.assert_allclose(nl.start_slip(rising, np.array([[300.0, -1900.0, 9e3]])),
                               [[0.03, -0.19, 0.2]])  # fmt: skip
