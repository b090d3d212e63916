# SPDX-License-Identifier: Apache-2.0
"""What a report tells of a campaign: results, tables, comparisons."""
