# SPDX-License-Identifier: Apache-2.0
"""Responses of the services of the bench."""

from __future__ import annotations

from typing import Any

LONGEST = 600
"""most characters of a reason"""


def shorten(text: str, most: int) -> str:
    """The text, or its begin and its end."""
    half = most // 2
    return text if len(text) <= most else f"{text[:half]} ... {text[-half:]}"


def fill_response(
    response: Any, accepted: bool, reason: str, cycle: int = 0, **fields: Any
) -> Any:
    """Fill a service response of the bench or std_srvs; `cycle`: first cycle with the effect. A
    reason is one line, whatever was asked for."""
    reason = shorten(" ".join(reason.split()), LONGEST)
    if hasattr(response, "success"):
        response.success, response.message = accepted, reason
        return response
    response.accepted, response.reason = accepted, reason
    if hasattr(response, "cycle"):
        response.cycle = max(cycle, 0)
    for name, value in fields.items():
        setattr(response, name, value)
    return response
