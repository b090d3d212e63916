# SPDX-License-Identifier: Apache-2.0
"""`python -m flatplank_sim.emulator.send SOCKET REQUEST [key=value ...]`: send one request."""

from __future__ import annotations

import json
import sys

from flatplank_sim.emulator.control import Control, ControlError


def value(text: str) -> object:
    """Parse numbers (also 0x...), true, false and lists; anything else is text."""
    try:
        return int(text, 0)
    except ValueError:
        pass
    try:
        return json.loads(text)
    except ValueError:
        return text


def main(arguments: list[str] | None = None) -> int:
    """Send one request and print its answer; exit code 2 and one line when refused."""
    words = sys.argv[1:] if arguments is None else arguments
    if len(words) < 2:
        print(
            "usage: send SOCKET REQUEST [key=value ...]; the request 'words' lists all",
            file=sys.stderr,
        )
        return 2
    pairs = dict(word.partition("=")[::2] for word in words[2:])
    try:
        answer = Control(words[0]).send(words[1], **{k: value(v) for k, v in pairs.items()})
    except (ControlError, OSError) as error:
        print(f"send: {error}", file=sys.stderr)
        return 2
    print(json.dumps(answer, indent=2))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
