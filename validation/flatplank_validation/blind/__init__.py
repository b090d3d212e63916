# SPDX-License-Identifier: Apache-2.0
"""Blind test of the diagnosis: campaigns with known answers, made without any analysis code."""
