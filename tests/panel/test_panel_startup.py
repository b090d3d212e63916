# SPDX-License-Identifier: Apache-2.0
"""Start-up in steps: the first that is not done is told with its button."""

from __future__ import annotations

import pytest
from own_loop import finished
from panel_samples import samples
from test_panel_operator import Answers

from flatplank_panel.host import Host
from flatplank_panel.operator import Operator
from flatplank_panel.startup import next_of, steps
from flatplank_panel.views.startup import READY

WALK = {
    "charge": {},
    "bench": {},
    "health": {"cycle": "1", "health": "slave fault", "estop": "PRESSED", "state": "fault"},
    "estop": {"health": "ok"},
    "zero": {"estop": "released"},
    "enable": {},
    "": {"state": "operation enabled"},
}
"""step that is to be made -> words of the bench that are new"""


def test_each_step_comes_when_those_before_it_are_done():
    words: dict[str, str] = {}
    for number, (name, told) in enumerate(WALK.items()):
        words |= told
        now = steps(number > 0, words, number > list(WALK).index("zero"))
        assert next_of(now) == name
    stopped = steps(True, words | {"estop": "PRESSED"}, True)
    assert next_of(stopped) == "estop"


def test_a_zero_is_that_of_the_bus_that_runs(tmp_path):
    link = Answers()
    operator = Operator(link, Host(tmp_path, tmp_path / "log"), tmp_path)
    operator.take_charge("a", "page a")
    link.state.accept(samples(1), 0.0)
    assert not link.state.zero_taken
    finished(operator.tare("a"))
    assert link.state.zero_taken
    link.state.accept(samples(2), 0.1)
    assert link.state.zero_taken
    link.state.accept(samples(1), 0.2)  # the bus was started again
    assert not link.state.zero_taken


@pytest.mark.browser
@pytest.mark.graph
def test_a_bench_is_started_step_by_step(operator, observer):
    """The fixture has taken charge of a running bench at rest."""
    operator.tab("Machine")
    if operator.button("Release it").is_visible():
        operator.click("Release it")
    zero = operator.button("Take it")
    if zero.is_visible():
        zero.click()
    operator.click("Enable it")
    operator.page.get_by_text(READY).wait_for()
    observer.wait(observer.enabled, 60.0, "operation enabled at the drive")
    operator.tab("Drive")
    operator.click("Disable")
    operator.tab("Machine")
    operator.button("Enable it").wait_for()
