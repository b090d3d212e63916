# SPDX-License-Identifier: Apache-2.0
"""The report of a campaign as files: page, figures, tables and numbers."""
