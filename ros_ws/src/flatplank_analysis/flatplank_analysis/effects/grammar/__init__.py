# SPDX-License-Identifier: Apache-2.0
"""The grammar of proposals: where an effect acts, over which coordinate, in which form, and when.

A proposal is a sentence of this grammar: data, which are read and written without running any
code of a file.
"""
