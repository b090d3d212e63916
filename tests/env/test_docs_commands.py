# SPDX-License-Identifier: Apache-2.0
"""Every command in the documents is one that its verb takes, and the cheap ones run as typed."""

from __future__ import annotations

import argparse
import re
import shlex
from pathlib import Path

import pytest

from flatplank_analysis.cli.main import main
from flatplank_analysis.cli.verbs import installed

ROOT = Path(__file__).parents[2]
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").glob("*.md")]
BLOCK = re.compile(r"^```[^\n]*\n(.*?)^```", re.DOTALL | re.MULTILINE)
SHELL = {";", "&", "&&", "|", ">", "<"}
"""words that end the arguments of a command"""
OWN_PARSER = {"test"}
"""verbs that pass their arguments on"""
CHEAP = (
    "run short --dry-run", "effects", "calibrate hub", "calibrate lvdt", "calibrate plank",
    "calibrate motor", "calibrate sheet",
)  # fmt: skip
"""beginnings of commands that need no input and take no time"""
NEEDS_INPUT = re.compile(r"\.py|\.yaml|DIR|NAME")


class Parsed(Exception):
    """The arguments were understood."""


def commands() -> dict[str, str]:
    """Every command of a code block -> page that has it; of `a|b` it is `a`, `[--x]` is given,
    `DIR...` is one folder."""
    found: dict[str, str] = {}
    for page in PAGES:
        for block in BLOCK.findall(page.read_text(encoding="utf-8")):
            for line in block.splitlines():
                for part in re.split(r"(?:^|; )\./flatplank ", line)[1:]:
                    found.setdefault(_arguments(part), str(page.relative_to(ROOT)))
    return {text: page for text, page in found.items() if text}


def _arguments(text: str) -> str:
    text = re.sub(r"\s#.*", "", text)  # comment
    text = re.sub(r"(\w)\|[\w|]+", r"\1", text)  # one of several
    text = re.sub(r"[][]|(?<=[A-Z])\.\.\.", "", text)
    lexer = shlex.shlex(text, posix=False, punctuation_chars=True)
    lexer.whitespace_split = True
    words = []
    for word in lexer:
        if word in SHELL:
            break
        words.append(word)
    return " ".join(words)


COMMANDS = commands()


def test_the_documents_have_commands():
    assert len(COMMANDS) > 80
    assert {text.split()[0] for text in COMMANDS} <= installed().keys()


@pytest.mark.parametrize("text", COMMANDS)
def test_a_command_of_the_documents_is_understood(text, monkeypatch, capsys):
    verb, *arguments = shlex.split(text)
    if verb in OWN_PARSER:
        assert not arguments
        return
    understood = argparse.ArgumentParser.parse_args

    def parse(self, args=None, namespace=None):
        understood(self, args, namespace)
        raise Parsed

    monkeypatch.setattr(argparse.ArgumentParser, "parse_args", parse)
    try:
        installed()[verb].load()(arguments)
    except Parsed:
        return
    except SystemExit:
        pass
    pytest.fail(f"{COMMANDS[text]}: ./flatplank {text}: {capsys.readouterr().err}")


RUN = [text for text in COMMANDS if text.startswith(CHEAP) and not NEEDS_INPUT.search(text)]


@pytest.mark.parametrize("text", RUN)
def test_a_cheap_command_runs_as_it_is_typed(text, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(shlex.split(text)) == 0, capsys.readouterr().err
    assert capsys.readouterr().out


def test_cheap_commands_are_there():
    assert len(RUN) >= 6
