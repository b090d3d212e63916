# SPDX-License-Identifier: Apache-2.0
"""Every requirement is met by the panel, and by no panel that only says so."""

from __future__ import annotations

import panel_rig
import pytest
from requirement_checks import CHECKS

pytestmark = [pytest.mark.browser, pytest.mark.graph]
SHORT = {"hands": 0.05, "eyes": 0.4}
"""what is waited for as long as this part of the usual time; a bench with hands still moves"""


@pytest.mark.parametrize("name", CHECKS)
def test_requirement(name, request, observer, data):
    check = CHECKS[name]
    check.run(request.getfixturevalue(check.fixture), observer, data)


@pytest.mark.long
@pytest.mark.usefixtures("operator")
@pytest.mark.parametrize("name", CHECKS)
def test_requirement_is_not_met_by_a_panel_that_accepts_and_does_nothing(
    name, idle, observer, data, monkeypatch
):
    check = CHECKS[name]
    who = idle(check.stub)
    monkeypatch.setattr(panel_rig, "SHARE", SHORT[check.stub])
    with pytest.raises(AssertionError, match="not within"):  # a wait for the effect
        check.run(who, observer, data)
