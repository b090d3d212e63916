# SPDX-License-Identifier: Apache-2.0
"""The analysis on a laptop: pip installs three packages of the checkout, and none needs ROS."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "ros_ws" / "src"
PACKAGES = ("flatplank_tire", "flatplank_data", "flatplank_analysis")
COMMAND = "pip install " + " ".join(f"./ros_ws/src/{name}" for name in PACKAGES)
USE = """
import importlib.resources
import sys
import flatplank_analysis as fp
from flatplank_analysis.cli.verbs import installed
runs = fp.load(sys.argv[1])
assert len(runs) == 1, runs
assert {"fit", "diagnose"} <= installed().keys()
assert not {"rclpy", "flatplank_hw"} & sys.modules.keys()
assert fp.__version__[0].isdigit()
assert importlib.resources.files("flatplank_data").joinpath("py.typed").is_file()
assert importlib.resources.files("flatplank_analysis").joinpath("py.typed").is_file()
print(fp.__file__)
"""


@pytest.fixture(scope="module")
def laptop(tmp_path_factory) -> Path:
    """A folder with the packages as pip puts them; built from copies, which pip writes into."""
    folder = tmp_path_factory.mktemp("laptop")
    copies = []
    for name in PACKAGES:
        ignored = shutil.ignore_patterns("build", "*.egg-info", "__pycache__")
        copies.append(shutil.copytree(SOURCES / name, folder / name, ignore=ignored))
    options = ["--quiet", "--no-deps", "--no-build-isolation", "--no-index", "--no-compile"]
    command = [sys.executable, "-m", "pip", "install", *options, "--target", folder / "site"]
    subprocess.run([*command, *copies], check=True, capture_output=True, timeout=110)
    return folder / "site"


def test_what_is_installed_reads_a_campaign(laptop: Path, tmp_path: Path) -> None:
    rows = "time,plank_position,wheel_angle,fx,fz\n" + "".join(
        f"{i / 250},{i * 1e-4},{i * 3e-4},0.0,3700.0\n" for i in range(100)
    )
    (tmp_path / "run.csv").write_text(rows)
    env = {k: v for k, v in os.environ.items() if not k.startswith(("AMENT", "ROS", "LD_"))}
    done = subprocess.run(
        [sys.executable, "-c", USE, tmp_path],
        env=env | {"PYTHONPATH": str(laptop)}, cwd=tmp_path, capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()).is_relative_to(laptop)


@pytest.mark.parametrize("page", ["README.md", "docs/guide/python.md"])
def test_the_pages_say_how(page: str) -> None:
    assert COMMAND in (ROOT / page).read_text(encoding="utf-8")
