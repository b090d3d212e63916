# SPDX-License-Identifier: Apache-2.0
"""What a user types while the bench answers stays."""

from __future__ import annotations

import pytest
from panel_rig import wait_for

pytestmark = [pytest.mark.browser, pytest.mark.graph]


def test_a_late_answer_does_not_overwrite_what_was_typed(idle):
    who = idle("hands and answers")
    who.tab("Set-up")
    who.click("Read from bench")
    who.fill("ET value [m]", 0.055)
    who.click("Take the zero")

    def value(label: str) -> float:
        return float(who.field(label).input_value())

    wait_for(lambda: value("Adapter [m]") == 0.033, what="the bench has answered")
    assert value("ET value [m]") == 0.055
