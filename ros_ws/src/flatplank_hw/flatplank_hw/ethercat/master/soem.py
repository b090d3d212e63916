# SPDX-License-Identifier: Apache-2.0
"""Wraps pysoem safely: one object per bus, used by one thread only."""

from __future__ import annotations

import os
import select
import time
from collections.abc import Callable, Sequence
from typing import NamedTuple

import pysoem

from flatplank_hw.ethercat.busfile import BusFile, Slave
from flatplank_hw.ethercat.master.configuration import write_configuration
from flatplank_hw.ethercat.master.health import SlaveState, describe_slaves
from flatplank_hw.ethercat.master.image import expected_counter
from flatplank_hw.ethercat.master.interface import BusError, check_identities

SDO_TIMEOUT_US = 20_000
"""SDO time-out in OP; the cycle stops meanwhile, and the default of 700 ms would trip all
watchdogs"""
START_SDO_TIMEOUT_US = 700_000
"""SDO time-out before OP, where a slow slave does no harm"""
WATCHDOG_DIVIDER_NS = 100_000
STATES = {"INIT": 1, "PREOP": 2, "SAFEOP": 4, "OP": 8}


class Exchange(NamedTuple):
    """Result of one process data frame."""

    arrived: bool
    counter: int
    round_trip_ns: int


