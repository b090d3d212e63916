# SPDX-License-Identifier: Apache-2.0
"""The bus file: the slaves on the bus, their identity and the meaning of their process data.

It contains facts of the devices only (full scale of a terminal, unit of a torque word). Master,
emulator and the import of vendor files use the same file.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from flatplank_hw.bus.image import AXES, AxisInputs, Digital

FORMAT = "flatplank-bus/1"


@dataclass(frozen=True)
class Entry:
    """One object in a PDO; a padding entry has index 0 and no type."""

    index: int
    subindex: int
    kind: str
    """type name of `layout.TYPES`; '' for padding"""
    bits: int
    name: str = ""
    channel: str = ""
    """signal of the bench that it carries, see `INPUTS` and `OUTPUTS`"""
    full_scale_volts: float = 0.0
    """analogue terminals: volts at `full_scale_counts` [V]"""
    full_scale_counts: int = 0
    unit_nm: float = 0.0
    """torque words: newton metres at the motor per count [N m]"""

    @property
    def mapping_word(self) -> int:
        """The entry as stored in a PDO mapping object."""
        return self.index << 16 | self.subindex << 8 | self.bits


@dataclass(frozen=True)
class Pdo:
    """One PDO with its entries; only assigned ones are exchanged."""

    index: int
    entries: tuple[Entry, ...]
    name: str = ""
    assigned: bool = True

    @property
    def bits(self) -> int:
        """Length on the wire [bit]."""
        return sum(entry.bits for entry in self.entries)


@dataclass(frozen=True)
class SdoValue:
    """A value of the object dictionary: the master writes it, or the emulator stores it."""

    index: int
    subindex: int
    kind: str
    value: int | str
    name: str = ""


@dataclass(frozen=True)
class Mailbox:
    """Addresses and sizes of the CoE mailboxes of a slave."""

    out_start: int = 0x1000
    out_size: int = 128
    in_start: int = 0x1080
    in_size: int = 128
    complete_access: bool = True
    sdo_info: bool = True


@dataclass(frozen=True)
class SyncManagers:
    """Addresses of the process data of a slave, and control bytes of its sync managers."""

    outputs_start: int
    outputs_control: int
    inputs_start: int
    inputs_control: int


@dataclass(frozen=True)
class Slave:
    """One slave, in the order of the wire."""

    name: str
    device: str
    """kind of device in the emulator: drive, analogue_input, encoder, digital_input, ..."""
    vendor: int
    product: int
    revision: int
    check_revision: bool = False
    serial: int = 0
    placeholder: str = ""
    """why identity or PDOs are placeholders; empty when they are those of the maker"""
    axis: str = ""
    dc: bool = False
    mailbox: Mailbox | None = None
    sync_managers: SyncManagers | None = None
    outputs: tuple[Pdo, ...] = ()
    inputs: tuple[Pdo, ...] = ()
    write_assignment: bool = False
    """write 0x1C12/0x1C13 at start, for slaves with several PDOs to choose from"""
    write_mapping: bool = False
    """write 0x16xx/0x1Axx at start, for drives with free mapping"""
    sdos: tuple[SdoValue, ...] = ()
    """written at start by the master"""
    objects: tuple[SdoValue, ...] = ()
    """further objects in the object dictionary of the emulator"""

    @property
    def output_entries(self) -> tuple[Entry, ...]:
        """Entries of the assigned output PDOs, in order."""
        return tuple(e for pdo in self.outputs if pdo.assigned for e in pdo.entries)

    @property
    def input_entries(self) -> tuple[Entry, ...]:
        """Entries of the assigned input PDOs, in order."""
        return tuple(e for pdo in self.inputs if pdo.assigned for e in pdo.entries)

    @property
    def output_bits(self) -> int:
        """Output process data [bit]."""
        return sum(e.bits for e in self.output_entries)

    @property
    def input_bits(self) -> int:
        """Input process data [bit]."""
        return sum(e.bits for e in self.input_entries)

    @property
    def memory(self) -> SyncManagers:
        """Sync managers as given, or the defaults for a slave with or without mailbox."""
        if self.sync_managers is not None:
            return self.sync_managers
        if self.mailbox is not None:
            return SyncManagers(0x1100, 0x64, 0x1400, 0x20)
        return SyncManagers(0x0F00, 0x44, 0x1000, 0x00)


@dataclass(frozen=True)
class BusFile:
    """A whole bus."""

    name: str
    slaves: tuple[Slave, ...]
    rate_hz: int = 250
    watchdog_ms: int = 40
    """process data watchdog of each slave with outputs [ms]"""
    command_timeout_ms: int = 44
    """a command older than this stops its axis [ms]"""
    path: str = field(default="", compare=False)

    @property
    def period_ns(self) -> int:
        """Bus cycle [ns]."""
        return 1_000_000_000 // self.rate_hz

    def slave(self, name: str) -> Slave:
        """Slave by name."""
        return next(s for s in self.slaves if s.name == name)


VOLTS = ("C1", "C2", "C3", "C4", "C5", "C6", "lvdt")
"""analogue inputs [V]: the six bridges and the axle height"""

COUNTS = ("plank_counts", "wheel_counts", "steer_counts", "camber_counts", "road_counts")
"""encoder terminals [counts]; the master extends counters narrower than 32 bits"""

DIGITAL = {
    "trigger": Digital.TRIGGER,
    "emergency_stop_ok": Digital.EMERGENCY_STOP_OK,
    "limit_front": Digital.LIMIT_FRONT,
    "limit_rear": Digital.LIMIT_REAR,
}

AXIS_INPUTS = AxisInputs._fields
AXIS_OUTPUTS = ("control_word", "mode", "target_position", "target_velocity", "target_torque")
TORQUES = ("torque", "target_torque")

DIGITAL_OUTPUTS = "digital_outputs"
ECHO = "echo"
"""channel of a padding byte in the outputs that no slave reads; the master writes its cycle count
"""

INPUTS = frozenset([*VOLTS, *COUNTS, *DIGITAL, *(f"{a}.{w}" for a in AXES for w in AXIS_INPUTS)])
OUTPUTS = frozenset([DIGITAL_OUTPUTS, ECHO, *(f"{a}.{w}" for a in AXES for w in AXIS_OUTPUTS)])
