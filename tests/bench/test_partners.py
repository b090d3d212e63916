# SPDX-License-Identifier: Apache-2.0
"""Which nodes a drive still waits for."""

from flatplank_hw.nodes.partners import Partners


def test_a_node_that_was_started_again_is_there_once_it_speaks():
    count = {"hub": 0, "reference": 1}
    partners = Partners()
    for kind in count:
        partners.add(kind, lambda kind=kind: count[kind])
    assert partners.gone() == set() == partners.silent, "what has not come yet is not gone"
    count["hub"] = 1
    assert partners.gone() == set() and not partners.heard("hub")
    count["reference"] = 0
    assert partners.gone() == {"reference"} == partners.silent
    count["reference"] = 1
    assert partners.gone() == set() and partners.silent == {"reference"}
    assert partners.heard("reference") and not partners.heard("reference")
    assert partners.silent == set()


def test_a_late_sample_of_a_node_that_has_gone_does_not_bring_it_back():
    count = {"hub": 1}
    partners = Partners()
    partners.add("hub", lambda: count["hub"])
    partners.gone()
    count["hub"] = 0
    partners.gone()
    assert partners.heard("hub")
    assert partners.gone() == {"hub"} == partners.silent
