# SPDX-License-Identifier: Apache-2.0
"""Are these the slaves of the bus file, in its order?"""

from __future__ import annotations

from collections.abc import Sequence

from flatplank_hw.ethercat.busfile import BusFile
from flatplank_hw.ethercat.master.errors import BusError

Found = tuple[str, int, int, int]
"""name, vendor, product, revision"""


def check_identities(bus: BusFile, found: Sequence[Found], interface: str) -> None:
    """Refuse a bus that is not the one of the file, and say where it differs first."""
    if not found:
        raise BusError(
            f"no slaves on '{interface}'; check the cable, the power of the slaves,"
            " and that the interface is the right one and up"
        )
    for position, (spec, seen) in enumerate(zip(bus.slaves, found, strict=False), 1):
        name, vendor, product, revision = seen
        same = (vendor, product) == (spec.vendor, spec.product)
        if same and (not spec.check_revision or revision == spec.revision):
            continue
        raise BusError(
            f"slave {position} on '{interface}' is '{name}' (vendor 0x{vendor:08X}, product"
            f" 0x{product:08X}, revision 0x{revision:08X}), the bus file has '{spec.name}'"
            f" (0x{spec.vendor:08X}, 0x{spec.product:08X}, 0x{spec.revision:08X}); check the"
            " wiring, or take the slave's identity from its maker's ESI file"
        )
    if len(found) < len(bus.slaves):
        missing = ", ".join(s.name for s in bus.slaves[len(found) :])
        raise BusError(
            f"{len(found)} of {len(bus.slaves)} slaves on '{interface}', missing from"
            f" '{bus.slaves[len(found)].name}' on ({missing}); check cable and power there"
        )
    if len(found) > len(bus.slaves):
        extra = ", ".join(f"'{name}'" for name, *_ in found[len(bus.slaves) :])
        raise BusError(
            f"{len(found)} slaves on '{interface}', the bus file has {len(bus.slaves)};"
            f" unknown: {extra}; add them to the bus file"
        )
