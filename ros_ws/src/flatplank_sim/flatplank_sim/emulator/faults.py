# SPDX-License-Identifier: Apache-2.0
"""The faults of the control socket, and how to undo each.

A fault is a function of the rig; it returns a function that undoes it, or None when it ends by
itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from flatplank_data.params import nearest
from flatplank_hw.bus.image import AXES
from flatplank_hw.ethercat import busfile
from flatplank_sim.emulator.al import State
from flatplank_sim.emulator.bench import EmulatedBench
from flatplank_sim.emulator.drive_firmware import DriveFirmware
from flatplank_sim.emulator.mailbox import Mailbox
from flatplank_sim.emulator.sii import build_sii
from flatplank_sim.emulator.slave import EmulatedSlave
from flatplank_sim.emulator.wire import Wire

Undo = Callable[[], object]


@dataclass
class FaultTargets:
    """Parts of the emulated bench in which faults can be injected."""

    bench: EmulatedBench
    wire: Wire
    set_link: Callable[[bool], None]
    """take the emulator's interface down or up"""

    def slave(self, name: str) -> EmulatedSlave:
        """A slave by name, or an error with the nearest one."""
        names = [s.spec.name for s in self.bench.slaves]
        if name not in names:
            raise ValueError(f"no slave '{name}'{nearest(name, names)}")
        return self.bench.slave(name)

    def drive(self, axis: str) -> DriveFirmware:
        """The drive of an axis."""
        drives = self.bench.coupling.drives
        if axis not in AXES or AXES.index(axis) not in drives:
            raise ValueError(f"no drive on axis '{axis}'{nearest(axis, AXES)}")
        return drives[AXES.index(axis)]

    def mailbox(self, name: str) -> Mailbox:
        """Mailbox of a slave."""
        box = self.slave(name).mailbox
        if box is None:
            raise ValueError(f"slave '{name}' has no mailbox")
        return box


def _set(target: object, name: str, value: object, after: object) -> Undo:
    """Set an attribute; undoing the fault sets it to `after`."""
    setattr(target, name, value)
    return lambda: setattr(target, name, after)


def lose_frames(rig: FaultTargets, frames: int = 1) -> Undo:
    """So many process data frames never reach the slaves."""
    return _set(rig.wire, "lose_next", int(frames), 0)


def lose_answers(rig: FaultTargets, frames: int = 1) -> Undo:
    """So many process data answers are lost on the way back."""
    return _set(rig.wire, "lose_answers", int(frames), 0)


def lose_share(rig: FaultTargets, share: float) -> Undo:
    """A share of all frames is lost, at random with a fixed seed."""
    if not 0.0 <= share <= 1.0:
        raise ValueError(f"share is {share}, must be within 0..1")
    return _set(rig.wire, "lose_share", float(share), 0.0)


def delay(rig: FaultTargets, ms: float) -> Undo:
    """Process data answers come late."""
    return _set(rig.wire, "delay_ns", round(float(ms) * 1e6), 0)


def hold(rig: FaultTargets) -> Undo:
    """Process data answers pile up; they are released together when this is undone."""
    rig.wire.holding = True
    return rig.wire.release


def wire_dead(rig: FaultTargets) -> Undo:
    """Nothing passes between master and slaves, the link stays up."""
    return _set(rig.wire, "down", True, False)


def link_down(rig: FaultTargets) -> Undo:
    """The interface on this side goes down."""
    rig.set_link(False)
    return lambda: rig.set_link(True)


def counter_offset(rig: FaultTargets, offset: int) -> Undo:
    """The working counter of process data is wrong by so much."""
    return _set(rig.bench.segment, "counter_offset", int(offset), 0)


def cable_cut(rig: FaultTargets, behind: str) -> Undo:
    """The cable is cut behind a slave; 'master' cuts it in front of the first one."""
    segment = rig.bench.segment
    position = 0 if behind == "master" else rig.bench.slaves.index(rig.slave(behind)) + 1
    segment.cut_after = position
    segment.show_topology()

    def mend() -> None:
        segment.cut_after = None
        segment.show_topology()

    return mend


