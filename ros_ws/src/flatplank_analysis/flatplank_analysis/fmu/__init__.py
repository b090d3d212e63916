# SPDX-License-Identifier: Apache-2.0
"""A tire as a Functional Mock-up Unit (FMI 3.0): C made from the equations of `models`."""
