# SPDX-License-Identifier: Apache-2.0
"""The faults of the control socket, and how to undo each.

A fault is a function that checks its arguments (ValueError) and returns its action. The action
returns a function that undoes it, or None when the fault ends by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from flatplank_data.names import nearest_hint
from flatplank_hw.bus.image import AXES
from flatplank_hw.ethercat.layout import range_of_type
from flatplank_hw.ethercat.reader import check_integer, check_number
from flatplank_sim.emulator.al import State
from flatplank_sim.emulator.bench import EmulatedBench
from flatplank_sim.emulator.drive_firmware import DriveFirmware
from flatplank_sim.emulator.mailbox import Mailbox
from flatplank_sim.emulator.sii import build_sii
from flatplank_sim.emulator.slave import EmulatedSlave
from flatplank_sim.emulator.wire import Wire

Undo = Callable[[], object]
Action = Callable[[], Undo | None]


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
            raise ValueError(f"no slave '{name}'{nearest_hint(str(name), names)}")
        return self.bench.slave(name)

    def drive(self, axis: str) -> DriveFirmware:
        """The drive of an axis."""
        drives = self.bench.coupling.drives
        if axis not in AXES or AXES.index(axis) not in drives:
            raise ValueError(f"no drive on axis '{axis}'{nearest_hint(str(axis), AXES)}")
        return drives[AXES.index(axis)]

    def mailbox(self, name: str) -> Mailbox:
        """Mailbox of a slave."""
        box = self.slave(name).mailbox
        if box is None:
            raise ValueError(f"slave '{name}' has no mailbox")
        return box


def _whole(name: str, value: Any, bits: int) -> int:
    return check_integer(value, name, 0, (1 << bits) - 1)


def _state(name: str) -> State:
    if name not in list(State.__members__):
        raise ValueError(f"no state '{name}'{nearest_hint(str(name), State.__members__)}")
    return State[name]


def _action(do: Callable[[], object], undo: Undo) -> Action:
    def act() -> Undo:
        do()
        return undo

    return act


def _set(target: object, name: str, value: object, after: object) -> Action:
    """Set an attribute; undoing the fault sets it to `after`."""
    return _action(partial(setattr, target, name, value), partial(setattr, target, name, after))


def lose_frames(rig: FaultTargets, frames: int = 1) -> Action:
    """The next `frames` process data frames never reach the slaves."""
    return _set(rig.wire, "lose_next", _whole("frames", frames, 32), 0)


def lose_answers(rig: FaultTargets, frames: int = 1) -> Action:
    """The next `frames` process data answers are lost on the way back."""
    return _set(rig.wire, "lose_answers", _whole("frames", frames, 32), 0)


def lose_share(rig: FaultTargets, share: float) -> Action:
    """A share of all frames is lost, at random with a fixed seed."""
    if not 0.0 <= check_number(share, "share") <= 1.0:
        raise ValueError(f"share is {share}, must be within 0..1")
    return _set(rig.wire, "lose_share", float(share), 0.0)


def delay(rig: FaultTargets, ms: float) -> Action:
    """Process data answers come late."""
    return _set(rig.wire, "delay_ns", round(check_number(ms, "ms") * 1e6), 0)


def hold(rig: FaultTargets) -> Action:
    """Process data answers pile up; they are released together when this is undone."""
    return _action(partial(setattr, rig.wire, "holding", True), rig.wire.release)


def wire_dead(rig: FaultTargets) -> Action:
    """Nothing passes between master and slaves, the link stays up."""
    return _set(rig.wire, "down", True, False)


def link_down(rig: FaultTargets) -> Action:
    """The interface on this side goes down."""
    return _action(partial(rig.set_link, False), partial(rig.set_link, True))


def counter_offset(rig: FaultTargets, offset: int) -> Action:
    """The working counter of process data is wrong by `offset`."""
    value = check_integer(offset, "offset", -0xFFFF, 0xFFFF)
    return _set(rig.bench.segment, "counter_offset", value, 0)


def cable_cut(rig: FaultTargets, behind: str) -> Action:
    """The cable is cut behind a slave; 'master' cuts it in front of the first one."""
    segment = rig.bench.segment
    position = 0 if behind == "master" else rig.bench.slaves.index(rig.slave(behind)) + 1

    def cut(after: int | None) -> None:
        segment.cut_after = after
        segment.show_topology()

    return _action(partial(cut, position), partial(cut, None))


def al_drop(rig: FaultTargets, slave: str, state: str = "SAFEOP", code: int = 0x001B) -> Action:
    """A slave falls back by itself, with an AL status code."""
    return partial(rig.slave(slave).drop, _state(state), _whole("code", code, 16))


def al_refuse(rig: FaultTargets, slave: str, state: str = "OP", code: int = 0x0020) -> Action:
    """A slave refuses to go to a state."""
    refused, target, value = rig.slave(slave).al.refused, _state(state), _whole("code", code, 16)
    return _action(partial(refused.update, {target: value}), partial(refused.pop, target, None))


def power_off(rig: FaultTargets, slave: str) -> Action:
    """A slave and those behind it lose power; it comes back as from the factory."""
    target, segment = rig.slave(slave), rig.bench.segment

    def off() -> None:
        target.absent = True
        segment.show_topology()

    def on() -> None:
        target.absent = False
        target.power_on()
        segment.show_topology()

    return _action(off, on)


def power_cycle(rig: FaultTargets, slave: str) -> Action:
    """A slave restarts within one cycle."""
    off = power_off(rig, slave)

    def act() -> None:
        if on := off():
            on()

    return act


def identity(
    rig: FaultTargets, slave: str, vendor: int = 0, product: int = 0, revision: int = 0
) -> Action:
    """Another device in the place of a slave: another identity in its EEPROM (0: unchanged)."""
    changed = rig.slave(slave)
    given = {"vendor": vendor, "product": product, "revision": revision}
    values = [_whole(name, value, 32) for name, value in given.items()]

    def act() -> Undo:
        before = bytes(changed.sii)
        for word, value in zip((8, 10, 12), values, strict=True):
            if value:
                changed.sii[2 * word : 2 * word + 4] = value.to_bytes(4, "little")

        def mend() -> None:
            changed.sii[:] = before if len(before) == len(changed.sii) else build_sii(changed.spec)

        return mend

    return act


def mailbox_hang(rig: FaultTargets, slave: str) -> Action:
    """Requests are never taken out of the mailbox."""
    box = rig.mailbox(slave)

    def mend() -> None:
        box.hang = False
        rig.slave(slave).esc.take_mailbox()

    return _action(partial(setattr, box, "hang", True), mend)


def mailbox_abort(rig: FaultTargets, slave: str, code: int = 0x08000000) -> Action:
    """Every SDO request is refused with an abort code."""
    return _set(rig.mailbox(slave).sdo, "abort_all", _whole("code", code, 32), 0)


def mailbox_late(rig: FaultTargets, slave: str, ms: float) -> Action:
    """SDO answers come late (bench time)."""
    return _set(rig.mailbox(slave), "late_ns", round(check_number(ms, "ms") * 1e6), 0)


def emergency(rig: FaultTargets, slave: str, code: int, register: int = 1) -> Action:
    """A slave sends an emergency message, nothing else happens."""
    values = _whole("code", code, 16), _whole("register", register, 8)
    return partial(rig.mailbox(slave).emergency, *values)


def drive_fault(
    rig: FaultTargets, axis: str = "wheel", code: int = 0x2310, persists: bool = False
) -> Action:
    """A drive trips; a cause that persists cannot be reset before it is undone."""
    drive, value = rig.drive(axis), _whole("code", code, 16)
    mend = partial(setattr, drive, "cause_persists", False)
    return _action(partial(drive.trip, value, bool(persists)), mend)


def stuck_axis(rig: FaultTargets, axis: str = "wheel") -> Action:
    """The shaft is blocked while the drive wants it to turn, until it sees its following error."""
    drive = rig.drive(axis)
    stick = getattr(rig.bench.plant, "stick", None)
    if stick is None:
        return _set(drive, "stuck", True, False)
    return _action(partial(stick, axis, True), partial(stick, axis, False))


def channel(rig: FaultTargets, name: str, value: int) -> Action:
    """An input shows a raw value: a broken wire, a limit switch, an open emergency stop."""
    entries = [entry for slave in rig.bench.slaves for entry in slave.spec.input_entries]
    known = {entry.channel: entry for entry in entries if entry.channel}
    if name not in list(known):
        raise ValueError(f"no input channel '{name}'{nearest_hint(str(name), known)}")
    entry, overrides = known[name], rig.bench.coupling.overrides
    low, high = range_of_type(entry.kind) if entry.kind else (0, (1 << entry.bits) - 1)
    raw = check_integer(value, "value", low, high)
    return _action(partial(overrides.update, {name: raw}), partial(overrides.pop, name, None))


FAULTS: dict[str, Callable[..., Action]] = {
    f.__name__: f
    for f in (
        lose_frames, lose_answers, lose_share, delay, hold, wire_dead, link_down, counter_offset,
        cable_cut, al_drop, al_refuse, power_off, power_cycle, identity, mailbox_hang,
        mailbox_abort, mailbox_late, emergency, drive_fault, stuck_axis, channel,
    )
}  # fmt: skip
