# SPDX-License-Identifier: Apache-2.0
"""`flatplank_tire` by itself: pip installs it from a checkout, and it needs numpy alone."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import flatplank_tire
from flatplank_tire import shipped_tir, steady_forces, write_tir

SOURCE = Path(__file__).resolve().parents[2] / "ros_ws" / "src" / "flatplank_tire"
THREE_LINES = """
from flatplank_tire import read_tir, steady_forces
tire = read_tir("tire.tir")
print(*steady_forces(tire.coefficients, fz=4000.0, kappa=-0.03, alpha=0.05))
"""


@pytest.fixture(scope="module")
def alone(tmp_path_factory) -> str:
    """A search path with the package as pip puts it, with numpy, and with nothing else."""
    folder = tmp_path_factory.mktemp("alone")
    ignored = shutil.ignore_patterns("build", "*.egg-info", "__pycache__")
    copy = shutil.copytree(SOURCE, folder / "flatplank_tire", ignore=ignored)
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--no-compile"]
    command = [sys.executable, "-m", "pip", "install", *options, "--target", folder / "site", copy]
    subprocess.run(command, check=True, capture_output=True, timeout=110)
    (folder / "numpy_alone").mkdir()
    for one in Path(np.__file__).parents[1].glob("numpy*"):
        (folder / "numpy_alone" / one.name).symlink_to(one)
    return os.pathsep.join([str(folder / "site"), str(folder / "numpy_alone")])


def run(alone: str, folder: Path, code: str) -> str:
    """Output of Python without site packages (`-S`)."""
    env = {"PYTHONPATH": alone, "PATH": os.environ["PATH"]}
    if "LD_LIBRARY_PATH" in os.environ:
        env["LD_LIBRARY_PATH"] = os.environ["LD_LIBRARY_PATH"]
    command = [sys.executable, "-S", "-c", code]
    done = subprocess.run(command, env=env, cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_three_lines_give_forces(alone: str, tmp_path: Path) -> None:
    write_tir(shipped_tir(), tmp_path / "tire.tir")
    told = [float(word) for word in run(alone, tmp_path, THREE_LINES).split()]
    here = steady_forces(shipped_tir().coefficients, fz=4000.0, kappa=-0.03, alpha=0.05)
    np.testing.assert_array_equal(told, here)
    assert told[0] < -1000.0 and told[1] < -1000.0  # braked, and slipping to the left


def test_every_name_of_the_package_is_there_without_anything_else(alone: str, tmp_path: Path):
    code = "import flatplank_tire as t; print(all(callable(getattr(t, n)) for n in t.__all__))"
    assert run(alone, tmp_path, code).strip() == "True"


def test_an_error_needs_no_numpy(alone: str, tmp_path: Path) -> None:
    code = "import sys, flatplank_tire.errors; print('numpy' in sys.modules)"
    assert run(alone, tmp_path, code).strip() == "False"


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="flatplank_tire"):
        flatplank_tire.read_tyre  # noqa: B018
