# SPDX-License-Identifier: Apache-2.0
"""Where a worn patch is looked for: places of the plank that a contact tells apart."""

import numpy as np
import pytest

from flatplank_analysis.discovery.runs import Coordinate, RunSet
from flatplank_analysis.effects.road import WornPatch


def runs_at(load: float) -> RunSet:
    place = np.linspace(0.0, 4.0, 200)[None]
    return RunSet(
        ("1",), np.zeros(1, int), ("one",), ("fx",), np.zeros((1, 1, 200)), place / 0.03,
        np.zeros(1), {"plank position": Coordinate(place, "m")},
        facts={"nominal": np.array([load])},
    )  # fmt: skip


@pytest.mark.parametrize(("load", "contact"), [(450.0, 0.0488), (3700.0, 0.14), (48e3, 0.504)])
def test_patches_are_looked_for_a_contact_apart(load, contact):
    """The step was 0.16 m for a bicycle as for an aircraft."""
    runs = runs_at(load)
    places = WornPatch.variants(runs, np.zeros((1, 1, 200)))
    assert np.diff([p["position"] for p in places]) == pytest.approx(contact, rel=2e-3)
    (width,) = {p["width"] for p in places}
    assert width == pytest.approx(1.5 * contact, rel=2e-3)
    assert WornPatch.scanned(runs) == round(4.2 / contact)
