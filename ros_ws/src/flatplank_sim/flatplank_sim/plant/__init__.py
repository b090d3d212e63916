# SPDX-License-Identifier: Apache-2.0
"""The simulated plant: drives, road, brush-model tire, hub, encoders, defects."""

from flatplank_sim.plant.config import PlantConfig, presets, tires
from flatplank_sim.plant.operator import Operator, OperatorView
from flatplank_sim.plant.plant import Plant

__all__ = ["Operator", "OperatorView", "Plant", "PlantConfig", "presets", "tires"]
