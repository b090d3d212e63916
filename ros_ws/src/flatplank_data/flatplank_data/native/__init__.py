# SPDX-License-Identifier: Apache-2.0
"""Parsers in a process of their own: a file that kills a parser does not kill the program."""
