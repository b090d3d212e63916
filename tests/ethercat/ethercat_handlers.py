# SPDX-License-Identifier: Apache-2.0
"""The handlers of the bus, and how each is taken out to see which tests notice."""

from __future__ import annotations

from typing import NamedTuple


class Mutation(NamedTuple):
    """A handler that is taken out."""

    name: str
    file: str
    old: str
    new: str
    select: str
    """tests to run (-k)"""


MUTATIONS = (
    Mutation(
        "guard ignores the health of the bus",
        "master/guard.py",
        "if inputs is None or health not in (Health.OK, Health.DEGRADED):",
        "if inputs is None:",
        "fault or another_slave or long_cut or refused_until or near_side",
    ),
    Mutation(
        "guard does not latch",
        "master/guard.py",
        "self.latched[axis] = cause",
        "self.latched.pop(axis, None)",
        "fault or operators",
    ),
    Mutation(
        "guard ignores the emergency stop contact",
        "master/guard.py",
        "if not inputs.digital & Digital.EMERGENCY_STOP_OK:",
        "if False:",
        "emergency_stop or (fault and contact)",
    ),
    Mutation(
        "guard ignores old commands",
        "master/guard.py",
        "if cycle - command.cycle > self.timeout:",
        "if False:",
        "silent or node_killed",
    ),
    Mutation(
        "guard ignores limit switches",
        "master/guard.py",
        "closed & _LIMITS.get(axis, 0)",
        "False",
        "fault and limit",
    ),
    Mutation(
        "a stop is lifted without a reset",
        "master/guard.py",
        "if reset and not self._reset_seen.get(axis, True) and not cause:",
        "if not cause:",
        "fault or operators or silent",
    ),
    Mutation(
        "single losses are not tolerated",
        "master/health.py",
        "TOLERATED = 2",
        "TOLERATED = 0",
        "fault and lost",
    ),
    Mutation(
        "losses are never called lost",
        "master/health.py",
        "TOLERATED = 2",
        "TOLERATED = 10**9",
        "fault and (eight or counter or answers)",
    ),
    Mutation(
        "the working counter is not compared",
        "master/health.py",
        "good = seen.arrived and seen.counter == self.expected",
        "good = seen.arrived",
        "fault and counter",
    ),
    Mutation(
        "the echo is not compared",
        "master/health.py",
        "if seen.arrived and not seen.echo_ok:",
        "if False:",
        "fault and held",
    ),
    Mutation(
        "AL states are not read",
        "master/loop.py",
        "self.monitor.register_states(self.soem.states())\n        elif",
        "pass\n        elif",
        "(fault and SAFEOP) or refused_until",
    ),
    Mutation(
        "the socket is not reopened",
        "master/soem.py",
        "        self._master.close()\n        self.open()",
        "        return",
        "(fault and held) or foreign",
    ),
    Mutation(
        "slaves in SAFEOP are not brought back",
        "master/soem.py",
        'if slave.state & 0x0F == STATES["SAFEOP"] and self._set_watchdog(slave, spec):',
        "if False:",
        "fault and maker",
    ),
    Mutation(
        "slaves that lost their state are not configured again, nor is the bus scanned",
        "master/health.py",
        "return RecoveryStep.RECONFIGURE\n        return RecoveryStep.RESCAN",
        "return RecoveryStep.NONE\n        return RecoveryStep.NONE",
        "fault and (PREOP or INIT or restarts)",
    ),
    Mutation(
        "no full scan",
        "master/health.py",
        "return RecoveryStep.RESCAN",
        "return RecoveryStep.NONE",
        "long_cut or another_slave",
    ),
    Mutation(
        "identities are not checked",
        "master/interface.py",
        "same = (vendor, product) == (spec.vendor, spec.product)",
        "same = True",
        "identity or another_slave",
    ),
    Mutation(
        "no lock on the interface",
        "master/interface.py",
        "fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)",
        "pass",
        "second_master",
    ),
    Mutation(
        "watchdogs are not set",
        "master/soem.py",
        "ticks = self.bus.watchdog_ms * 1_000_000 // WATCHDOG_DIVIDER_NS",
        "ticks = 0",
        "killed or frozen",
    ),
    Mutation(
        "the death of the node is not noticed",
        "master/loop.py",
        "while self.running and not self.link.parent_gone:",
        "while self.running:",
        "node_killed",
    ),
    Mutation(
        "the bus ends without stopping the axes",
        "master/loop.py",
        "            self.run_cycle()\n        self._stop_axes()",
        "            self.run_cycle()",
        "stopping_the_bus",
    ),
    Mutation(
        "no images while the bus process is silent",
        "master/client.py",
        "return [self._invent(now)]",
        "return []",
        "bus_process_killed",
    ),
    Mutation(
        "SDO time-out of the library",
        "master/soem.py",
        "SDO_TIMEOUT_US = 20_000",
        "SDO_TIMEOUT_US = 700_000",
        "sdo_services or mailbox",
    ),
    Mutation(
        "mailboxes are not looked into",
        "master/soem.py",
        "            self._master.slaves[number].mbx_receive()",
        "            return",
        "fault and (message or trips)",
    ),
    Mutation(
        "a reset in a burst gets lost", "master/pacing.py", "shown.add(axis)", "pass", "burst"
    ),
    Mutation(
        "error codes of drives are not read",
        "master/image.py",
        "                    flat[a[5]],",
        "                    0,",
        "fault and (trips or stuck)",
    ),
    Mutation(
        "answers are not waited for",
        "master/soem.py",
        "ready, _, _ = select.select([self._fd], [], [], timeout_s)",
        "ready = []",
        "fault and time",
    ),
    Mutation(
        "the interface itself is not looked at",
        "master/loop.py",
        "self.monitor.link = link_trouble(self.soem.interface)",
        "pass",
        "link",
    ),
    Mutation(
        "refused SDOs are taken for silent ones",
        "master/soem.py",
        """f"{name}: refused, 0x{error.abort_code:08X} ({error.desc})\"""",
        """f"{name}: no answer\"""",
        "sdo_services or mailbox",
    ),
    Mutation(
        "missing slaves are not noticed",
        "master/interface.py",
        "if len(found) < len(bus.slaves):",
        "if False:",
        "slaves_missing or long_cut",
    ),
    Mutation(
        "slaves too many are not noticed",
        "master/interface.py",
        "if len(found) > len(bus.slaves):",
        "if False:",
        "too_many",
    ),
    Mutation(
        "an empty bus is not noticed",
        "master/interface.py",
        "if not found:",
        "if False:",
        "no_slaves",
    ),
    Mutation(
        "states are not asked for at the start",
        "master/soem.py",
        "        if wrong:\n",
        "        if False:\n",
        "state_refused_at_start",
    ),
    Mutation(
        "the reason of a refused configuration is not told",
        "master/soem.py",
        'return f"{name} refuses 0x{error.index:04X}:{error.subindex} ({error.desc})"',
        "return name",
        "configuration_refused",
    ),
    Mutation(
        "sizes of the process data are not compared",
        "master/soem.py",
        "if len(data) != (bits + 7) // 8:",
        "if False:",
        "pdos_differ",
    ),
    Mutation(
        "the interface is not looked for",
        "master/interface.py",
        "if name not in known:",
        "if False:",
        "no_such_interface",
    ),
    Mutation(
        "the length of the interface's name is not checked",
        "master/interface.py",
        "if len(name.encode()) > NAME_LIMIT:",
        "if False:",
        "name_too_long",
    ),
    Mutation(
        "rights are not checked",
        "master/__main__.py",
        "    check_permission()\n",
        "",
        "no_permission",
    ),
)
"""taken out one at a time"""
