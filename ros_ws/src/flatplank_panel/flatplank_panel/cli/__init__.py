# SPDX-License-Identifier: Apache-2.0
"""The verb of the page, registered in setup.cfg."""
