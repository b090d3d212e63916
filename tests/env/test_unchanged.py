# SPDX-License-Identifier: Apache-2.0
"""What must not change is printed, and what has changed is told."""

from __future__ import annotations

import json
from argparse import Namespace
from pathlib import Path

import pytest

from flatplank_validation.unchanged.compare import differences
from flatplank_validation.unchanged.facts import PARTS as FACTS
from flatplank_validation.verbs.bench_unchanged import PARTS, main

QUICK = ["messages", "topics", "effects", "formats", "files"]


def test_a_change_is_told_and_what_is_new_is_none() -> None:
    before = {"effects": {"gap": ["width"], "wear": []}, "diagnosis": {"a": {"size": 1.0}}}
    now = {"effects": {"gap": ["wide"], "new": []}, "diagnosis": {"a": {"size": 1.0 + 1e-8}}}
    assert differences(before, now) == {
        "effects": ["gap was ['width'], is ['wide']", "wear is gone"], "diagnosis": [],
    }  # fmt: skip
    now["diagnosis"]["a"]["size"] = 1.0 + 1e-5
    assert len(differences(before, now)["diagnosis"]) == 1


def test_a_version_is_the_same_as_itself(tmp_path: Path, capsys) -> None:
    file = tmp_path / "facts.json"
    assert main([*QUICK, "--write", str(file)]) == 0
    capsys.readouterr()
    assert main([*QUICK, "--against", str(file)]) == 0
    assert [line.split()[::2] for line in capsys.readouterr().out.splitlines()] == [
        [part, "same"] for part in QUICK
    ]
    facts = json.loads(file.read_text())
    facts["topics"]["/measurement_hub/lost"] = "std_msgs/msg/String"
    file.write_text(json.dumps(facts))
    assert main([*QUICK, "--against", str(file)]) == 1
    assert "  /measurement_hub/lost is gone" in capsys.readouterr().out.splitlines()


def test_verbs_are_listed_with_their_options() -> None:
    found = FACTS["verbs"](Namespace())
    assert "--model" in found["fit"] and "--kappa" not in found["fit"]
    assert all("--help" in options for options in found.values())


def test_every_part_has_its_facts() -> None:
    assert tuple(FACTS) == PARTS
    with pytest.raises(SystemExit):
        main(["nonsense"])
