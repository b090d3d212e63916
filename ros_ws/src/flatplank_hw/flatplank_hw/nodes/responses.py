# SPDX-License-Identifier: Apache-2.0
"""Responses of the services of the bench."""

from __future__ import annotations

from typing import Any


def fill_response(
    response: Any, accepted: bool, reason: str, cycle: int = 0, **fields: Any
) -> Any:
    """Fill a service response of the bench or std_srvs; `cycle`: first cycle with the effect."""
    if hasattr(response, "success"):
        response.success, response.message = accepted, reason
        return response
    response.accepted, response.reason = accepted, reason
    if hasattr(response, "cycle"):
        response.cycle = max(cycle, 0)
    for name, value in fields.items():
        setattr(response, name, value)
    return response
