# SPDX-License-Identifier: Apache-2.0
"""YAML: what is refused, in one line, and that what is written can be read."""

from __future__ import annotations

import pytest
import yaml

from flatplank_data.errors import YamlError
from flatplank_data.yaml_text import dump_yaml, load_yaml

BOMB = "a: &a [x, x]\n" + "\n".join(
    f"{chr(b)}: &{chr(b)} [*{chr(b - 1)}, *{chr(b - 1)}]" for b in range(98, 120)
)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (BOMB, r"f.yaml line 2: the alias '\*a' is not read; write its values out"),
        ("a: &x {q: 1}\nb:\n  <<: *x\n", r"line 3: the alias '\*x'"),
        ("[" * 100_000, "line 1: nested deeper than 100 levels"),
        ("{a: " * 100_000, "nested deeper"),
        ("- " * 100_000, "nested deeper"),
        ("\n".join(" " * i + "a:" for i in range(2000)), "line 101: nested deeper"),
        ("a: [1, 2", r"line \d: not YAML; correct the syntax"),
        ("a: 1" + "0" * 5000, "not YAML"),
        ("a: !!python/object/apply:os.getcwd []", "line 1: not YAML"),
        (b"\xff\xfe\x00", "not YAML"),
    ],
)
def test_what_is_not_read_is_told_in_one_line(text, told):
    with pytest.raises(YamlError, match=told) as caught:
        load_yaml(text, "f.yaml")
    assert "\n" not in str(caught.value)


def test_what_is_written_has_no_alias_and_reads_back():
    shared = [1.5, "text"]
    content = {"z": shared, "a": shared, "deep": {"x": shared, "y": {"x": shared}}}
    text = dump_yaml(content)
    assert "*" not in text and list(load_yaml(text, "f")) == ["z", "a", "deep"]
    assert load_yaml(text, "f") == yaml.safe_load(text) == content
