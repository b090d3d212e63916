# SPDX-License-Identifier: Apache-2.0
"""Pages that open offline: one design for report, diagnosis, proposal and investigation."""
