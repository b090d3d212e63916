# SPDX-License-Identifier: Apache-2.0
"""Blind test of the discovery: campaigns whose answer is known, made without any analysis code."""
