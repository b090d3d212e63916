# SPDX-License-Identifier: Apache-2.0
"""Import of bags into measurement tables against the `mcap` package that reads the same messages
and drops them. The cache is not used.

    python -m flatplank_validation.fits.bag_import CAMPAIGN_OF_BAGS
"""

from __future__ import annotations

import time
from pathlib import Path

from mcap.reader import make_reader

from flatplank_data.bags.topics import RUN_TOPIC, topic_map
from flatplank_data.errors import FlatplankError
from flatplank_data.readers.bag import import_bag
from flatplank_validation.fits.command import command


def bags_of(folder: Path) -> list[Path]:
    """Bag folders below `folder`."""
    return sorted({path.parent for path in folder.rglob("*.mcap")})


def drop_all(bag: Path, topics: list[str]) -> int:
    """Read and discard every message of the topics with `mcap`; returns their number."""
    count = 0
    for path in sorted(bag.glob("*.mcap")):
        with path.open("rb") as stream:
            for _ in make_reader(stream).iter_messages(topics=topics):
                count += 1
    return count


def measure(folder: Path, repeats: int = 3) -> dict[str, float]:
    """Best times over all bags [s], their ratio, and runs per minute."""
    bags = bags_of(folder)
    if not bags:
        raise FlatplankError("no bag", str(folder), "name a folder with .mcap bags")
    topics = topic_map(None)
    wanted = [*topics.sources, RUN_TOPIC]
    ours, theirs, messages = [], [], 0
    for _ in range(repeats):
        begin = time.perf_counter()
        for bag in bags:
            import_bag(bag, topics)
        middle = time.perf_counter()
        messages = sum(drop_all(bag, wanted) for bag in bags)
        ours.append(middle - begin)
        theirs.append(time.perf_counter() - middle)
    return {
        "runs": len(bags),
        "messages": messages,
        "time_s": min(ours),
        "mcap_time_s": min(theirs),
        "ratio": min(theirs) / min(ours),
        "runs_per_minute": 60.0 * len(bags) / min(ours),
    }


main = command(__doc__, lambda chosen: measure(chosen.folder), folder=Path)

if __name__ == "__main__":
    main()
