# SPDX-License-Identifier: Apache-2.0
"""Identification of the Magic Formula in ordered stages."""
