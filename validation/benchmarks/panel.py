# SPDX-License-Identifier: Apache-2.0
"""Measures three open pages beside the graph at 250 Hz: lost cycles, update rate, memory.

`./flatplank bench-speed panel --minutes 120` runs for two hours; the default is two minutes.
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from diagnostic_msgs.msg import DiagnosticArray
from playwright.sync_api import Page, sync_playwright

from flatplank_control.bench.fast_dds import loopback_environment
from flatplank_control.nodes.client import BenchClient
from flatplank_hw.process import END_WITH_PARENT
from flatplank_msgs.srv import StartRecording, StopRecording
from realtime import wait

CHROMIUM = "/usr/bin/chromium"
FLAGS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
PAGES = 3
WANTED_HZ = 10
NODES = ("simulated_plant", "measurement_hub", "encoders", "wheel_drive", "recorder")
PANEL = "import sys; from flatplank_panel.cli.panel import main; sys.exit(main(sys.argv[1:]))"


def tree(pid: int) -> list[int]:
    """A process and all its descendants."""
    found = [pid]
    for thread in Path(f"/proc/{pid}/task").glob("*/children"):
        for child in thread.read_text().split():
            found += tree(int(child))
    return found


def memory(pids: list[int]) -> float:
    """Memory as proportional set size [MiB]."""
    total = 0
    for pid in pids:
        for line in Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines():
            if line.startswith("Pss:"):
                total += int(line.split()[1])
    return total / 1024


def browsers(parent: int) -> list[int]:
    """All browser processes that this process has started."""
    names = {pid: Path(f"/proc/{pid}/comm").read_text().strip() for pid in tree(parent)}
    return [pid for pid, name in names.items() if name.startswith("chrom")]


def start_bench(page: Page) -> None:
    page.get_by_role("button", name="Take charge", exact=True).click()
    page.get_by_role("button", name="Hand back", exact=True).wait_for()
    page.get_by_role("button", name="Start bench", exact=True).click()


def ticks(pages: list[Page]) -> list[int]:
    """Number of updates of each page since it was loaded; 0 while it reloads."""
    return [page.evaluate("globalThis.fp ? fp.ticks : 0") for page in pages]


def main(minutes: float = 2.0) -> None:
    os.environ.update(loopback_environment(), ROS_DOMAIN_ID=str(60 + os.getpid() % 40))
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        port = s.getsockname()[1]
    with tempfile.TemporaryDirectory() as folder, open(Path(folder) / "log", "wb") as log:
        server = subprocess.Popen(
            [
                sys.executable,
                "-c",
                PANEL,
                "--port",
                str(port),
                "--data",
                folder,
                "--token",
                "watch",
            ],
            env={**os.environ, END_WITH_PARENT: str(os.getpid())},
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=log,
        )
        try:
            watch(server.pid, f"http://127.0.0.1:{port}/?token=watch", minutes)
        finally:
            server.terminate()
            server.wait()


def watch(server: int, address: str, minutes: float) -> None:
    seen: dict[str, str] = {}

    def note(message: DiagnosticArray) -> None:
        for status in message.status:
            if status.name == "/simulated_plant":
                seen.update((v.key, v.value) for v in status.values)

    clean = {k: v for k, v in os.environ.items() if k != "LD_LIBRARY_PATH"}
    with sync_playwright() as playwright, BenchClient("panel_watcher") as client:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS, env=clean)
        pages = [browser.new_page(viewport={"width": 1440, "height": 900}) for _ in range(PAGES)]
        for page in pages:
            reach(page, address)
        start_bench(pages[0])
        client.wait_connected(NODES, 120.0)
        client.node.create_subscription(DiagnosticArray, "/diagnostics", note, 10)
        client.call(StartRecording, "/recorder/start", name="p", record="tire: TOY", at_once=True)
        wait(client, 10.0)
        before = int(seen["skipped"])
        print(f"{PAGES} pages beside the graph at 250 Hz, {minutes:g} min")
        print("  minute   updates/s of each page   server [MiB]   browser [MiB]")
        minutes_seen = []
        for minute in range(1, round(minutes) + 1):
            count, begun = ticks(pages), time.perf_counter()
            wait(client, 60.0)
            rates = [
                max(b - a, 0) / (time.perf_counter() - begun)
                for a, b in zip(count, ticks(pages), strict=True)
            ]
            text = "  ".join(f"{rate:5.2f}" for rate in rates)
            text += "  (0: stood still or was loaded anew)" if min(rates) == 0.0 else ""
            sizes = memory([server]), memory(browsers(os.getpid()))
            minutes_seen.append((min(rates), *sizes))
            print(f"  {minute:6d}   {text}   {sizes[0]:15.0f}   {sizes[1]:13.0f}", flush=True)
        print(f"  first and last minute: {compared(minutes_seen)}")
        done = client.call(StopRecording, "/recorder/stop", status="complete", timeout=30.0)
        dropped = int(seen["skipped"]) - before
        print(f"  cycles recorded {done.cycles_received}, lost {done.cycles_lost} (wanted: 0)")
        print(f"  cycles that the bus itself dropped: {dropped} (wanted: 0)")
        print(f"  drive command p99 {seen['command age p99']} cycles after its sample")
        browser.close()


def compared(minutes: list[tuple[float, float, float]]) -> str:
    """Compare the first and last minute: slowest page, memory of server and browser."""
    (rate, server, browser), (last, server_last, browser_last) = minutes[0], minutes[-1]
    return (
        f"updates/s {rate:.2f} -> {last:.2f} (wanted: at least {WANTED_HZ}), server "
        f"{server:.0f} -> {server_last:.0f} MiB, browser {browser:.0f} -> {browser_last:.0f} MiB"
    )


def reach(page: Page, address: str) -> None:
    """Open the page as soon as the server answers."""
    end = time.monotonic() + 60.0
    port = int(address.rsplit(":", 1)[1].strip("/"))
    while True:
        with socket.socket() as s:
            if s.connect_ex(("127.0.0.1", port)) == 0:
                break
        assert time.monotonic() < end, "the panel does not listen"
        time.sleep(0.05)
    page.goto(address)
    page.get_by_role("button", name="Take charge", exact=True).wait_for()


if __name__ == "__main__":
    main(*(float(word) for word in sys.argv[1:]))
