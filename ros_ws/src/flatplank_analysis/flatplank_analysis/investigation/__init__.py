# SPDX-License-Identifier: Apache-2.0
"""The loop that measures until the diagnosis is decided: settings, questions, choice, evidence."""
