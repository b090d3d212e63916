# SPDX-License-Identifier: Apache-2.0
"""The loop that measures until an answer is decided: settings, questions, choice, evidence."""
