# SPDX-License-Identifier: Apache-2.0
"""What a user types while the bench answers stays."""

from __future__ import annotations

import pytest
from conftest import Clicker
from panel_rig import ACCEPTS, panel_process, wait_for

pytestmark = [pytest.mark.browser, pytest.mark.graph, pytest.mark.timeout(180)]
SLOW = """
import asyncio
from flatplank_panel.operator import Operator

answers = asyncio.Event()
operator_constants = {"et_value": 0.04, "adapter_thickness": 0.033}

async def constants(self):
    await asyncio.wait_for(answers.wait(), 60.0)
    return operator_constants

async def tare(self, page):
    answers.set()
    return self.say("answered")

Operator.constants, Operator.tare = constants, tare
"""
"""A bench that answers what its constants are when its zero is taken."""


def test_a_late_answer_does_not_overwrite_what_was_typed(chromium, domain, tmp_path):
    data = tmp_path / "data"
    data.mkdir()
    with panel_process(data, before=ACCEPTS + SLOW) as address:
        context = chromium.new_context(viewport={"width": 1440, "height": 900})
        who = Clicker(context.new_page(), address)
        who.take()
        who.tab("Set-up")
        who.click("Read from bench")
        who.fill("ET value [m]", 0.055)
        who.click("Take the zero")
        wait_for(
            lambda: float(who.field("Adapter [m]").input_value()) == 0.033, what="the bench answered"
        )
        assert float(who.field("ET value [m]").input_value()) == 0.055
        context.close()
