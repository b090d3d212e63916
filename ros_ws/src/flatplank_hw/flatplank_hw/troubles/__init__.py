# SPDX-License-Identifier: Apache-2.0
"""Everything that can go wrong on the bench, by name: the log, /diagnostics, the messages and
docs/troubles.md say what is written here."""

from flatplank_hw.troubles.bus import BUS
from flatplank_hw.troubles.drive import DRIVE
from flatplank_hw.troubles.measuring import MEASURING
from flatplank_hw.troubles.nodes import NODES
from flatplank_hw.troubles.trouble import Level, Trouble, table

SECTIONS = {
    "The drives": DRIVE,
    "The bus": BUS,
    "Measuring and recording": MEASURING,
    "Nodes and calls": NODES,
}
"""title -> troubles, as docs/troubles.md has them"""

TROUBLES = table(*(trouble for section in SECTIONS.values() for trouble in section.values()))

__all__ = ["SECTIONS", "TROUBLES", "Level", "Trouble"]
