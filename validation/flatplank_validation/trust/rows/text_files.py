# SPDX-License-Identifier: Apache-2.0
"""Damaged text files: tables, TYDEX, tire property files."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import numpy as np

from flatplank_tire.text import decode_text, lines_of
from flatplank_tire.tir import TIRE_FILES, TirFile, read_tir
from flatplank_tire.tydex import TydexFile, parse_tydex
from flatplank_validation.trust.files import text
from flatplank_validation.trust.files.judge import by_numpy, judged
from flatplank_validation.trust.files.text_damage import damaged
from flatplank_validation.trust.registry import Options, Tally, row

NIGHT = 40_000
"""damaged files of a night"""
BAR = "not refused in one line, other numbers than pandas, or rows lost without a word"


@row("text", "damaged text tables (4 separators, 4 encodings)", BAR)
def damaged_tables(o: Options) -> Tally:
    """Each separator and encoding alike."""
    out = Tally()
    with tempfile.TemporaryDirectory(prefix="fp-text-") as folder:
        path = Path(folder) / "a.csv"
        for kind in text.KINDS.values():
            for encoding in text.ENCODINGS:
                path.write_bytes(kind.encode(encoding))
                out.join(
                    judged(
                        o, NIGHT // 16, path, lambda p: text.read_table(p.read_bytes()),
                        lambda table, p: text.compare_with_pandas(table, p.read_bytes()),
                        by_numpy(damaged),
                    )
                )  # fmt: skip
    return out


@row("tydex", "damaged TYDEX files", BAR)
def damaged_tydex(o: Options) -> Tally:
    """One file with four channels."""

    def read(path: Path) -> TydexFile:
        return parse_tydex(decode_text(path.read_bytes(), path.name), path.name)

    def compare(file: TydexFile, path: Path) -> None:
        text.compare_tydex(file, decode_text(path.read_bytes(), path.name))

    with tempfile.TemporaryDirectory(prefix="fp-tydex-") as folder:
        path = Path(folder) / "a.tdx"
        path.write_bytes(text.TYDEX.encode("cp1252"))
        return judged(o, NIGHT, path, read, compare, by_numpy(damaged))


_ENTRY = re.compile(r"\s*([A-Za-z_]\w*)\s*=\s*([-+0-9.eE]+)\s*(?:[$!].*)?")


def _by_a_formula(data: str) -> dict[str, set[float]]:
    """KEY = number of each line."""
    found: dict[str, set[float]] = {}
    for line in lines_of(data):
        entry = _ENTRY.fullmatch(line)
        if entry:
            try:
                found.setdefault(entry[1].upper(), set()).add(float(entry[2]))
            except ValueError:
                continue
    return found


@row("tir", "damaged tire property files", "not refused in one line, or another number")
def damaged_tir(o: Options) -> Tally:
    """The shipped file in SI."""

    def compare(tir: TirFile, path: Path) -> None:
        there = _by_a_formula(decode_text(path.read_bytes(), path.name))
        if not np.allclose(list(tir.units.values()), 1.0):
            return
        for key, value in tir.values.items():
            assert value in there.get(key, ()), f"{key} is {value}, the file has {there.get(key)}"

    with tempfile.TemporaryDirectory(prefix="fp-tir-") as folder:
        path = Path(folder) / "a.tir"
        shipped = TIRE_FILES / "toyo_nanoenergy.tir"
        path.write_bytes(shipped.read_bytes())
        return judged(o, NIGHT // 4, path, read_tir, compare, by_numpy(damaged))
