# SPDX-License-Identifier: Apache-2.0
"""Kit for proposals: what the library lacks, hidden in worlds that share no code with it."""
