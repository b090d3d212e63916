# SPDX-License-Identifier: Apache-2.0
"""Topics between the nodes of one process: samples go there without the middleware.

The middleware still knows every publisher and subscription, and carries the same messages to and
from all other processes. With the participant property `fastdds.ignore_local_endpoints` it leaves
out what would stay within the process, so that nothing arrives twice.
"""

from __future__ import annotations

import os
import tempfile
import time
import xml.etree.ElementTree as ElementTree
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Receive = Callable[[Any], None]

PROFILES = ("FASTDDS_DEFAULT_PROFILES_FILE", "FASTRTPS_DEFAULT_PROFILES_FILE")
"""environment variables that name the profiles of Fast DDS; the first one prevails"""
NAMESPACE = "http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles"
IGNORE_LOCAL = "fastdds.ignore_local_endpoints"
DELIVERY_S = 0.004
"""longest delivery in one go [s]; services, timers and messages from outside come after it"""


class LocalTopics:
    """Topics within a process. Samples arrive in the order in which they were published, outside
    of the callback that publishes them.

    `call_later` asks the executor to call a function in its next round.
    """

    def __init__(self, call_later: Callable[[Callable[[], None]], Any]) -> None:
        self._call_later = call_later
        self._receivers: dict[str, list[Receive]] = {}
        self._readers: dict[str, list[Receive]] = {}
        """receivers of serialised samples"""
        self._publishers: dict[str, int] = {}
        self._kept: dict[str, tuple[Any, bytes]] = {}
        self._queue: deque[tuple[Receive, Any]] = deque()
        self._scheduled = False

    def subscribe(
        self, topic: str, receive: Receive, *, serialised: bool = False
    ) -> Callable[[], None]:
        """Receive the samples of a topic, or its messages `serialised`, a kept one at once.
        Returns a function that ends it."""
        receivers = (self._readers if serialised else self._receivers).setdefault(topic, [])
        receivers.append(receive)
        if topic in self._kept:
            self._put(receive, self._kept[topic][serialised])
        return lambda: receivers.remove(receive)

    def advertise(self, topic: str) -> Callable[[], None]:
        """Count a publisher of a topic; returns a function that ends this."""
        self._publishers[topic] = self.count_publishers(topic) + 1

        def end() -> None:
            self._publishers[topic] -= 1
            self._kept.pop(topic, None)

        return end

    def publish(self, topic: str, sample: Any, cdr: bytes, *, keep: bool = False) -> None:
        """Queue a sample for all that receive the topic, and its message `cdr` for those that
        receive this; `keep`: also for later ones."""
        if keep:
            self._kept[topic] = sample, cdr
        for receive in self._receivers.get(topic, ()):
            self._put(receive, sample)
        for receive in self._readers.get(topic, ()):
            self._put(receive, cdr)

    def serialised_for(self, topic: str) -> bool:
        """True when somebody receives the messages of a topic."""
        return bool(self._readers.get(topic))

    def count_subscribers(self, topic: str) -> int:
        return len(self._receivers.get(topic, ())) + len(self._readers.get(topic, ()))

    def count_publishers(self, topic: str) -> int:
        return self._publishers.get(topic, 0)

    def _put(self, receive: Receive, sample: Any) -> None:
        self._queue.append((receive, sample))
        if not self._scheduled:
            self._scheduled = True
            self._call_later(self.deliver)

    def deliver(self) -> None:
        """Deliver what is queued, for `DELIVERY_S` at most."""
        queue, end = self._queue, time.monotonic() + DELIVERY_S
        try:
            while queue:
                receive, sample = queue.popleft()
                receive(sample)
                if time.monotonic() > end:
                    break
        finally:
            self._scheduled = bool(queue)
            if queue:
                self._call_later(self.deliver)


@contextmanager
def ignore_local_endpoints() -> Iterator[bool]:
    """Let Fast DDS leave out what stays within a participant; to be entered before rclpy.init.

    Profiles that the environment names are kept; a ValueError names a file of profiles that cannot
    be read. The environment is as before at the end. Yields False with another middleware, which
    has no such property: then all samples take the way through the middleware.
    """
    if "fastrtps" not in os.environ.get("RMW_IMPLEMENTATION", "rmw_fastrtps_cpp"):
        yield False
        return
    before = {name: os.environ.get(name) for name in PROFILES}
    given = next(filter(None, before.values()), None)
    with tempfile.NamedTemporaryFile(suffix=".xml", prefix="flatplank-") as file:
        _with_property(given).write(file, encoding="utf-8", xml_declaration=True)
        file.flush()
        os.environ.update(dict.fromkeys(PROFILES, file.name))
        try:
            yield True
        finally:
            for name, value in before.items():
                if value is None:
                    del os.environ[name]
                else:
                    os.environ[name] = value


def _with_property(given: str | None) -> ElementTree.ElementTree:
    """The profiles of a file, or none; its default participant ignores local endpoints."""
    ElementTree.register_namespace("", NAMESPACE)
    try:
        root = (
            ElementTree.parse(given).getroot() if given else ElementTree.Element(_tag("profiles"))
        )
    except (OSError, ElementTree.ParseError) as error:
        raise ValueError(f"profiles of Fast DDS ({PROFILES[0]}): {given}: {error}") from None
    profiles = root if root.tag == _tag("profiles") else _child(root, "profiles")
    known = profiles.iter(_tag("participant"))
    element = next((p for p in known if p.get("is_default_profile") == "true"), None)
    if element is None:
        attributes = {"profile_name": "bench", "is_default_profile": "true"}
        element = ElementTree.SubElement(profiles, _tag("participant"), attributes)
    for name in ("rtps", "propertiesPolicy", "properties"):
        element = _child(element, name)
    entry = ElementTree.SubElement(element, _tag("property"))
    ElementTree.SubElement(entry, _tag("name")).text = IGNORE_LOCAL
    ElementTree.SubElement(entry, _tag("value")).text = "true"
    return ElementTree.ElementTree(root)


def _child(element: ElementTree.Element, name: str) -> ElementTree.Element:
    """The first child of this name, made when there is none."""
    found = element.find(_tag(name))
    return ElementTree.SubElement(element, _tag(name)) if found is None else found


def _tag(name: str) -> str:
    return f"{{{NAMESPACE}}}{name}"
