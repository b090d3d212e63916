# SPDX-License-Identifier: Apache-2.0
"""Which nodes a drive still waits for."""

import pytest

from flatplank_hw.nodes.partners import Partners


@pytest.fixture
def count() -> dict[str, int]:
    return {"hub": 0, "reference": 1}


@pytest.fixture
def partners(count) -> Partners:
    made = Partners()
    for kind in count:
        made.add(kind, lambda kind=kind: count[kind], each_cycle=kind == "hub")
    return made


def test_a_node_that_was_started_is_there_once_it_speaks(partners, count):
    assert partners.look() == set() and partners.silent == {"hub"}
    count["hub"] = 1
    assert partners.look() == set() and partners.silent == {"hub"}, "it may have missed the cycle"
    assert partners.heard("hub") and not partners.heard("hub")
    assert partners.silent == set(), "a reference is not sent in each cycle"


def test_a_node_that_has_left_is_there_once_it_speaks_again(partners, count):
    partners.look()
    count["reference"] = 0
    assert partners.look() == {"reference"} and "reference" in partners.silent
    count["reference"] = 1
    assert partners.look() == set() and "reference" in partners.silent
    assert partners.heard("reference") and "reference" not in partners.silent


def test_a_node_that_was_started_again_before_its_killed_one_left_is_not_lost(partners, count):
    """The graph counts a killed node for 20 s more."""
    count["hub"] = 1
    partners.heard("hub")
    for here, left in [(1, False), (2, False), (1, True), (1, False)]:
        count["hub"] = here
        assert (partners.look() == {"hub"}) == left
    assert partners.heard("hub") and partners.silent == set()
