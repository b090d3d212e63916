# SPDX-License-Identifier: Apache-2.0
"""AL state machine, EEPROM, watchdog and drive firmware of an emulated slave, without any
socket."""

from __future__ import annotations

import pytest
from ethercat_rig import BUS_FILES, TURNING
from ethercat_stub_plant import StubPlant

from flatplank_hw.bus.image import AxisInputs
from flatplank_hw.cia402 import QUICK_STOP
from flatplank_hw.ethercat.reader import read_bus_file
from flatplank_sim.emulator import registers as reg
from flatplank_sim.emulator.al import AlStatusCode, State, StateMachine
from flatplank_sim.emulator.bench import EmulatedBench, make_plant
from flatplank_sim.emulator.drive_firmware import DriveFirmware
from flatplank_sim.emulator.motion_monitor import WHEEL_MOVING
from flatplank_sim.emulator.sii import build_sii
from flatplank_sim.emulator.slave import EmulatedSlave

BUS = read_bus_file(BUS_FILES / "bench.yaml")
ALL = (State.INIT, State.PREOP, State.SAFEOP, State.OP)


def machine(state: State = State.INIT) -> StateMachine:
    made = StateMachine(lambda _target: 0, lambda _old, _new: None)
    made.state = state
    return made


@pytest.mark.parametrize("start", ALL)
@pytest.mark.parametrize("target", ALL)
def test_all_changes(start: State, target: State) -> None:
    al = machine(start)
    al.request(target)
    one_up = ALL.index(target) == ALL.index(start) + 1
    if target <= start or one_up:
        assert (al.state, al.error, al.code) == (target, False, 0)
    else:
        assert (al.state, al.error, al.code) == (start, True, AlStatusCode.INVALID_CHANGE)


@pytest.mark.parametrize(
    ("request_", "code"), [(3, AlStatusCode.NO_BOOT), (0, 0x12), (7, 0x12), (15, 0x12)]
)
def test_states_that_do_not_exist(request_: int, code: int) -> None:
    al = machine()
    al.request(request_)
    assert al.error and al.code == code and al.status == State.INIT | 0x10


def test_an_error_must_be_acknowledged_before_going_up() -> None:
    al = machine(State.OP)
    al.drop(State.SAFEOP, AlStatusCode.WATCHDOG)
    assert al.status == 0x14
    al.request(State.OP)
    assert al.status == 0x14 and al.code == AlStatusCode.WATCHDOG
    al.request(State.SAFEOP | 0x10)
    assert al.status == State.SAFEOP and al.code == 0
    al.request(State.OP)
    assert al.status == State.OP


def test_an_error_does_not_block_the_way_down() -> None:
    al = machine(State.OP)
    al.drop(State.PREOP, 0x8001)
    al.request(State.INIT)
    assert al.status == State.INIT


def test_refused_state() -> None:
    al = machine(State.SAFEOP)
    al.refused[State.OP] = 0x0030
    al.request(State.OP)
    assert (al.state, al.code, al.error) == (State.SAFEOP, 0x0030, True)


def slave(name: str) -> EmulatedSlave:
    return EmulatedSlave(BUS.slave(name))


def program(made: EmulatedSlave, number: int, start: int, length: int, control: int) -> None:
    raw = start.to_bytes(2, "little") + length.to_bytes(2, "little") + bytes([control, 0, 1, 0])
    made.esc._write(reg.SYNC_MANAGER + 8 * number, raw)


def ask_for(made: EmulatedSlave, state: int) -> tuple[int, int]:
    made.esc._write(reg.AL_CONTROL, state.to_bytes(2, "little"))
    return made.esc.read_register(reg.AL_STATUS), made.esc.read_register(reg.AL_STATUS_CODE)


def to_op(made: EmulatedSlave) -> None:
    program(made, 0, 0x1000, 128, 0x26)
    program(made, 1, 0x1080, 128, 0x22)
    program(made, 2, 0x1100, 16, 0x64)
    program(made, 3, 0x1400, 18, 0x20)
    for state in (2, 4, 8):
        assert ask_for(made, state) == (state, 0)


