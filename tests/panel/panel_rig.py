# SPDX-License-Identifier: Apache-2.0
"""A panel as its own process, a browser in front of it, and an observer of the graph behind it."""

from __future__ import annotations

import math
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from flatplank_hw.drive.params import DriveParameters
from flatplank_hw.nodes import convert
from flatplank_hw.process import END_WITH_PARENT
from flatplank_panel.access import address

CHROMIUM = "/usr/bin/chromium"
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
SILENCES = ("inputs", "samples", "reference")
"""rules of the drive that end a motion after some tenths of a second of silence"""
PATIENT = {
    "heartbeat_timeout": 3.0,
    "start_timeout": 5.0,
    "rules": [name for name in DriveParameters().rules if name not in SILENCES],
    "move_speed": DriveParameters().speed_limit,
}
"""parameters of a drive node that does not stop while the computer stalls, and turns to an angle
as fast as it may"""
WATCHDOG_CYCLES = 1000
"""of the simulated drive, which would report a fault after a shorter stall"""
BUS_HZ = 100
"""bus rate of the bench: low, so that the machine of a test has some room"""
TIMEOUT_S = 4.0
SHARE = 1.0
"""of their time that waits are given; less where nothing is expected to come"""
MOTOR_TURN = 2**23 * 1425.04
"""motor counts per turn of the wheel"""
WHEEL_TURN = 20_000
"""counts of the wheel's encoder per turn"""
REPLACE = """
def replace(owner, name, by):
    getattr(owner, name)  # another name would leave everything as it is
    setattr(owner, name, by)
"""
ACCEPTS = """
from flatplank_panel.nodes.panel import PanelNode
from flatplank_panel.link import Reply

async def accept(*_, **__):
    return Reply(True, "", {"token": "anybody"})

for name in ("ask", "measure", "cancel", "set_parameters"):
    replace(PanelNode, name, accept)
replace(PanelNode, "send_heartbeat", lambda *_: None)
"""
LATE = """
import asyncio
from flatplank_panel.operator import Operator

zero_taken = asyncio.Event()

async def constants(self):
    await asyncio.wait_for(zero_taken.wait(), 60.0)
    return {"et_value": 0.04, "adapter_thickness": 0.033}

async def tare(self, page):
    zero_taken.set()
    return self.add_to_log("the zero is taken")

replace(Operator, "constants", constants)
replace(Operator, "tare", tare)
"""
"""a bench that tells its constants when its zero is taken"""
SEES_NOTHING = """
from flatplank_panel.nodes.panel import PanelNode

replace(PanelNode, "take_samples", lambda _: None)
"""
IDLE = {
    "hands": REPLACE + ACCEPTS,
    "hands and answers": REPLACE + ACCEPTS + LATE,
    "eyes": REPLACE + SEES_NOTHING,
}
"""what a panel does not do -> Python that takes it away: it acts on nothing, or sees nothing"""


def free_port() -> int:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def wait_for(ask: Callable[[], Any], timeout: float = 15.0, what: str = "") -> Any:
    """The first true answer; AssertionError when none has come in time."""
    end = time.monotonic() + timeout * SHARE
    while not (answer := ask()):
        assert time.monotonic() < end, f"not within {timeout:g} s: {what}"
        time.sleep(0.02)
    return answer


def clean_environment() -> dict[str, str]:
    """Nothing in it tells the process that a test has started it."""
    kept = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST")}
    return kept | {END_WITH_PARENT: str(os.getpid())}


TOKEN = "token_of_the_tests"


