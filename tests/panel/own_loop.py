# SPDX-License-Identifier: Apache-2.0
"""Coroutines in a loop of their own: the browser keeps one running in the thread of the tests."""

from __future__ import annotations

import asyncio
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

Answer = TypeVar("Answer")
LIMIT_S = 300.0
"""no signal reaches the thread of the loop: what waits for ever there would hang the whole run"""


def finished(work: Coroutine[Any, Any, Answer]) -> Answer:
    """What a coroutine gives."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, asyncio.wait_for(work, LIMIT_S)).result()
