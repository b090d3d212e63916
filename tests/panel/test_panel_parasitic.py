# SPDX-License-Identifier: Apache-2.0
"""R1.XI with the run itself: the filter of a mounting, identified and loaded by mouse."""

from __future__ import annotations

import re

import pytest
import yaml

from flatplank_control.bench.setup import BenchSetup
from flatplank_control.runner.measurement import Measurement
from flatplank_control.runner.plans import plan_of
from flatplank_sim.twin.log import BagLog
from flatplank_sim.twin.twin import Twin
from flatplank_sim.twin.twin_bench import TwinBench

pytestmark = [pytest.mark.browser, pytest.mark.graph]


def test_the_filter_is_identified_from_a_run(operator, observer, data):
    """The run itself takes three minutes at the machine; here the twin has made it."""
    setup = BenchSetup(preset="thesis2023", pace="hold")
    (data / "mounting").mkdir()
    log = BagLog(data / "mounting")
    TwinBench(Twin(setup), log).perform(plan_of(Measurement(measurement="unloaded_turn")))
    operator.tab("Measure")
    operator.choose("Measurement", "three unloaded turns")
    operator.choose("Measurement", "slip step")
    operator.tab("Set-up")
    operator.page.get_by_role("button", name="Look for fits again").click()
    operator.page.get_by_label("Run of three unloaded turns", exact=True).click()
    operator.page.get_by_role("option").filter(has_text="mounting/TOY").first.click()
    operator.fill("Mounting", "../m")
    operator.click("Identify from the run")
    operator.said("not a name")
    operator.fill("Mounting", "m7")
    operator.click("Identify from the run")
    said = operator.page.get_by_text("Once per turn, before and after")
    said.wait_for(timeout=60_000)
    before, after = (float(w) for w in re.findall(r"[\d.]+(?= to| N)", said.text_content())[:2])
    assert before > 200.0 and after < 5.0
    operator.said("parasitic fit parasitic_m7_")
    fit = next((data / "parasitic").glob("parasitic_m7_*.yaml"))
    assert yaml.safe_load(fit.read_text())["mounting"] == "m7"
    operator.click("Filter on")
    observer.wait(lambda: observer.latest["hub"].filter_on, what="the hub filters")
    operator.click("Filter off")
    observer.wait(lambda: not observer.latest["hub"].filter_on, what="the filter is off")
