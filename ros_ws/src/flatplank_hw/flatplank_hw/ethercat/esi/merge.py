# SPDX-License-Identifier: Apache-2.0
"""Merges a device description into the bus file: identity and PDOs of the maker, our channels."""

from __future__ import annotations

from dataclasses import replace

from flatplank_data.names import nearest_hint
from flatplank_hw.ethercat.busfile import BusFile, Entry, Pdo, Slave
from flatplank_hw.ethercat.esi.elements import EsiDevice
from flatplank_hw.ethercat.esi.numbers import EsiError

CIA402 = {
    0x6040: "control_word",
    0x6060: "mode",
    0x607A: "target_position",
    0x60FF: "target_velocity",
    0x6071: "target_torque",
    0x6041: "status_word",
    0x6061: "mode_display",
    0x6064: "position",
    0x606C: "velocity",
    0x6077: "torque",
    0x603F: "error_code",
}
"""object of CiA 402 -> channel of an axis"""
TORQUES = (0x6071, 0x6077)
PER_THOUSAND = 1000.0


def slave_from_device(
    device: EsiDevice, name: str, kind: str, axis: str = "", rated_torque_nm: float = 0.0
) -> Slave:
    """Make a slave for the bus file; with `axis` its CiA 402 objects get the channels of the axis.

    Torques are in thousandths of the rated torque, so `rated_torque_nm` is needed for them.
    """
    channels = _cia402(axis, rated_torque_nm) if axis else {}
    return Slave(
        name=name,
        device=kind,
        vendor=device.vendor,
        product=device.product,
        revision=device.revision,
        axis=axis,
        dc=device.dc,
        mailbox=device.mailbox,
        sync_managers=device.sync_managers,
        outputs=_named(device.outputs, channels, echo=bool(axis)),
        inputs=_named(device.inputs, channels, echo=False),
        write_assignment=not device.fixed_assignment,
        write_mapping=device.write_mapping,
        sdos=device.sdos,
    )


def merge_device(
    bus: BusFile, name: str, device: EsiDevice, rated_torque_nm: float = 0.0
) -> BusFile:
    """Return the bus with identity and PDOs of one slave replaced; channels stay with their
    objects. EsiError when a channel would be lost."""
    names = [s.name for s in bus.slaves]
    if name not in names:
        raise EsiError(f"no slave '{name}' in the bus file{nearest_hint(name, names)}")
    old = bus.slave(name)
    new = slave_from_device(device, name, old.device, old.axis, rated_torque_nm)
    known = {
        (e.index, e.subindex): e for e in (*old.output_entries, *old.input_entries) if e.index
    }
    ours = {(s.index, s.subindex) for s in old.sdos}
    new = replace(
        new,
        outputs=_kept(new.outputs, known, device),
        inputs=_kept(new.inputs, known, device),
        # the maker may write an object several times; what the bus file has takes its place
        sdos=(*(s for s in new.sdos if (s.index, s.subindex) not in ours), *old.sdos),
        objects=old.objects,
    )
    _check_nothing_lost(old, new, rated_torque_nm)
    slaves = tuple(new if s.name == name else s for s in bus.slaves)
    return replace(bus, slaves=slaves)


def _cia402(axis: str, rated_torque_nm: float) -> dict[int, Entry]:
    found = {}
    for index, word in CIA402.items():
        if index in TORQUES and not rated_torque_nm:
            continue
        unit = rated_torque_nm / PER_THOUSAND if index in TORQUES else 0.0
        found[index] = Entry(index, 0, "", 0, channel=f"{axis}.{word}", unit_nm=unit)
    return found


def _named(pdos: tuple[Pdo, ...], channels: dict[int, Entry], echo: bool) -> tuple[Pdo, ...]:
    """PDOs with each channel at its first assigned object; the first padding byte carries the
    echo."""
    used: set[str] = set()
    out = []
    for pdo in pdos:
        entries = []
        for entry in pdo.entries:
            source = channels.get(entry.index)
            if source is not None and pdo.assigned and source.channel not in used:
                used.add(source.channel)
                entry = replace(entry, channel=source.channel, unit_nm=source.unit_nm)
            elif echo and not entry.index and entry.bits == 8 and pdo.assigned:
                entry, echo = replace(entry, channel="echo"), False
            entries.append(entry)
        out.append(replace(pdo, entries=tuple(entries)))
    return tuple(out)


def _kept(
    pdos: tuple[Pdo, ...], known: dict[tuple[int, int], Entry], device: EsiDevice
) -> tuple[Pdo, ...]:
    """PDOs whose entries have the channels and units of the old ones, each channel once among
    those that are assigned."""
    used: set[str] = set()

    def keep(entry: Entry, assigned: bool) -> Entry:
        old = known.get((entry.index, entry.subindex))
        if old is None or not old.channel or old.channel in used:
            return entry
        if assigned:
            used.add(old.channel)
        return replace(
            entry,
            kind=_kind(entry, old, device),
            channel=old.channel,
            full_scale_volts=old.full_scale_volts,
            full_scale_counts=old.full_scale_counts,
            unit_nm=old.unit_nm,
        )

    return tuple(replace(p, entries=tuple(keep(e, p.assigned) for e in p.entries)) for p in pdos)


def _kind(entry: Entry, old: Entry, device: EsiDevice) -> str:
    """Type of a channel: by the maker's file, or by the bus file where that says none."""
    if (entry.index, entry.subindex) not in device.untyped:
        return entry.kind
    if old.bits != entry.bits:
        raise EsiError(
            f"{device.type_name}: object 0x{entry.index:04X}:{entry.subindex} of channel "
            f"'{old.channel}' has {entry.bits} bits and no type that is known; the bus file has "
            f"{old.kind}"
        )
    return old.kind


def _check_nothing_lost(old: Slave, new: Slave, rated_torque_nm: float) -> None:
    had = {e.channel for e in (*old.output_entries, *old.input_entries)} - {"", "echo"}
    has = {e.channel for e in (*new.output_entries, *new.input_entries)}
    lost = sorted(had - has)
    if lost:
        torque = any("torque" in c for c in lost) and not rated_torque_nm
        hint = "; give the rated torque" if torque else "; choose another PDO or revision"
        raise EsiError(f"slave '{new.name}': the device has no place for {', '.join(lost)}{hint}")
