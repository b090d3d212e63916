# SPDX-License-Identifier: Apache-2.0
"""Keys by which the operator tells the runner of a bench what he wants."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple


class Wish(NamedTuple):
    """What a key is for."""

    text: str
    service: str
    """of the runner"""


OF_A_RUN = {
    "c": Wish("confirm what was asked for", "confirm"),
    "e": Wish("enough: this run ends here and is kept", "enough"),
}
OF_A_CAMPAIGN = {
    **OF_A_RUN,
    "r": Wish("repeat this run from its beginning", "repeat"),
    "d": Wish("discard this run and go on", "discard"),
    "s": Wish("skip this run", "skip"),
}


def tell(client: Any, wishes: Mapping[str, Wish], key: str) -> None:
    """Pass the wish of a key on, and say what came of it; other keys are none."""
    if key not in wishes:
        return
    from std_srvs.srv import Trigger

    answer = client.call(Trigger, f"/measurement_runner/{wishes[key].service}")
    print(wishes[key].text if answer.success else answer.message, flush=True)