def test_configuration_is_checked_on_the_way_up() -> None:
    made = slave("wheel_drive")
    assert ask_for(made, 2) == (0x11, AlStatusCode.INVALID_MAILBOX)
    program(made, 0, 0x1000, 128, 0x26)
    program(made, 1, 0x1080, 128, 0x22)
    assert ask_for(made, 0x12) == (2, 0)
    program(made, 2, 0x1100, 15, 0x64)
    assert ask_for(made, 4) == (0x12, AlStatusCode.INVALID_OUTPUTS)
    program(made, 2, 0x1100, 16, 0x64)
    program(made, 3, 0x1400, 19, 0x20)
    assert ask_for(made, 0x14) == (0x12, AlStatusCode.INVALID_INPUTS)
    program(made, 3, 0x1400, 18, 0x20)
    assert ask_for(made, 0x14) == (4, 0)
    assert ask_for(made, 8) == (8, 0)


def test_watchdog_in_bench_time() -> None:
    made = slave("wheel_drive")
    to_op(made)
    made.esc.write_register(reg.WATCHDOG_DATA, 400)
    assert made.esc.watchdog_ns == 40_000_000
    made.tick(40_000_000)
    assert made.operational
    made.tick(40_000_001)
    assert (made.al.state, made.al.code) == (State.SAFEOP, AlStatusCode.WATCHDOG)
    assert (
        made.esc.memory[reg.WATCHDOG_COUNT] == 1
        and not made.esc.read_register(reg.WATCHDOG_STATUS) & 1
    )


def test_watchdog_switched_off() -> None:
    made = slave("wheel_drive")
    to_op(made)
    made.esc.write_register(reg.WATCHDOG_DATA, 0)
    made.tick(10**12)
    assert made.operational


@pytest.mark.parametrize("spec", BUS.slaves, ids=lambda s: s.name)
def test_eeprom(spec) -> None:
    """Identity where masters look for it, checksum, categories that end."""
    sii = build_sii(spec)
    numbers = [int.from_bytes(sii[2 * w : 2 * w + 4], "little") for w in (8, 10, 12)]
    assert numbers == [spec.vendor, spec.product, spec.revision]
    crc = 0xFF
    for byte in sii[:14]:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x107) & 0xFF if crc & 0x80 else crc << 1
    assert crc == sii[14]
    place, kinds = 128, []
    while (kind := int.from_bytes(sii[place : place + 2], "little")) != 0xFFFF:
        kinds.append(kind)
        place += 4 + 2 * int.from_bytes(sii[place + 2 : place + 4], "little")
    assert len(kinds) == len(set(kinds)) and {10, 30, 40, 41} <= set(kinds)
    assert (50 in kinds, 51 in kinds) == (bool(spec.inputs), bool(spec.outputs))


def test_eeprom_over_registers() -> None:
    made = slave("wheel_drive")
    made.esc._write(reg.SII_CONTROL, b"\x00\x01\x08\x00\x00\x00")
    data = made.esc._read(reg.SII_DATA, 8)
    assert int.from_bytes(data[:4], "little") == made.spec.vendor
    made.esc._write(reg.SII_DATA, b"\x34\x12")
    made.esc._write(reg.SII_CONTROL, b"\x01\x02\x0e\x00\x00\x00")
    assert made.sii[28:30] == b"\x34\x12"


# --- the firmware of a drive ---------------------------------------------------------------

RUN = (0x0F, 9, 0, 1000, 0)
STANDING = AxisInputs(0x0237, 9, 0, 0, 0, 0)


@pytest.fixture
def drive() -> DriveFirmware:
    made = slave("wheel_drive")
    to_op(made)
    return DriveFirmware(0, made)


def reset(drive: DriveFirmware, now: int) -> None:
    for word in (0x00, 0x80, 0x00):
        drive.command((word, 9, 0, 0, 0), 0, now)


def test_commands_pass_in_op_only(drive: DriveFirmware) -> None:
    assert drive.command(RUN, 7, 0)[:6] == (0, 7, 0x0F, 9, 0, 1000)
    drive.slave.drop(State.SAFEOP, 0x1B)
    assert drive.command(RUN, 8, 0).control_word == 0


