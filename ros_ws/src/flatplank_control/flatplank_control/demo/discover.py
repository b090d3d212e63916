# SPDX-License-Identifier: Apache-2.0
"""The demo's sealed challenge: measure, fail, diagnose, add, watch the error fall, reveal."""
