# SPDX-License-Identifier: Apache-2.0
"""In real time samples must not wait for what Python does only once: it is done before the nodes
report that they are up."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from domains import loopback, next_domain

pytestmark = pytest.mark.graph


def test_first_line_and_first_bag_need_nothing_that_is_not_there(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "first_bag_node", "--ros-args", "-p", f"folder:={tmp_path}"],
        cwd=Path(__file__).parent,
        env={**os.environ, **loopback(next_domain())},
        capture_output=True,
        text=True,
    )
    assert (tmp_path / "first" / "metadata.yaml").is_file(), done.stderr
    assert json.loads(done.stdout.splitlines()[-1]) == []
