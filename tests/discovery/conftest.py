# SPDX-License-Identifier: Apache-2.0
"""What always holds is asked of every diagnosis that any test of the search makes."""

from __future__ import annotations

import pytest
from promises import broken

from flatplank_analysis.discovery import verdict


@pytest.fixture(autouse=True)
def every_answer_keeps_what_always_holds(monkeypatch, request):
    """Diagnoses are asked as they are made; `verdict.diagnose` is what all verbs call."""
    whole = verdict.diagnose

    def asked(*arguments, **named):
        result = whole(*arguments, **named)
        assert broken(result) == [], (result.verdict, result.reason)
        return result

    for module in (verdict, request.module):
        if getattr(module, "diagnose", None) is whole:
            monkeypatch.setattr(module, "diagnose", asked)
