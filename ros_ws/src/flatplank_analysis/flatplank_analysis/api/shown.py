# SPDX-License-Identifier: Apache-2.0
"""What a notebook shows of an answer: its words, its tables, its figures."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Mapping
from html import escape
from typing import TYPE_CHECKING, TypeVar

from flatplank_data.errors import FlatplankError

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

Plot = TypeVar("Plot")


def figure_of(known: Mapping[str, Plot], name: str) -> Plot:
    """The figure of that name; FlatplankError says which there are."""
    if name not in known:
        raise FlatplankError(f"no figure '{name}'", "plot", f"known: {', '.join(known)}")
    return known[name]


def words(text: str) -> str:
    """Text with its line ends."""
    return f"<pre>{escape(text)}</pre>"


def page(text: str, tables: Iterable[pd.DataFrame] = (), figures: Iterable[Figure] = ()) -> str:
    """HTML of an answer that needs nothing beside it."""
    parts = [words(text)]
    parts += [table.to_html(index=False, border=0) for table in tables if len(table)]
    parts += [_image(figure) for figure in figures]
    return "\n".join(parts)


def _image(figure: Figure) -> str:
    from flatplank_analysis.discovery.report.figures import png

    data = base64.b64encode(png(figure)).decode("ascii")
    return f'<img alt="figure" src="data:image/png;base64,{data}">'