def test_loss_of_communication_is_a_fault_while_enabled(drive: DriveFirmware) -> None:
    drive.report(STANDING._replace(status_word=0x0227), RUN, 0)
    drive.slave.drop(State.SAFEOP, 0x1B)
    assert drive.command(RUN, 1, 0).control_word == 0x02
    assert drive.report(STANDING, RUN, 0)[0::5] == (0x0218, 0x7500)


def cycles_until_rest(drive: DriveFirmware, lost_after: int | None) -> int:
    """Cycles from a quick stop until the wheel rests, which hangs free and has turned at 0.1
    rad/s; the drive loses the bus so many cycles after the quick stop."""
    plant = make_plant("simulated", 250, 1, {}, ["wheel"])
    plant.operator.unload()
    inputs, now, moved = None, 0, 0

    def cycle(word: int) -> None:
        nonlocal inputs, now
        now += 4_000_000
        command = drive.command((word, 9, 0, TURNING, 0), now // 4_000_000 - 1, now)
        inputs = plant.step([command])
        drive.report(inputs.axes[0], (word, 9, 0, TURNING, 0), now)

    for word in (0x06, 0x07, *[0x0F] * 500):
        cycle(word)
    assert plant.truth.wheel_velocity > 0.09
    for n in range(100):
        if n == lost_after:
            drive.slave.drop(State.SAFEOP, 0x1B)
        cycle(QUICK_STOP)
        moved = n if abs(plant.truth.wheel_velocity) > WHEEL_MOVING else moved
    return moved + 1


@pytest.mark.parametrize("lost_after", range(9))
def test_a_drive_that_loses_the_bus_while_it_brakes_brakes_on(
    drive: DriveFirmware, lost_after: int
) -> None:
    made = slave("wheel_drive")
    to_op(made)
    undisturbed = cycles_until_rest(DriveFirmware(0, made), None)
    assert undisturbed > 5
    assert cycles_until_rest(drive, lost_after) <= undisturbed
    assert drive.fault == 0x7500


def test_no_fault_when_it_was_not_enabled(drive: DriveFirmware) -> None:
    drive.report(STANDING._replace(status_word=0x0250), RUN, 0)
    drive.slave.drop(State.SAFEOP, 0x1B)
    drive.command(RUN, 1, 0)
    assert drive.fault == 0


def test_fault_brakes_then_cuts_the_power_until_it_is_reset(drive: DriveFirmware) -> None:
    drive.trip(0x2310)
    assert drive.command(RUN, 1, 0).control_word == 0x02
    assert drive.command(RUN, 1, 199_000_000).control_word == 0x02
    assert drive.command(RUN, 1, 200_000_000).control_word == 0x00
    assert drive.report(STANDING, RUN, 0).error_code == 0x2310
    reset(drive, 300_000_000)
    assert drive.fault == 0 and drive.command(RUN, 1, 0).control_word == 0x0F


def test_a_cause_that_stays_cannot_be_reset(drive: DriveFirmware) -> None:
    drive.trip(0x7305, persists=True)
    reset(drive, 0)
    assert drive.fault == 0x7305
    drive.cause_persists = False
    reset(drive, 0)
    assert drive.fault == 0


def test_a_reset_bit_that_is_always_on_resets_nothing(drive: DriveFirmware) -> None:
    drive.command((0x80, 9, 0, 0, 0), 0, 0)
    drive.trip(0x2310)
    for n in range(10):
        drive.command((0x80, 9, 0, 0, 0), 0, n)
    assert drive.fault == 0x2310


def test_following_error_of_a_stuck_axis(drive: DriveFirmware) -> None:
    drive.stuck = True
    drive.report(STANDING, RUN, 0)
    drive.report(STANDING, RUN, 60_000_000)
    assert drive.fault == 0
    drive.report(STANDING, RUN, 60_000_001)
    assert drive.fault == 0x8611


def test_same_frames_same_bench() -> None:
    """The bench has no clock of its own: the same steps give the same bytes."""
    runs = []
    for _ in range(2):
        bench = EmulatedBench(BUS, StubPlant(250))
        bench.call_at(20, lambda b=bench: b.coupling.drives[0].trip(0x2310))
        seen = []
        for _ in range(60):
            bench.step()
            seen.append([s.inputs.values for s in bench.slaves])
        runs.append(seen)
    assert runs[0] == runs[1] and runs[0][10] != runs[0][30]
