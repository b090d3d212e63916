# SPDX-License-Identifier: Apache-2.0
"""The faults that are tests of their own: what breaks and what is seen of it, for a reader."""

from __future__ import annotations

from typing import NamedTuple


class Other(NamedTuple):
    """One fault outside the table of `ethercat_scenarios`."""

    test: str
    name: str
    cause: str
    signature: str
    when: str = "on a running bus"


_START = "at the start"
OTHERS = (
    Other("test_bus_process_killed", "bus process killed", "`kill -9` of the bus process",
          "images go on, invented, LOST; drive SAFEOP with error 0x001B"),
    Other("test_bus_process_frozen", "bus process frozen", "`kill -STOP`, later `kill -CONT`",
          "SLAVE_FAULT, `missed` grows"),
    Other("test_node_silent", "node sends no commands", "the node goes on reading only",
          "OK, held: STALE_COMMAND, error 0x8130"),
    Other("test_node_killed", "node killed", "`kill -9` of the node",
          "all slaves in INIT, no watchdog trip"),
    Other("test_emulator_killed_and_started_again", "all slaves gone",
          "`kill -9` of the emulator, a new one 0.4 s later", "LOST, 'no answer', held: BUS, "
          "recovery RECONFIGURE or RESCAN; the new shaft never turned"),
    Other("test_second_master_is_refused", "second master", "another master of ours is started",
          "it says 'in use by process N'; the running bus counts nothing"),
    Other("test_foreign_master_on_the_wire", "foreign master", "pysoem without our lock scans",
          "LOST, recovery RECONFIGURE or RESCAN; counted from the moment a slave leaves OP"),
    Other("test_link_down_on_the_near_side", "link down on the near side", "`ip link set down`",
          "LOST, 'the interface is down'; counted from the last frame"),
    Other("test_another_slave_in_the_place_of_one", "another slave in the place of one",
          "exchanged under power off", "'encoders_b', its identity in the reason; not OK until "
          "the right one is back"),
    Other("test_long_cut_ends_in_a_full_scan", "cable cut for long", "`cable_cut` for 350 cycles",
          "'missing from encoders_a on', recovery RESCAN"),
    Other("test_state_refused_until_allowed", "a slave refuses OP", "`al_refuse` and `al_drop`",
          "'bridges_a: SAFEOP with error 0x0020', not OK"),
    Other("test_operators_emergency_stop", "mushroom button", "the plant's operator presses it",
          "held: EMERGENCY_STOP; a reset while it is in does nothing"),
    Other("test_stopping_the_bus_stops_the_wheel_first", "bus ended in order", "`stop()`",
          "INIT, no watchdog trip, no drive fault"),
    Other("test_wrong_identity", "wrong identity", "another vendor in the EEPROM",
          "slave number, both identities", _START),
    Other("test_slaves_missing", "slaves missing", "5 or 8 of 9 there",
          "the first one that is missing", _START),
    Other("test_one_slave_too_many", "one slave too many", "9 there, 8 in the file",
          "its name", _START),
    Other("test_state_refused_at_start", "OP refused", "`al_refuse`", "slave and AL code", _START),
    Other("test_configuration_refused", "configuration refused", "`mailbox_abort`",
          "slave and object", _START),
    Other("test_pdos_differ_from_the_bus_file", "other process data", "one entry less in the file",
          "bytes of both", _START),
    Other("test_no_slaves", "no slaves", "nothing on the wire", "check the cable", _START),
    Other("test_no_such_interface", "no such interface", "a wrong name", "the names there are",
          _START),
    Other("test_interface_name_too_long", "name over 15 characters", "a long name",
          "at most 15 characters", _START),
    Other("test_no_permission", "no permission", "CAP_NET_RAW taken away", "the setcap command",
          _START),
)  # fmt: skip
