# SPDX-License-Identifier: Apache-2.0
"""Free-rolling controller, slip sequencer, recorder and measurement runner."""
