# SPDX-License-Identifier: Apache-2.0
"""Search for an effect that is not in the library.

A sentence describes one effect: what it acts on (hook), over which coordinate, under which
condition (modulator), and with which shape. The grammar is the set of all sentences.
"""
