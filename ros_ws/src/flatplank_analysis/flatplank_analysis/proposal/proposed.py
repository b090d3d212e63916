# SPDX-License-Identifier: Apache-2.0
"""What effect files import that earlier versions of `flatplank propose` wrote and a person has
edited since: Python like any other effect file. An unedited one is read as data
(`effects/grammar/former.py`)."""

from __future__ import annotations

from flatplank_analysis.discovery.parameters import param
from flatplank_analysis.effects.base import Motion, Signal, Tire
from flatplank_analysis.effects.force_channel import shifted
from flatplank_analysis.effects.grammar.proposed import Proposed
from flatplank_analysis.effects.grammar.shapes.base import follow, play

__all__ = ["Motion", "Proposed", "Signal", "Tire", "follow", "param", "play", "shifted"]
