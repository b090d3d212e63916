# SPDX-License-Identifier: Apache-2.0
"""An axis has one commander: which commands the owner of the bus takes."""

from flatplank_hw.bus.commanders import QUIET_NS, CommandGate

MS = 1_000_000


def gate_at(stamp_ns: int) -> CommandGate:
    gate = CommandGate()
    gate.send(stamp_ns)
    return gate


def test_the_first_answer_to_each_message_is_taken():
    gate = gate_at(0)
    for stamp in (0, 4 * MS, 8 * MS):
        gate.send(stamp)
        assert gate.accept(0, stamp) and gate.accept(3, stamp)
    assert gate.take_refused() == {} and not gate.contested(0)


def test_a_command_that_answers_nothing_is_refused():
    """As `ros2 topic pub` sends it: without a stamp, or with that of the wall clock."""
    gate = gate_at(8 * MS)
    assert gate.accept(0, 8 * MS)
    assert not gate.accept(0, 0) and not gate.accept(0, 10**18)
    assert gate.take_refused() == {0: 2} and gate.take_refused() == {}
    gate.send(12 * MS)
    assert gate.accept(0, 12 * MS) and not gate.contested(0)


def test_two_nodes_elsewhere_contest_an_axis_until_one_has_been_quiet():
    gate = gate_at(4 * MS)
    assert gate.accept(0, 4 * MS) and not gate.accept(0, 4 * MS)
    assert gate.contested(0) and not gate.contested(1)
    gate.send(4 * MS + QUIET_NS)
    assert gate.accept(0, 4 * MS + QUIET_NS) and gate.contested(0)
    gate.send(8 * MS + QUIET_NS)
    assert not gate.contested(0)


def test_a_node_that_answers_late_contests_an_axis_too():
    """It was refused only, and the other one went on, where it was a message behind."""
    gate = gate_at(4 * MS)
    assert gate.accept(0, 4 * MS)
    gate.send(8 * MS)
    assert gate.accept(0, 8 * MS) and not gate.accept(0, 4 * MS)
    assert gate.contested(0)
    gate.send(4 * MS + QUIET_NS)
    assert gate.accept(0, 4 * MS + QUIET_NS)
    gate.send(12 * MS + QUIET_NS)
    assert not gate.contested(0) and not gate.accept(0, 8 * MS)
    assert gate.contested(0), "however late: a node on a busy computer commands, too"


def test_a_clock_that_jumps_back_leaves_no_stamps_behind():
    gate = gate_at(60 * QUIET_NS)
    assert gate.accept(0, 60 * QUIET_NS) and not gate.accept(0, 60 * QUIET_NS)
    gate.send(4 * MS)
    assert not gate.accept(0, 60 * QUIET_NS) and not gate.contested(0)
    assert gate.accept(0, 4 * MS), "the first answer of the new clock"


def test_the_node_of_this_process_prevails_whoever_is_first():
    gate = gate_at(0)
    assert gate.accept(0, 0, inside=True)
    gate.send(4 * MS)
    assert not gate.accept(0, 4 * MS)
    assert gate.accept(0, 4 * MS, inside=True)
    assert gate.take_refused() == {0: 1} and not gate.contested(0)
