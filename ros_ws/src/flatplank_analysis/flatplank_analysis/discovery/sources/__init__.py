# SPDX-License-Identifier: Apache-2.0
"""What gives a floor: ranked sources, each with the most that a verdict may say on it."""
