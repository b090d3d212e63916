# SPDX-License-Identifier: Apache-2.0
"""Slip sequencer: waveforms of slip over the road."""

from flatplank_control.sequencer.params import SequencerParameters
from flatplank_control.sequencer.sequencer import SequencerState, SlipSequencer

__all__ = ["SequencerParameters", "SequencerState", "SlipSequencer"]
