# SPDX-License-Identifier: Apache-2.0
"""The table of faults on a running bus: what is broken, for how long, and what must be seen of
it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Scenario:
    """One fault with its own signature."""

    name: str
    fault: str
    arguments: dict[str, Any] = field(default_factory=dict)
    cycles: int = 40
    """after so many cycles it is mended"""
    stops: bool = True
    health: tuple[str, ...] = ()
    """verdicts that must have been given"""
    never: tuple[str, ...] = ()
    """verdicts that must not have been given"""
    reason: str = ""
    """part of the reason shown while the fault is there"""
    grows: tuple[str, ...] = ()
    """counters of the diagnostics that must have grown"""
    steps: tuple[str, ...] = ()
    """steps of the recovery that must have been taken"""
    held: str | None = ""
    """cause for which the guard holds the wheel; None: the drive may have been faster"""
    error_code: int = 0
    """shown by the axis"""
    events: tuple[str, ...] = ()
    """parts of events that must have come"""
    sdo: str = ""
    """how an SDO to the drive ends while the fault is there; empty: none is asked"""

    @property
    def cause(self) -> str:
        """For a reader."""
        words = " ".join(f"{key}={_plain(value)}" for key, value in self.arguments.items())
        return f"`{self.fault} {words}`".replace(" `", "`") + f" for {self.cycles} cycles"

    @property
    def signature(self) -> str:
        """For a reader: what tells this fault from the others."""
        parts = [*self.health, *(f"never {name}" for name in self.never)]
        parts += [f"'{self.reason}'"] if self.reason else []
        parts += [f"`{name}` grows" for name in self.grows]
        parts += [f"recovery {name}" for name in self.steps]
        if self.stops:
            parts += [f"held: {self.held}"] if self.held else []
            parts += [f"error 0x{self.error_code:04X}"]
        parts += [f"SDO: '{self.sdo}'"] if self.sdo else []
        parts += [f"event {text}" for text in self.events]
        return ", ".join(parts)


def _plain(value: Any) -> str:
    """Codes as in the makers' books."""
    return f"0x{value:04X}" if type(value) is int and value > 0xFF else str(value)


def _cut(after: str, seen: str) -> Scenario:
    return Scenario(
        f"cable cut behind {after}",
        "cable_cut",
        {"behind": after},
        health=("LOST",),
        reason=f"{seen}: no answer",
        steps=("ACKNOWLEDGE",),
        held="BUS",
        error_code=0x7500,
    )


_CHAIN = (
    "coupler",
    "wheel_drive",
    "bridges_a",
    "bridges_b",
    "encoders_a",
    "encoders_b",
    "encoders_c",
    "digital_in",
    "digital_out",
)

