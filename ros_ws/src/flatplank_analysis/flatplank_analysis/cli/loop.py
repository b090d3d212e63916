# SPDX-License-Identifier: Apache-2.0
"""Shared functions of the verbs that search and change a model: arguments, files, progress."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from flatplank_analysis.cli import common
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.modelfile import ModelFile, load_model
from flatplank_data.arguments import Parser, add_json
from flatplank_data.errors import FlatplankError

MODEL = "model.yaml"


def loop_parser(verb: str, text: str | None, effect: bool = False) -> argparse.ArgumentParser:
    """A parser with the arguments of a verb on a model; `effect`: the first one is an effect."""
    parser = Parser(prog=f"flatplank {verb}", description=text)
    if effect:
        parser.add_argument("effect", metavar="EFFECT", help="identifier, see `flatplank effects`")
        parser.add_argument("folder", metavar="DIR", nargs="?", help="campaign folder")
    else:
        parser.add_argument("folder", metavar="DIR", help="campaign folder")
    parser.add_argument("--model", metavar="FILE", help="model file (YAML)")
    common.effect_arguments(parser)
    add_json(parser)
    common.mapping_argument(parser)
    return parser


def model_path(arguments: argparse.Namespace) -> Path:
    """Path of the model file: as given, otherwise model.yaml in the campaign folder or here."""
    if arguments.model:
        return Path(arguments.model)
    if arguments.folder is None or "://" in arguments.folder:
        return Path(MODEL)
    folder = Path(arguments.folder)
    return folder / MODEL if os.access(folder, os.W_OK) else Path(MODEL)


def open_for_change(arguments: argparse.Namespace) -> tuple[Session, ModelFile, Path]:
    """Session, model file (a new one if none exists) and its path, for add and remove."""
    path = model_path(arguments)
    require_file(path)
    model = load_model(path) if path.exists() else ModelFile()
    folder = arguments.folder or model.campaign
    if not folder:
        raise FlatplankError("no campaign", str(path), "name the campaign folder: DIR")
    return session_of(arguments, folder, model), model, path


def open_to_look(
    arguments: argparse.Namespace, own: bool = False
) -> tuple[Session, ModelFile | None]:
    """Session and the given model file, if any; `own`: otherwise that of the campaign folder."""
    named = arguments.model
    if own and not named and "://" not in arguments.folder:
        there = Path(arguments.folder) / MODEL
        named = str(there) if there.is_file() else None
    model = load_model(named) if named else None
    return session_of(arguments, arguments.folder, model), model


def session_of(arguments: argparse.Namespace, folder: str, model: ModelFile | None) -> Session:
    """The campaign with the effects of the command line and of the model file."""
    own = [e.file for e in model.effects if e.file] if model else []
    mapping = common.read_mapping(arguments.mapping)
    session = Session.open(folder, [*common.effect_files(arguments), *own], mapping)
    common.print_problems(session.campaign.problems)
    return session


def require_file(path: Path) -> None:
    """Raise FlatplankError when no file can be written there; called before the work starts."""
    if path.is_dir():
        raise FlatplankError("is a folder", str(path), "name a file in it")
    if not path.parent.is_dir():
        raise FlatplankError("no such folder", str(path.parent), "make it, or choose another")
    _require_access(path.parent)


def require_folder(path: Path) -> None:
    """Raise FlatplankError when a folder there cannot be created or written to."""
    there = next(p for p in (path, *path.absolute().parents) if p.exists())
    if not there.is_dir():
        raise FlatplankError("is no folder", str(there), "choose another place")
    _require_access(there)


def _require_access(folder: Path) -> None:
    if not os.access(folder, os.W_OK):
        raise FlatplankError("may not be written to", str(folder), "choose another place")


def progress(text: str, share: float) -> None:
    """Show what is being done, and the share of the work that is done."""
    common.progress_line(f"{min(share, 0.99):4.0%} {text}")


def progress_done() -> None:
    """Clear the progress line."""
    common.progress_line("")
