# SPDX-License-Identifier: Apache-2.0
"""Constants of the set-up that the operator changes: parameters of the nodes that use them."""

from __future__ import annotations

from typing import NamedTuple

from flatplank_data.params import ParamInfo, describe
from flatplank_hw.encoders import EncoderParameters
from flatplank_hw.encoders.params import SETUP_CONSTANTS as OF_ENCODERS
from flatplank_hw.hub import HubParameters
from flatplank_hw.hub.params import SETUP_CONSTANTS as OF_HUB


class Constant(NamedTuple):
    """One constant and the node that uses it."""

    node: str
    info: ParamInfo

    @property
    def name(self) -> str:
        return self.info.name


def _of(node: str, cls: type, names: tuple[str, ...]) -> list[Constant]:
    return [Constant(node, info) for info in describe(cls) if info.name in names]


CONSTANTS = {
    c.name: c
    for c in (
        *_of("measurement_hub", HubParameters, OF_HUB),
        *_of("encoders", EncoderParameters, OF_ENCODERS),
    )
}
"""name -> constant"""