def al_drop(rig: FaultTargets, slave: str, state: str = "SAFEOP", code: int = 0x001B) -> None:
    """A slave falls back by itself, with an AL status code."""
    rig.slave(slave).drop(State[state], int(code))


def al_refuse(rig: FaultTargets, slave: str, state: str = "OP", code: int = 0x0020) -> Undo:
    """A slave refuses to go to a state."""
    refused = rig.slave(slave).al.refused
    refused[State[state]] = int(code)
    return lambda: refused.pop(State[state], None)


def power_off(rig: FaultTargets, slave: str) -> Undo:
    """A slave and those behind it lose power; it comes back as from the factory."""
    broken, segment = rig.slave(slave), rig.bench.segment
    broken.absent = True
    segment.show_topology()

    def on() -> None:
        broken.absent = False
        broken.power_on()
        segment.show_topology()

    return on


def power_cycle(rig: FaultTargets, slave: str) -> None:
    """A slave restarts within one cycle."""
    power_off(rig, slave)()


def identity(
    rig: FaultTargets, slave: str, vendor: int = 0, product: int = 0, revision: int = 0
) -> Undo:
    """Another device in the place of a slave: another identity in its EEPROM (0: unchanged)."""
    changed = rig.slave(slave)
    before = bytes(changed.sii)
    for word, value in ((8, vendor), (10, product), (12, revision)):
        if value:
            changed.sii[2 * word : 2 * word + 4] = int(value).to_bytes(4, "little")

    def mend() -> None:
        changed.sii[:] = before if len(before) == len(changed.sii) else build_sii(changed.spec)

    return mend


def mailbox_hang(rig: FaultTargets, slave: str) -> Undo:
    """Requests are never taken out of the mailbox."""
    box = rig.mailbox(slave)
    box.hang = True

    def mend() -> None:
        box.hang = False
        rig.slave(slave).esc.take_mailbox()

    return mend


def mailbox_abort(rig: FaultTargets, slave: str, code: int = 0x08000000) -> Undo:
    """Every SDO request is refused with an abort code."""
    box = rig.mailbox(slave)
    return _set(box.sdo, "abort_all", int(code), 0)


def mailbox_late(rig: FaultTargets, slave: str, ms: float) -> Undo:
    """SDO answers come late (bench time)."""
    box = rig.mailbox(slave)
    return _set(box, "late_ns", round(float(ms) * 1e6), 0)


def emergency(rig: FaultTargets, slave: str, code: int, register: int = 1) -> None:
    """A slave sends an emergency message, nothing else happens."""
    rig.mailbox(slave).emergency(int(code), int(register))


def drive_fault(
    rig: FaultTargets, axis: str = "wheel", code: int = 0x2310, persists: bool = False
) -> Undo:
    """A drive trips; a cause that persists cannot be reset before it is undone."""
    drive = rig.drive(axis)
    drive.trip(int(code), bool(persists))
    return lambda: setattr(drive, "cause_persists", False)


def stuck_axis(rig: FaultTargets, axis: str = "wheel") -> Undo:
    """The shaft is blocked while the drive wants it to turn, until it sees its following error."""
    drive = rig.drive(axis)
    stick = getattr(rig.bench.plant, "stick", None)
    if stick is not None:
        stick(axis, True)
        return lambda: stick(axis, False)
    return _set(drive, "stuck", True, False)


def channel(rig: FaultTargets, name: str, value: int) -> Undo:
    """An input shows a raw value: a broken wire, a limit switch, an open emergency stop."""
    if name not in busfile.INPUTS:
        raise ValueError(f"no input channel '{name}'{nearest(name, busfile.INPUTS)}")
    overrides = rig.bench.coupling.overrides
    overrides[name] = int(value)
    return lambda: overrides.pop(name, None)


FAULTS: dict[str, Callable[..., Undo | None]] = {
    f.__name__: f
    for f in (
        lose_frames, lose_answers, lose_share, delay, hold, wire_dead, link_down, counter_offset,
        cable_cut, al_drop, al_refuse, power_off, power_cycle, identity, mailbox_hang,
        mailbox_abort, mailbox_late, emergency, drive_fault, stuck_axis, channel,
    )
}  # fmt: skip
