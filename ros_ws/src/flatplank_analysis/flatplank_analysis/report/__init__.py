# SPDX-License-Identifier: Apache-2.0
"""Content of a campaign's report: results, tables, comparisons."""
