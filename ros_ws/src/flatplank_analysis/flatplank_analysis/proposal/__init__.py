# SPDX-License-Identifier: Apache-2.0
"""Beyond the library: a grammar of effects, and the search for the sentence that fits."""
