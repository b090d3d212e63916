# SPDX-License-Identifier: Apache-2.0
"""Parameter sets that come with the package: thesis Table I.1, as tire property files."""
