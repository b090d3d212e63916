# SPDX-License-Identifier: Apache-2.0
"""Tests controllers and start of the bench against the truth of the simulated plant."""
