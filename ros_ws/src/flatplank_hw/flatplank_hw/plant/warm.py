# SPDX-License-Identifier: Apache-2.0
"""Compile every kernel now, so that no later start waits for it: `python -m
flatplank_hw.plant.warm`.
"""

from __future__ import annotations

from flatplank_hw.plant.campaign import Campaign, CampaignRun
from flatplank_hw.plant.config import PlantConfig
from flatplank_hw.plant.plant import Plant
from flatplank_hw.plant.truth import truth_row


def warm() -> None:
    """One cycle, one short run, one row of truth."""
    config = PlantConfig.load()
    Plant(config).step()
    list(Campaign(config).simulate([CampaignRun(length=0.01)]))
    truth_row(config, config.tire.nominal_load, config.tire.nominal_pressure_bar)


if __name__ == "__main__":
    warm()
