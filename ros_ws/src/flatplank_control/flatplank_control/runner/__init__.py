# SPDX-License-Identifier: Apache-2.0
"""How a measurement is made, apart from the bench that it is made on."""