SCENARIOS = (
    # frames lost or late
    Scenario(
        "one frame lost", "lose_frames", {"frames": 1}, stops=False,
        health=("DEGRADED",), never=("LOST",), grows=("lost",),
    ),
    Scenario(
        "two frames lost", "lose_frames", {"frames": 2}, stops=False,
        health=("DEGRADED",), never=("LOST",), grows=("lost",),
    ),
    Scenario(
        "eight frames lost", "lose_frames", {"frames": 8},
        health=("LOST",), grows=("lost",), held="BUS", error_code=0x7500,
    ),
    Scenario(
        "frames lost until the watchdogs bite", "lose_frames", {"frames": 60}, cycles=70,
        health=("LOST",), reason="wheel_drive: SAFEOP with error 0x001B", steps=("ACKNOWLEDGE",),
        held="BUS", error_code=0x7500, events=("'code': 29952",),
    ),
    Scenario(
        "one answer lost", "lose_answers", {"frames": 1}, stops=False,
        health=("DEGRADED",), never=("LOST",), grows=("lost",),
    ),
    Scenario(
        "answers lost, slaves well", "lose_answers", {"frames": 30}, cycles=25,
        health=("LOST",), reason="no answer for", held="BUS", error_code=0x7500,
    ),
    Scenario(
        "answers late but in time", "delay", {"ms": 0.5}, stops=False,
        never=("LOST", "STALE"),
    ),
    Scenario(
        "answers later than a cycle", "delay", {"ms": 6.0},
        health=("LOST",), grows=("lost",), held="BUS", error_code=0x7500,
    ),
    Scenario(
        "answers held and released together", "hold", {}, cycles=24,
        health=("LOST", "STALE"), grows=("stale",), steps=("REOPEN",), held="BUS",
        error_code=0x7500,
    ),
    Scenario(
        "a wire that passes nothing", "wire_dead", {}, cycles=60,
        health=("LOST",), reason="cycles; coupler: no answer", steps=("ACKNOWLEDGE",), held="BUS",
        error_code=0x7500,
    ),
    Scenario(
        "link down on the far side", "link_down", {}, cycles=60,
        health=("LOST",), reason="no link: check the cable", steps=("ACKNOWLEDGE",), held="BUS",
        error_code=0x7500,
    ),
    Scenario(
        "working counter too small", "counter_offset", {"offset": -1},
        health=("LOST",), reason="working counter 10 of 11", grows=("wrong_counter",),
        held="BUS", error_code=0x7500,
    ),
    Scenario(
        "working counter too large", "counter_offset", {"offset": 2},
        health=("LOST",), reason="working counter 13 of 11", grows=("wrong_counter",),
        held="BUS", error_code=0x7500,
    ),
    # cable
    Scenario(
        "cable cut in front of the coupler", "cable_cut", {"behind": "master"}, cycles=60,
        health=("LOST",), reason="no answer for", held="BUS", error_code=0x7500,
    ),
    *(_cut(a, b) for a, b in zip(_CHAIN, _CHAIN[1:], strict=False)),
    # slaves that leave OP
    Scenario(
        "drive falls to SAFEOP with a sync error", "al_drop",
        {"slave": "wheel_drive", "state": "SAFEOP", "code": 0x001A},
        health=("SLAVE_FAULT",), reason="wheel_drive: SAFEOP with error 0x001A",
        steps=("ACKNOWLEDGE",), held="BUS", error_code=0x7500,
    ),
    Scenario(
        "terminal falls to SAFEOP with its maker's code", "al_drop",
        {"slave": "bridges_b", "state": "SAFEOP", "code": 0x8001},
        health=("SLAVE_FAULT",), reason="bridges_b: SAFEOP with error 0x8001",
        steps=("ACKNOWLEDGE",), held="BUS", error_code=0x7500,
    ),
    Scenario(
        "encoders fall to PREOP", "al_drop",
        {"slave": "encoders_a", "state": "PREOP", "code": 0x0002},
        health=("LOST",), reason="encoders_a: PREOP with error 0x0002",
        steps=("RECONFIGURE",), held="BUS", error_code=0x7500,
    ),
    Scenario(
        "outputs fall to INIT", "al_drop",
        {"slave": "digital_out", "state": "INIT", "code": 0x0001},
        health=("LOST",), reason="digital_out: INIT with error 0x0001",
        steps=("RECONFIGURE",), held="BUS", error_code=0x7500,
    ),
    Scenario(
        "drive restarts", "power_cycle", {"slave": "wheel_drive"},
        health=("LOST",), reason="wheel_drive", steps=("RECONFIGURE",), held="BUS",
        error_code=0x7500,
    ),
    Scenario(
        "bridge amplifier without power", "power_off", {"slave": "bridges_a"}, cycles=60,
        health=("LOST",), reason="bridges_a: no answer", held="BUS", error_code=0x7500,
    ),
    Scenario(
        "drive without power", "power_off", {"slave": "wheel_drive"}, cycles=60,
        health=("LOST",), reason="wheel_drive: no answer", held="BUS", error_code=0x7500,
    ),
    # mailbox
    Scenario(
        "mailbox hangs", "mailbox_hang", {"slave": "wheel_drive"}, stops=False, never=("LOST",),
        sdo="no answer within 20 ms",
    ),
    Scenario(
        "mailbox refuses", "mailbox_abort", {"slave": "wheel_drive"}, stops=False,
        never=("LOST",), sdo="refused, 0x08000000",
    ),
    Scenario(
        "mailbox answers late", "mailbox_late", {"slave": "wheel_drive", "ms": 60.0}, stops=False,
        never=("LOST",), sdo="no answer within 20 ms",
    ),
    Scenario(
        "emergency message alone", "emergency", {"slave": "wheel_drive", "code": 0x4210},
        stops=False, never=("LOST",), events=("'code': 16912",),
    ),
    # drive and machine
    Scenario(
        "drive trips: overcurrent", "drive_fault", {"code": 0x2310}, error_code=0x2310,
        never=("LOST",), events=("'code': 8976",),
    ),
    Scenario(
        "drive trips: encoder, cause stays", "drive_fault", {"code": 0x7305, "persists": True},
        error_code=0x7305, never=("LOST",), events=("'code': 29445",),
    ),
    Scenario(
        "shaft is stuck", "stuck_axis", {}, cycles=200, error_code=0x7121, never=("LOST",),
    ),
    Scenario(
        "emergency stop contact opens", "channel", {"name": "emergency_stop_ok", "value": 0},
        held="EMERGENCY_STOP", error_code=0xFF01, never=("LOST",),
    ),
    Scenario(
        "limit switch at the end of the road", "channel", {"name": "limit_front", "value": 1},
        held="LIMIT_SWITCH", error_code=0xFF02, never=("LOST",),
    ),
)  # fmt: skip
