# SPDX-License-Identifier: Apache-2.0
"""Every handler of the bus is there for a test: it fails when the handler is taken out."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import ethercat_mutations as made
import pytest
from ethercat_handlers import MUTATIONS, Mutation


@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda m: m.name)
def test_the_handler_is_where_the_list_says(mutation: Mutation) -> None:
    assert made.place(made.ROOT, mutation).read_text().count(mutation.old) == 1


@pytest.fixture(scope="module")
def copy(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A copy in which all tests that shall notice something pass."""
    folder = made.copied(tmp_path_factory.mktemp("handlers"))
    wanted = " or ".join(f"({m.select})" for m in MUTATIONS)
    said = made.tests(folder, wanted, "-q", limit_s=900)
    assert re.search(r"^\d+ passed", said.splitlines()[-1]), said[-4000:]
    yield folder


@pytest.mark.long
@pytest.mark.timeout(900 + 2 * made.LIMIT_S)
@pytest.mark.parametrize("mutation", MUTATIONS, ids=lambda m: m.name)
def test_a_handler_that_is_taken_out_is_noticed(copy: Path, mutation: Mutation) -> None:
    noticed = made.run(mutation, copy)
    print("; ".join(noticed))
    assert noticed, f"no test of '{mutation.select}' fails without it"
