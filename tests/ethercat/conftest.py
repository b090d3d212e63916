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


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    rig = Bench()
    rig.unload()
    yield rig
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
