# SPDX-License-Identifier: Apache-2.0
"""Controllers and start of the bench against the truth of the simulated plant."""
