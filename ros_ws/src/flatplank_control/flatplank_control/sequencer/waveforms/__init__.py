# SPDX-License-Identifier: Apache-2.0
"""The waveforms: one file each, one line of registration here."""

from flatplank_control.sequencer.waveforms.base import MAX_SLIP, Waveform
from flatplank_control.sequencer.waveforms.constant import Constant
from flatplank_control.sequencer.waveforms.double_step import DoubleStep
from flatplank_control.sequencer.waveforms.sine import Sine
from flatplank_control.sequencer.waveforms.step import Step
from flatplank_control.sequencer.waveforms.triangle import Triangle

WAVEFORMS: dict[str, type[Waveform]] = {
    waveform.name: waveform for waveform in (Constant, Step, DoubleStep, Sine, Triangle)
}

__all__ = ["MAX_SLIP", "WAVEFORMS", "Waveform"]
