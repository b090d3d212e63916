# SPDX-License-Identifier: Apache-2.0
"""The defects of the machine, by the part that has them (thesis, chapter 3)."""

from flatplank_sim.plant.defects.base import Defect, Site
from flatplank_sim.plant.defects.registry import build_defects, defects, describe

__all__ = ["Defect", "Site", "build_defects", "defects", "describe"]
