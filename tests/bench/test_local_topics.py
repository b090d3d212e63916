# SPDX-License-Identifier: Apache-2.0
"""Topics within a process: order, turns, kept samples, and the profile that keeps the middleware
from delivering the same again."""

from __future__ import annotations

import os
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from flatplank_control.bench.fast_dds import PROFILE
from flatplank_control.nodes import loop
from flatplank_hw.nodes import local
from flatplank_hw.nodes.local import IGNORE_LOCAL, PROFILES, LocalTopics, ignore_local_endpoints


class Rounds:
    """An executor that makes one round at a time."""

    def __init__(self) -> None:
        self.due: list = []
        self.topics = LocalTopics(self.due.append)

    def run(self) -> int:
        """Make rounds until nothing is due; returns their number."""
        count = 0
        while self.due:
            count += 1
            for call in [self.due.pop(0) for _ in range(len(self.due))]:
                call()
        return count


def test_samples_arrive_in_the_order_of_publication_and_after_the_callback() -> None:
    rounds, seen = Rounds(), []
    topics = rounds.topics

    def answer(sample: int) -> None:
        topics.publish("answers", 10 * sample, b"")
        seen.append(f"question {sample}")

    topics.subscribe("questions", answer)
    topics.subscribe("answers", lambda sample: seen.append(f"answer {sample}"))
    topics.publish("questions", 1, b"")
    topics.publish("questions", 2, b"")
    assert seen == []
    rounds.run()
    assert seen == ["question 1", "question 2", "answer 10", "answer 20"]


def test_an_endless_exchange_lets_others_have_their_turn(monkeypatch) -> None:
    rounds = Rounds()
    monkeypatch.setattr(local, "DELIVERY_S", -1.0)  # one sample at a time
    rounds.topics.subscribe("ball", lambda n: n and rounds.topics.publish("ball", n - 1, b""))
    rounds.topics.publish("ball", 5, b"")
    assert rounds.run() == 6


def test_a_failing_receiver_loses_only_its_own_sample() -> None:
    rounds, seen = Rounds(), []

    def receive(sample: int) -> None:
        if sample == 1:
            raise ValueError("one")
        seen.append(sample)

    rounds.topics.subscribe("x", receive)
    for sample in (1, 2):
        rounds.topics.publish("x", sample, b"")
    with pytest.raises(ValueError, match="one"):
        rounds.run()
    rounds.run()
    assert seen == [2]


def test_a_kept_sample_reaches_those_who_come_later() -> None:
    rounds, seen = Rounds(), []
    end = rounds.topics.advertise("mode")
    rounds.topics.publish("mode", "slip", b"", keep=True)
    rounds.topics.publish("mode", "torque", b"", keep=True)
    rounds.topics.subscribe("mode", seen.append)
    rounds.run()
    assert seen == ["torque"]
    end()
    rounds.topics.subscribe("mode", seen.append)
    rounds.run()
    assert seen == ["torque"], "its publisher is gone"


def test_partners_are_counted_as_long_as_they_are_there() -> None:
    topics = Rounds().topics
    end = topics.subscribe("x", print)
    gone = topics.advertise("x")
    assert (topics.count_subscribers("x"), topics.count_publishers("x")) == (1, 1)
    end()
    gone()
    assert (topics.count_subscribers("x"), topics.count_publishers("x")) == (0, 0)


def properties(file: str) -> list[str | None]:
    return [e.text for e in ElementTree.parse(file).iter() if e.tag.endswith("}name")]


@pytest.mark.parametrize("given", [None, PROFILE])
def test_the_profile_ignores_local_endpoints_and_keeps_what_was_there(given, monkeypatch) -> None:
    for name in PROFILES:
        monkeypatch.delenv(name, raising=False)
    if given:
        monkeypatch.setenv(PROFILES[1], str(given))
    around = dict(os.environ)
    with ignore_local_endpoints() as local_only:
        assert local_only
        files = {os.environ[name] for name in PROFILES}
        (file,) = files
        assert properties(file) == [IGNORE_LOCAL]
        before = {e.tag for e in ElementTree.parse(given).iter()} if given else set()
        assert before <= {e.tag for e in ElementTree.parse(file).iter()}
    assert not Path(file).exists()
    assert dict(os.environ) == around


@pytest.mark.parametrize("text", [None, "<profiles>"], ids=["no file", "torn"])
def test_profiles_that_cannot_be_read_are_named(text, tmp_path, monkeypatch, capsys) -> None:
    file = tmp_path / "profiles.xml"
    if text:
        file.write_text(text)
    monkeypatch.setenv(PROFILES[0], str(file))
    assert loop.main(["loop", "--ros-args"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert str(file) in line and PROFILES[0] in line


def test_another_middleware_delivers_everything_itself(monkeypatch) -> None:
    monkeypatch.setenv("RMW_IMPLEMENTATION", "rmw_cyclonedds_cpp")
    before = dict(os.environ)
    with ignore_local_endpoints() as local_only:
        assert not local_only
        assert dict(os.environ) == before


def test_messages_and_samples_of_one_topic_go_to_those_who_want_them() -> None:
    rounds, samples, messages = Rounds(), [], []
    topics = rounds.topics
    assert not topics.serialised_for("x")
    topics.subscribe("x", samples.append)
    end = topics.subscribe("x", messages.append, serialised=True)
    assert topics.serialised_for("x") and topics.count_subscribers("x") == 2
    topics.publish("x", 1, b"one", keep=True)
    rounds.run()
    assert (samples, messages) == ([1], [b"one"])
    later: list = []
    topics.subscribe("x", later.append, serialised=True)
    rounds.run()
    assert later == [b"one"], "kept"
    end()
    topics.publish("x", 2, b"two")
    rounds.run()
    assert (messages, later) == ([b"one"], [b"one", b"two"])
