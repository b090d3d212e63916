# SPDX-License-Identifier: Apache-2.0
"""What the pinion encoder does not see of the road's travel, learnt from runs without slip."""

from flatplank_control.speed_map.learn import RoadMap, learn

__all__ = ["RoadMap", "learn"]
