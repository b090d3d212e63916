# SPDX-License-Identifier: Apache-2.0
"""Requests of the control socket: faults with timing, switches of the operator, queries."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from flatplank_data.names import nearest_hint
from flatplank_hw.bus.image import AXES
from flatplank_hw.ethercat.reader import check_integer
from flatplank_sim.emulator import registers as reg
from flatplank_sim.emulator.faults import FAULTS, FaultTargets, Undo


class RequestHandler:
    """Handler of requests. A request has `do`; faults take `at` (cycle) or `after`, and `cycles`
    (duration)."""

    def __init__(
        self, rig: FaultTargets, stop: Callable[[], None], facts: Callable[[], dict[str, Any]]
    ) -> None:
        self.rig = rig
        self._stop = stop
        self._undo: dict[str, list[Undo]] = {}
        self._facts = facts
        self._requests: dict[str, Callable[..., dict[str, Any]]] = {
            "mend": self._mend, "state": self._state, "motion": rig.bench.monitor.report,
            "operator": self._operator, "words": self._list, "stop": self._end,
        }  # fmt: skip

    def __call__(self, request: dict[str, Any]) -> dict[str, Any]:
        """Serve one request; a refusal raises ValueError or TypeError with the reason."""
        arguments = dict(request)
        name = str(arguments.pop("do", ""))
        if name in FAULTS:
            return self._fault(name, arguments)
        if name in self._requests:
            return self._requests[name](**arguments)
        known = [*FAULTS, *self._requests]
        raise ValueError(f"unknown request '{name}'{nearest_hint(name, known)}")

    def _fault(self, name: str, arguments: dict[str, Any]) -> dict[str, Any]:
        bench = self.rig.bench
        after = check_integer(arguments.pop("after", 0), "after")
        at = check_integer(arguments.pop("at", bench.cycle + after), "at")
        cycles = check_integer(arguments.pop("cycles", 0), "cycles")
        action = FAULTS[name](self.rig, **arguments)

        def apply() -> None:
            bench.monitor.fault(bench.now)
            undo = action()
            if undo is not None and cycles:
                bench.call_at(bench.cycle + cycles, undo)
            elif undo is not None:
                self._undo.setdefault(name, []).append(undo)

        bench.call_at(at, apply)
        return {"cycle": bench.cycle, "at": at}

    def _mend(self, fault: str = "") -> dict[str, Any]:
        """Undo one kind of fault, or all of them."""
        names = [fault] if fault else list(self._undo)
        mended = 0
        for name in names:
            for undo in self._undo.pop(name, []):
                undo()
                mended += 1
        return {"mended": mended, "cycle": self.rig.bench.cycle}

    def _state(self) -> dict[str, Any]:
        bench = self.rig.bench
        return {
            "cycle": bench.cycle,
            "now_ns": bench.now,
            **self._facts(),
            "wire": dict(self.rig.wire.counts),
            "drive_faults": {AXES[a]: d.fault for a, d in bench.coupling.drives.items()},
            "slaves": [
                {
                    "name": s.spec.name, "state": s.al.state.name, "error": s.al.error,
                    "code": s.al.code, "absent": s.absent,
                    "watchdog_trips": s.esc.memory[reg.WATCHDOG_COUNT],
                }
                for s in bench.slaves
            ],
        }  # fmt: skip

    def _operator(self, name: str, arguments: list[Any] | None = None) -> dict[str, Any]:
        """Call a switch of the plant's operator by its method name; 'view' returns what the
        operator sees."""
        operator = getattr(self.rig.bench.plant, "operator", None)
        known = [n for n in dir(operator) if not n.startswith("_")]
        if name not in known:
            raise ValueError(f"no operator's switch '{name}'{nearest_hint(name, known)}")
        switch = getattr(operator, name)
        if not callable(switch):
            return {"view": switch._asdict()}
        self.rig.bench.monitor.fault(self.rig.bench.now)
        switch(*(arguments or []))
        return {"cycle": self.rig.bench.cycle + 1}

    def _end(self) -> dict[str, Any]:
        self._stop()
        return {}

    def _list(self) -> dict[str, Any]:
        """Every request with the first line of its description."""
        texts = {n: (f.__doc__ or "").partition("\n")[0] for n, f in FAULTS.items()}
        return {"faults": texts, "words": sorted(self._requests)}
