# SPDX-License-Identifier: Apache-2.0
"""The one-minute run goes on in the background while the other tests of this folder keep the
computer busy."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from ethercat_rig import Bench, namespace

HERE = Path(__file__).parent


@pytest.fixture(scope="session", autouse=True)
def stub_plants() -> Iterator[None]:
    """The emulator, a program of its own, finds the stub plants of this folder."""
    before = os.environ.get("PYTHONPATH")
    os.environ["PYTHONPATH"] = os.pathsep.join([str(HERE), *([before] if before else [])])
    yield
    if before is None:
        del os.environ["PYTHONPATH"]
    else:
        os.environ["PYTHONPATH"] = before


class Rig:
    """The bench of a module; after a test that has failed, a new one for the next test."""

    def __init__(self) -> None:
        self._bench: Bench | None = None

    def bench(self) -> Bench:
        if self._bench is None:
            self._bench = Bench()
            self._bench.unload()
        return self._bench

    def close(self) -> None:
        bench, self._bench = self._bench, None
        if bench is not None:
            bench.close()


@pytest.fixture(scope="module")
def rig() -> Iterator[Rig]:
    made = Rig()
    yield made
    made.close()


@pytest.fixture
def bench(rig: Rig, request: pytest.FixtureRequest) -> Iterator[Bench]:
    failed = request.session.testsfailed
    yield rig.bench()
    if request.session.testsfailed > failed:
        rig.close()


@pytest.fixture(scope="session")
def minute() -> Iterator[subprocess.Popen[str]]:
    """Started by the first test that asks, collected by the last one."""
    namespace().close()
    process = subprocess.Popen(
        [sys.executable, str(HERE / "ethercat_endurance.py"), "60", "250", "0"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    yield process
    if process.poll() is None:
        process.terminate()
    process.communicate()
