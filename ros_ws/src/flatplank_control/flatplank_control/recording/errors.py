# SPDX-License-Identifier: Apache-2.0
"""What goes wrong while recording, in one line."""


class RecordingError(ValueError):
    """What happened, where, and what to do."""


NOTHING = "nothing is being recorded; start first"
"""refusal to stop or discard"""