@contextmanager
def panel_process(data: Path, *options: str, before: str = "") -> Iterator[str]:
    """`flatplank panel` on a free port; its address. `before`: Python that runs in it first."""
    port = free_port()
    command = [sys.executable, "-c", "import sys; from flatplank_panel.cli.panel import main; "]
    command[-1] += f"{before}\nsys.exit(main(sys.argv[1:]))"
    log = open(data.parent / f"panel_{port}.log", "wb")  # noqa: SIM115
    with log:
        process = subprocess.Popen(
            [*command, "--port", str(port), "--data", str(data), "--token", TOKEN, *options],
            env=clean_environment(),
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
        )
    try:

        def answers() -> bool:
            assert process.poll() is None, (data.parent / f"panel_{port}.log").read_text()
            with socket.socket() as s:
                return s.connect_ex(("127.0.0.1", port)) == 0

        wait_for(answers, 300.0, "the panel listens")  # one that has died is told at once
        yield address("127.0.0.1", port, TOKEN)
    finally:
        process.send_signal(signal.SIGINT)
        try:
            process.wait(15.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def analysts(parent: int | None = None) -> set[int]:
    """Processes below this one that work for the page Discover or Runs."""
    found = set()
    for thread in Path(f"/proc/{parent or os.getpid()}/task").glob("*/children"):
        for child in map(int, thread.read_text().split()):
            if "panel.analysis.worker" in Path(f"/proc/{child}/cmdline").read_text():
                found.add(child)
            found |= analysts(child)
    return found


def shows(who, campaign: str) -> None:
    """Choose a campaign on the page Discover."""
    box = who.page.get_by_label("Campaign", exact=True).first
    wait_for(lambda: box.input_value() or True, what="campaigns are listed")
    box.click()
    who.page.get_by_role("option").filter(has_text=campaign).first.click()


def lift_and_go_back(who, observer: Observer) -> None:
    """Wheel lifted, plank at rest at its beginning."""
    who.tab("Machine")
    who.click("Lift the wheel")
    observer.wait(lambda: observer.lifted, 40.0, "the wheel is lifted")
    who.click("Plank back")
    observer.wait(lambda: observer.at_beginning, 60.0, "the plank is back")


def status(who) -> str:
    """What the page Discover says of its work."""
    return who.page.get_by_role("status").first.text_content() or ""


class Observer:
    """Sees the raw image of the bus and the samples, without the panel: the judge of the tests."""

    def __init__(self) -> None:
        from geometry_msgs.msg import WrenchStamped

        from flatplank_control.nodes.client import BenchClient
        from flatplank_msgs.msg import BusInputs, DriveStatus, EncoderState, HubState

        self.client = BenchClient("panel_observer")
        self.latest: dict[str, Any] = {}
        kinds = {
            "inputs": (BusInputs, "/bus/inputs"),
            "contact": (WrenchStamped, "/measurement_hub/wrench_contact"),
            "wheel": (WrenchStamped, "/measurement_hub/wrench_wheel"),
            "hub": (HubState, "/measurement_hub/state"),
            "encoders": (EncoderState, "/encoders/state"),
            "drive": (DriveStatus, "/wheel_drive/status"),
        }
        for key, (kind, topic) in kinds.items():
            self.client.node.create_subscription(
                kind, topic, lambda m, key=key: self.latest.__setitem__(key, m), 5
            )

    def close(self) -> None:
        self.client.__exit__(None, None, None)

    def look(self, seconds: float = 0.05) -> None:
        """Take what comes for a while."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.client.spin(0.01)

    def wait(
        self,
        ask: Callable[[], Any],
        timeout: float = 15.0,
        what: str = "",
        again: Callable[[], Any] | None = None,
    ) -> Any:
        """`again`: what an operator does anew every few seconds, because the drive has
        stopped: its limits are tenths of a second, and machines that run tests stall longer."""
        tried = time.monotonic()

        def answer() -> Any:
            nonlocal tried
            self.look()
            if again and time.monotonic() - tried > TIMEOUT_S:
                again()
                tried = time.monotonic()
            return ask()

        return wait_for(answer, timeout, what)

    def fresh(self) -> None:
        """Only what comes from now on."""
        self.latest.clear()
        self.wait(lambda: len(self.latest) == 6, 20.0, "all topics speak")

    # at the plant
    @property
    def inputs(self) -> Any:
        return convert.inputs_from_msg(self.latest["inputs"]).cycles[-1]

    @property
    def running(self) -> bool:
        """The bus goes on."""
        self.look(0.1)  # takes what a bus that has ended said last
        self.latest.pop("inputs", None)
        self.look(0.3)
        return "inputs" in self.latest

    @property
    def lifted(self) -> bool:
        """The tire is clear of the road."""
        return self.latest["hub"].loaded_radius > 0.326

    @property
    def at_beginning(self) -> bool:
        """The plank rests at its beginning."""
        plank = self.latest["encoders"]
        return not plank.plank_moving and plank.plank_position < 0.01

    def shaft(self) -> float:
        """Angle by the raw counts of the wheel's encoder, over many turns [deg]."""
        return 360.0 * self.inputs.wheel_counts / WHEEL_TURN

    def force(self, axis: str) -> float:
        """At the contact point [N]."""
        return getattr(self.latest["contact"].wrench.force, axis)

    def speed(self) -> float:
        """Of the wheel by the raw counts of the motor, over some 0.3 s [rad/s]."""
        self.look(0.02)
        a, at = self.inputs.axes[0].position, self.inputs.stamp_ns
        self.wait(lambda: self.inputs.stamp_ns - at > 3e8, what="cycles go on")
        b = self.inputs.axes[0].position
        moved = (b - a + 2**31) % 2**32 - 2**31
        return math.tau * moved / MOTOR_TURN / ((self.inputs.stamp_ns - at) * 1e-9)

    def enabled(self) -> bool:
        """Operation enabled, by the status word on the bus."""
        return self.inputs.axes[0].status_word & 0x6F == 0x27
