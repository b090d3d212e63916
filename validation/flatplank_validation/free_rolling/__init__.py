# SPDX-License-Identifier: Apache-2.0
"""Linear and nonlinear models of the free-rolling loop: margins, settling, limit cycles."""
