# SPDX-License-Identifier: Apache-2.0
"""Run under .venv at the end of the set-up: `warm.py kernels` compiles the inner loops into their
caches, `warm.py modules` leaves the byte code of what bench and demo import.
"""

from __future__ import annotations

import compileall
import sys
from importlib import import_module

from workspace import MESSAGES, package_stamps


def kernels() -> None:
    """Machine code of the simulated plant and of the analysis."""
    from flatplank_analysis.kernels import compile_all
    from flatplank_sim.plant import Plant, PlantConfig
    from flatplank_sim.plant.campaign import Campaign, CampaignRun

    config = PlantConfig.load("toyo")
    Plant(config, seed=1, rate_hz=250).step()
    next(Campaign(config).simulate([CampaignRun(length=0.0)]))
    compile_all()
    write_byte_code()


def modules() -> None:
    """What the nodes and the demo import."""
    from flatplank_control.bench.setup import BenchSetup

    for node in BenchSetup().nodes():
        import_module(f"{node.package}.nodes.{node.executable}")
    for name in ("flatplank_sim.cli.demo", "flatplank_control.nodes.client"):
        import_module(name)
    write_byte_code()
    for name in set(package_stamps()) - {MESSAGES}:
        compileall.compile_dir(import_module(name).__path__[0], quiet=2)


def write_byte_code() -> None:
    """Of every module that was imported, also where PYTHONDONTWRITEBYTECODE is set."""
    for module in list(sys.modules.values()):
        source = getattr(module, "__file__", None)
        if source and source.endswith(".py"):
            compileall.compile_file(source, quiet=2)


if __name__ == "__main__":
    {"kernels": kernels, "modules": modules}[sys.argv[1]]()
