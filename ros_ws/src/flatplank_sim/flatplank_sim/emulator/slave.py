# SPDX-License-Identifier: Apache-2.0
"""A slave of the bus file: controller, EEPROM, state machine, mailbox, process data."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from flatplank_hw.ethercat.busfile import Slave
from flatplank_sim.emulator import registers as reg
from flatplank_sim.emulator.al import AlStatusCode, State, StateMachine
from flatplank_sim.emulator.dictionary import Dictionary, Variable, variable
from flatplank_sim.emulator.esc import SlaveController
from flatplank_sim.emulator.mailbox import Mailbox
from flatplank_sim.emulator.pdo import PdoDirection, known_entries
from flatplank_sim.emulator.sii import build_sii, input_manager, output_manager

_READ, _WRITE = 0x0100, 0x0201
_SII_READY = 0x0040


class EmulatedSlave:
    """A slave as seen from the bus; the device behind it uses the process data."""

    def __init__(self, spec: Slave) -> None:
        self.spec = spec
        self.absent = False
        """injected fault: power off"""
        self.esc = SlaveController(spec.dc)
        self.sii = bytearray(build_sii(spec))
        self.al = StateMachine(self._check, self._changed)
        self.outputs = PdoDirection(
            0x1C12, spec.outputs, known_entries(spec.outputs), spec.write_mapping, self._in_preop
        )
        self.inputs = PdoDirection(
            0x1C13, spec.inputs, known_entries(spec.inputs), spec.write_mapping, self._in_preop
        )
        self.state_hooks: list[Callable[[State, State], None]] = []
        self.reset_hooks: list[Callable[[], None]] = []
        self.dictionary = Dictionary()
        self.mailbox: Mailbox | None = None
        if spec.mailbox is not None:
            self.mailbox = Mailbox(self.dictionary, spec.mailbox.in_size, self.esc.offer_mailbox)
        self.esc.al_control = self._al_control
        self.esc.sii_command = self._sii_command
        self.esc.mailbox_received = self._mail
        self.esc.mailbox_fetched = self._fetched
        self.power_on()

    def power_on(self) -> None:
        """Reset everything to the state after power-on."""
        self.esc.reset()
        self.outputs.reset()
        self.inputs.reset()
        self.dictionary.objects.clear()
        self._fill_dictionary()
        if self.mailbox is not None:
            self.mailbox.reset()
        self.al.reset()
        self._show()
        for hook in self.reset_hooks:
            hook()

    def tick(self, now: int) -> None:
        """Update watchdog and mailbox to bench time `now` [ns]."""
        self.esc.now = now
        if self.mailbox is not None:
            self.mailbox.offer_next(now)
        if (
            self.al.state == State.OP
            and self.watched
            and now - self.esc.last_outputs > self.esc.watchdog_ns
        ):
            self.esc.write_register(reg.WATCHDOG_STATUS, 0)
            count = self.esc.read_register(reg.WATCHDOG_COUNT, 1)
            self.esc.write_register(reg.WATCHDOG_COUNT, min(count + 1, 255), 1)
            self.drop(State.SAFEOP, AlStatusCode.WATCHDOG)

    @property
    def watched(self) -> bool:
        """True when the watchdog monitors the outputs."""
        manager = self.esc.manager(output_manager(self.spec))
        return manager is not None and manager.watched and self.esc.watchdog_ns > 0

    @property
    def operational(self) -> bool:
        """True in OP with power; outputs are valid only then."""
        return self.al.state == State.OP and not self.absent

    def drop(self, state: State, code: int) -> None:
        """Let the slave fall back by itself, with an error code."""
        self.al.drop(state, code)
        self._show()

    def fetch_outputs(self) -> tuple[int, ...]:
        """Outputs from the memory, as numbers, in the order of the assigned entries."""
        start = self.spec.memory.outputs_start
        layout = self.outputs.layout
        self.outputs.values = layout.unpack(self.esc.memory[start : start + layout.size])
        return self.outputs.values

    def store_inputs(self, values: tuple[int, ...]) -> None:
        """Write inputs to the memory."""
        self.inputs.values = values
        start = self.spec.memory.inputs_start
        data = self.inputs.layout.pack(values)
        self.esc.memory[start : start + len(data)] = data

    # --- hooks of the controller -----------------------------------------------------------

    def _al_control(self, control: int) -> None:
        self.al.request(control)
        self._show()

    def _show(self) -> None:
        self.esc.write_register(reg.AL_STATUS, self.al.status)
        self.esc.write_register(reg.AL_STATUS_CODE, self.al.code)

    def _in_preop(self) -> bool:
        return self.al.state == State.PREOP

    def _check(self, target: State) -> int:
        box, memory, esc = self.spec.mailbox, self.spec.memory, self.esc
        if target == State.PREOP and box is not None:
            out, back = esc.manager(0), esc.manager(1)
            set_up = [(m.start, m.length) for m in (out, back) if m is not None]
            if set_up != [(box.out_start, box.out_size), (box.in_start, box.in_size)]:
                return AlStatusCode.INVALID_MAILBOX
        if target == State.SAFEOP:
            size = self.outputs.layout.size
            if not self._fits(output_manager(self.spec), memory.outputs_start, size):
                return AlStatusCode.INVALID_OUTPUTS
            size = self.inputs.layout.size
            if not self._fits(input_manager(self.spec), memory.inputs_start, size):
                return AlStatusCode.INVALID_INPUTS
        return AlStatusCode.NONE

    def _fits(self, number: int, start: int, size: int) -> bool:
        manager = self.esc.manager(number)
        if size == 0:
            return manager is None or manager.mailbox or manager.length == 0 or number < 2
        return manager is not None and (manager.start, manager.length) == (start, size)

    def _changed(self, old: State, new: State) -> None:
        self.esc.process_data_on = new in (State.SAFEOP, State.OP)
        if new == State.OP:
            self.esc.last_outputs = self.esc.now
            self.esc.write_register(reg.WATCHDOG_STATUS, 1)
        if new == State.INIT and self.mailbox is not None:
            self.mailbox.reset()
        for hook in self.state_hooks:
            hook(old, new)

    def _mail(self, message: bytes) -> None:
        if self.mailbox is not None and self.al.state != State.INIT:
            if not self.mailbox.hang:
                self.esc.take_mailbox()
            self.mailbox.request(message)

    def _fetched(self) -> None:
        if self.mailbox is not None:
            self.mailbox.offer_next(self.esc.now)

    def _sii_command(self, command: int) -> None:
        esc, address = self.esc, self.esc.read_register(reg.SII_ADDRESS, 4) * 2
        if command & 0x0700 == _READ:
            data = bytes(self.sii[address : address + 8]).ljust(8, b"\xff")
            esc.memory[reg.SII_DATA : reg.SII_DATA + 8] = data
        elif command & 0x0701 == _WRITE and address + 2 <= len(self.sii):
            self.sii[address : address + 2] = esc.memory[reg.SII_DATA : reg.SII_DATA + 2]
        esc.write_register(reg.SII_CONTROL, _SII_READY)

    # --- object dictionary -----------------------------------------------------------------

    def _fill_dictionary(self) -> None:
        spec, d = self.spec, self.dictionary
        device = 0x00020192 if spec.device == "drive" else 0x1389
        d.add(0x1000, 0, variable("uint32", device, "device type"))
        d.add(0x1008, 0, variable("string", spec.name, "device name"))
        d.add(0x1009, 0, variable("string", "emulated", "hardware version"))
        d.add(0x100A, 0, variable("string", "1.0", "software version"))
        identity = (spec.vendor, spec.product, spec.revision, spec.serial)
        names = ("vendor", "product", "revision", "serial")
        for sub, (name, value) in enumerate(zip(names, identity, strict=True), 1):
            d.add(0x1018, sub, variable("uint32", value, name), "identity")
        for sub, kind in enumerate((1, 2, 3, 4), 1):
            d.add(0x1C00, sub, variable("uint8", kind, f"SM{sub - 1}"), "sync manager types")
        for direction in (self.outputs, self.inputs):
            direction.add_objects(d)
            for entry in direction.known.values():
                if entry.index:
                    item = Variable(entry.kind, bytes((entry.bits + 7) // 8), True, entry.name)
                    item.read = partial(direction.present_value, entry.index, entry.subindex, item)
                    item.writable = direction is self.outputs
                    d.add(entry.index, entry.subindex, item)
        for one in (*spec.objects, *spec.sdos):
            d.add(one.index, one.subindex, variable(one.kind, one.value, one.name, True))
