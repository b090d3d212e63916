# SPDX-License-Identifier: Apache-2.0
"""The web application: routes, access guard, and two periodic tasks (live data, supervision of who
is in charge)."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from nicegui import Client, app, background_tasks, core, ui

from flatplank_panel.access import Guard
from flatplank_panel.charge import HOLDER_TIMEOUT_S
from flatplank_panel.investigation import Investigation
from flatplank_panel.live import EVENT, PUSH_HZ, LiveData
from flatplank_panel.operator import Operator
from flatplank_panel.service import AnalysisService
from flatplank_panel.views import bench, catalogue, discover, investigate, runs, shell
from flatplank_panel.views.page import Page

STATIC = Path(__file__).parent / "static"
SUPERVISE_HZ = 5


def serve(operator: Operator, service: AnalysisService, host: str, port: int, token: str) -> None:
    """Serve until the process is told to end."""
    live = LiveData(operator.link.state)
    investigation = Investigation(service, operator)
    tabs: dict[str, Callable[[Page], None]] = {
        "Bench": bench.build,
        "Runs": runs.build,
        "Catalogue": catalogue.build,
        "Discover": discover.build,
        "Investigate": partial(investigate.build, investigation=investigation),
    }
    app.add_static_files("/assets", STATIC, max_cache_age=0)
    app.add_middleware(Guard, host=host, token=token)

    async def show(page: Page, tab: str) -> None:
        shell.build(page, tabs, tab if tab in tabs else next(iter(tabs)))
        await page.client.connected()
        page.client.run_javascript(live.start())

    @ui.page("/", title="Flat Plank")
    async def index(client: Client, tab: str = "") -> None:
        await show(Page(operator, service, client), tab)

    @ui.page("/discover/{campaign:path}", title="Flat Plank")
    async def discovery(
        client: Client, campaign: str, condition: str = "", over: str = ""
    ) -> None:
        await show(Page(operator, service, client, (campaign, condition, over)), "Discover")

    async def push() -> None:
        due = time.monotonic()
        while True:
            # fixed schedule: the duration of a push does not delay the next one
            due = max(due + 1.0 / PUSH_HZ, time.monotonic())
            await asyncio.sleep(due - time.monotonic())
            message = live.tick()
            for client in list(Client.instances.values()):
                if client.has_socket_connection:
                    await core.sio.emit(EVENT, message, room=client.id)

    async def supervise() -> None:
        while True:
            await asyncio.sleep(1.0 / SUPERVISE_HZ)
            await operator.supervise()
            operator.log_ended_nodes()

    def begin() -> None:
        background_tasks.create(push(), name="live data")
        background_tasks.create(supervise(), name="charge")

    app.on_startup(begin)
    app.on_shutdown(operator.host.stop)
    app.on_shutdown(service.close)
    ui.run(
        host=host, port=port, title="Flat Plank", favicon="⏺", dark=None, reload=False, show=False,
        show_welcome_message=False, reconnect_timeout=HOLDER_TIMEOUT_S,
    )  # fmt: skip
