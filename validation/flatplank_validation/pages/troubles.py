# SPDX-License-Identifier: Apache-2.0
"""Generates docs/reference/troubles.md from the registry:
`python -m flatplank_validation.pages.troubles FILE`."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from flatplank_hw.cia402 import ERROR_CODES
from flatplank_hw.drive.safety import HOLDING, STOPS
from flatplank_hw.troubles import SECTIONS, Trouble

CODES = {name: code for code, name in STOPS.items()}
HEAD = """\
# Troubles: what you see, what it means, what to do

Written by `python -m flatplank_validation.pages.troubles docs/reference/troubles.md`; a test
keeps it so. The log, `/diagnostics` and the messages say what is written here.

```
ros2 topic echo --once /diagnostics
ros2 topic echo --once /wheel_drive/status --field stop_text
```

The first shows every node with its troubles, the worst first. Level 0 is well, 1 a warning, 2 an
error, 3 a node that is not heard any more. The names of the troubles are in the value `troubles`.

Each occurrence is logged once by the node that sees it, in the launch terminal and on `/rosout`,
which is in the bag. It is in `/diagnostics` as long as it lasts. What is over at once stays in
`/diagnostics` for 10 s; the same again meanwhile is not logged again. The owner of the bus makes
one `/diagnostics` of what all nodes say on `/troubles`; without a bus each node says it in
`/diagnostics` itself.

The number behind *stops* or *waits* is `stop_reason` of a drive's status. A drive that was stopped
stays so until somebody enables it. What happens to the plank meanwhile:
[decisions/stopped-wheel.md](../decisions/stopped-wheel.md). The faults of the EtherCAT bus one by
one: [ethercat-faults.md](ethercat-faults.md).
"""


def _rows(troubles: dict[str, Trouble]) -> Iterator[str]:
    yield "| name | level | what you see | what it means | what to do |"
    yield "|---|---|---|---|---|"
    for name, t in troubles.items():
        level = t.level.name.lower()
        if name in CODES:
            kind = "waits" if CODES[name] in HOLDING else "stops"
            level = f"{level}, {kind}, {CODES[name]}"
        yield f"| `{name}` | {level} | {t.text} | {t.cause} | {t.remedy or '-'} |"


def page() -> str:
    """The whole file."""
    lines = [HEAD.rstrip("\n")]
    for title, troubles in SECTIONS.items():
        lines += ["", f"## {title}", "", *_rows(troubles)]
    lines += ["", "## Error codes of drives", "", "| code | what it means |", "|---|---|"]
    lines += [f"| 0x{code:04X} | {words} |" for code, words in ERROR_CODES.items()]
    return "\n".join(lines) + "\n"


def main(argv: list[str]) -> int:
    """Write the page."""
    Path(argv[0]).write_text(page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
