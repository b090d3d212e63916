# SPDX-License-Identifier: Apache-2.0
"""Evaluation of searches on the campaigns of the blind kit, which none of this makes."""
