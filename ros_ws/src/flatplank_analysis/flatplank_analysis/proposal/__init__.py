# SPDX-License-Identifier: Apache-2.0
"""Effects outside the library: a grammar of effects, and the search for the best sentence."""
