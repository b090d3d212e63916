# SPDX-License-Identifier: Apache-2.0
"""The search for missing effects as one probability model: sets of effects and their posterior."""