class SoemBus:
    """One bus, from the interface to OP and back."""

    def __init__(self, bus: BusFile, interface: str) -> None:
        self.bus = bus
        self.interface = interface
        self.expected = expected_counter(bus)
        self.emergency: Callable[[str, int, int], None] = lambda *_: None
        """called for each emergency with slave, error code and error register"""
        self.mapped = False
        """true when a process image exists, whatever the states of the slaves"""
        self._master = pysoem.Master()
        self._fd = -1

    # --- from INIT to OP -------------------------------------------------------------------

    def open(self) -> None:
        """Open the socket and find its descriptor, which allows waiting for replies without the
        GIL."""
        before = _sockets()
        try:
            self._master.open(self.interface)
        except ConnectionError:
            raise BusError(
                f"interface '{self.interface}' cannot be opened; is it there, and up?"
            ) from None
        self._fd = max(_sockets() - before)
        self._set_sdo_timeout(SDO_TIMEOUT_US)

    def reopen(self) -> None:
        """Open a new socket; pending answers are discarded."""
        self._master.close()
        self.open()

    def scan(self) -> None:
        """Find the slaves and compare them with the bus file; leaves them in PREOP."""
        self.mapped = False
        count = self._master.config_init()
        found = [(s.name, s.man, s.id, s.rev) for s in self._master.slaves] if count > 0 else []
        check_identities(self.bus, found, self.interface)
        for slave, spec in zip(self._master.slaves, self.bus.slaves, strict=True):
            slave.add_emergency_callback(self._emergency(spec.name))

    def configure(self) -> None:
        """Configure SDOs, PDOs, image and watchdogs; leaves the slaves in SAFEOP."""
        self._set_sdo_timeout(START_SDO_TIMEOUT_US)
        try:
            self._configure()
        finally:
            self._set_sdo_timeout(SDO_TIMEOUT_US)

    def _configure(self) -> None:
        for slave, spec in zip(self._master.slaves, self.bus.slaves, strict=True):
            if spec.mailbox is not None:
                slave.config_func = self._configurer(spec)
        try:
            self._master.config_map()
        except pysoem.ConfigMapError as error:
            text = "; ".join(_mailbox_text(self.bus, e) for e in error.error_list)
            raise BusError(f"configuration of the slaves failed: {text}") from None
        except (pysoem.SdoError, pysoem.MailboxError, pysoem.PacketError) as error:
            text = _mailbox_text(self.bus, error)
            raise BusError(f"configuration of the slaves failed: {text}") from None
        except pysoem.WkcError:
            raise BusError("configuration of the slaves failed: a slave does not answer") from None
        self._check_sizes()
        for slave, spec in zip(self._master.slaves, self.bus.slaves, strict=True):
            if not self._set_watchdog(slave, spec):
                raise BusError(f"slave '{spec.name}' does not answer; is its cable plugged in?")
        self._master.state_check(STATES["SAFEOP"], 200_000)
        self._need("SAFEOP")
        self.mapped = True

    def to_op(self, outputs: Sequence[tuple[int, bytes]], timeout_s: float = 1.0) -> None:
        """Exchange process data until every slave is in OP."""
        self.exchange(outputs, 0.002)
        self._master.state = STATES["OP"]
        self._master.write_state()
        end = time.monotonic() + timeout_s
        while True:
            self.exchange(outputs, 0.002)
            states = self.states()
            if all(s.state == STATES["OP"] for s in states):
                return
            if time.monotonic() > end or any(s.state & 0x10 for s in states):
                self._need("OP")

    def acknowledge(self) -> None:
        """Acknowledge errors of slaves that fell back to SAFEOP and request OP.

        One that has restarted has the watchdog of its maker until ours is written.
        """
        for slave, spec in zip(self._master.slaves, self.bus.slaves, strict=True):
            if slave.state & 0x0F == STATES["SAFEOP"] and self._set_watchdog(slave, spec):
                if slave.state & 0x10:
                    slave.state = STATES["SAFEOP"] + pysoem.STATE_ACK
                    slave.write_state()
                slave.state = STATES["OP"]
                slave.write_state()

    def reconfigure(self) -> bool:
        """Bring slaves that lost their state or their address back to SAFEOP, one by one."""
        good = True
        for slave in self._master.slaves:
            if slave.state & 0x0F in (STATES["OP"], STATES["SAFEOP"]):
                continue
            if slave.state & 0x10:
                slave.state = slave.state & 0x0F | pysoem.STATE_ACK
                slave.write_state()
            found = slave.state != 0 or slave.recover(2000) > 0
            good &= found and slave.reconfig(2000) == STATES["SAFEOP"]
        return good

    def close(self) -> None:
        """Go to SAFEOP and INIT and close the socket; errors are ignored."""
        if not self._master.context_initialized:
            return
        for state in ("SAFEOP", "INIT"):
            if self._master.slaves:
                self._master.state = STATES[state]
                self._master.write_state()
        self._master.close()

    # --- the cycle -------------------------------------------------------------------------

    def exchange(self, outputs: Sequence[tuple[int, bytes]], timeout_s: float) -> Exchange:
        """Exchange one process data frame; a lost one costs the time-out, not the 4 to 12 ms of
        pysoem."""
        if not self.mapped:
            return Exchange(False, 0, 0)
        slaves = self._master.slaves
        for number, data in outputs:
            slaves[number].output = data
        start = time.perf_counter_ns()
        self._master.send_processdata()
        ready, _, _ = select.select([self._fd], [], [], timeout_s)
        if ready:
            counter = self._master.receive_processdata(500)
        else:
            os.set_blocking(self._fd, False)
            counter = self._master.receive_processdata(0)
            os.set_blocking(self._fd, True)
        return Exchange(counter >= 0, max(counter, 0), time.perf_counter_ns() - start)

    def inputs(self) -> list[bytes]:
        """Input bytes per slave."""
        return [slave.input for slave in self._master.slaves]

    def output_byte(self, slave: int, byte: int) -> int:
        """Output byte as returned by the last frame."""
        return self._master.slaves[slave].output[byte]

    def states(self) -> tuple[SlaveState, ...]:
        """Read the AL states of all slaves (one frame when all are in OP)."""
        if len(self._master.slaves or ()) != len(self.bus.slaves):
            return tuple(SlaveState(spec.name, 0, 0, "") for spec in self.bus.slaves)
        self._master.read_state()
        return tuple(
            SlaveState(
                spec.name,
                s.state,
                s.al_status,
                pysoem.al_status_code_to_string(s.al_status) if s.state & 0x10 else "",
            )
            for s, spec in zip(self._master.slaves, self.bus.slaves, strict=True)
        )

    def poll_mailbox(self, number: int) -> None:
        """Check the mailbox of a slave for an emergency."""
        if not self.mapped:
            return
        try:
            self._master.slaves[number].mbx_receive()
        except (pysoem.MailboxError, pysoem.PacketError):
            return

    def sdo_read(self, number: int, index: int, subindex: int) -> bytes:
        """SDO upload; LookupError with the reason when the slave refuses or does not answer."""
        return self._sdo(number, lambda s: s.sdo_read(index, subindex, 4096))

    def sdo_write(self, number: int, index: int, subindex: int, data: bytes) -> None:
        """SDO download; LookupError with the reason when the slave refuses or does not answer."""
        self._sdo(number, lambda s: s.sdo_write(index, subindex, data))

    # --- details ---------------------------------------------------------------------------

    def _set_sdo_timeout(self, timeout_us: int) -> None:
        self._master.sdo_read_timeout = timeout_us
        self._master.sdo_write_timeout = timeout_us

    def _sdo(self, number: int, act: Callable[[pysoem.CdefSlave], bytes]) -> bytes:
        name = self.bus.slaves[number].name
        if not self.mapped:
            raise LookupError(f"{name}: the bus is down")
        try:
            return act(self._master.slaves[number])
        except pysoem.SdoError as error:
            raise LookupError(
                f"{name}: refused, 0x{error.abort_code:08X} ({error.desc})"
            ) from None
        except (pysoem.WkcError, pysoem.MailboxError, pysoem.PacketError):
            raise LookupError(f"{name}: no answer within {SDO_TIMEOUT_US // 1000} ms") from None

    def _configurer(self, spec: Slave) -> Callable[[int], None]:
        return lambda number: write_configuration(self._master.slaves[number], spec)

    def _emergency(self, name: str) -> Callable[[pysoem.Emergency], None]:
        return lambda message: self.emergency(name, message.error_code, message.error_reg)

    def _set_watchdog(self, slave: pysoem.CdefSlave, spec: Slave) -> bool:
        """Set the watchdog of a slave with outputs; false when it does not answer."""
        if not spec.output_bits:
            return True
        ticks = self.bus.watchdog_ms * 1_000_000 // WATCHDOG_DIVIDER_NS
        try:
            slave._fpwr(0x0400, (WATCHDOG_DIVIDER_NS // 40 - 2).to_bytes(2, "little"), 4000)
            slave._fpwr(0x0420, ticks.to_bytes(2, "little"), 4000)
        except pysoem.WkcError:
            return False
        return True

    def _check_sizes(self) -> None:
        for slave, spec in zip(self._master.slaves, self.bus.slaves, strict=True):
            for what, data, bits in (
                ("output", slave.output, spec.output_bits),
                ("input", slave.input, spec.input_bits),
            ):
                if len(data) != (bits + 7) // 8:
                    raise BusError(
                        f"slave '{spec.name}' has {len(data)} {what} bytes, the bus file"
                        f" {(bits + 7) // 8}; correct its PDOs or set write_assignment"
                    )

    def _need(self, state: str) -> None:
        wrong = tuple(s for s in self.states() if s.state != STATES[state])
        if wrong:
            raise BusError(f"not all slaves reach {state}: {describe_slaves(wrong)}")


def _sockets() -> set[int]:
    found = set()
    for name in os.listdir("/proc/self/fd"):
        try:
            if os.readlink(f"/proc/self/fd/{name}").startswith("socket:"):
                found.add(int(name))
        except OSError:
            continue
    return found


def _mailbox_text(bus: BusFile, error: Exception) -> str:
    position = getattr(error, "slave_pos", 0)
    name = bus.slaves[position - 1].name if 0 < position <= len(bus.slaves) else "?"
    if isinstance(error, pysoem.SdoError):
        return f"{name} refuses 0x{error.index:04X}:{error.subindex} ({error.desc})"
    return f"{name}: {getattr(error, 'desc', error)}"
