# SPDX-License-Identifier: Apache-2.0
"""Shared functions of the verbs that search and change a model: arguments, files, progress."""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from flatplank_analysis.cli import common
from flatplank_analysis.contact_patch.session import Session
from flatplank_analysis.discovery.modelfile import TIR, ModelFile, load_model
from flatplank_analysis.slip_sweeps.conditions import FORCE
from flatplank_analysis.slip_sweeps.session import SweepSession
from flatplank_data.arguments import Parser, add_json
from flatplank_data.errors import FlatplankError

MODEL = "model.yaml"


def loop_parser(
    verb: str, text: str | None, effect: bool = False, sweeps: bool = False, more: str = ""
) -> argparse.ArgumentParser:
    """A parser with the arguments of a verb on a model; `effect`: the first one is an effect;
    `sweeps`: files with sweeps may stand for the campaign; `more`: help of the further ones."""
    parser = Parser(prog=f"flatplank {verb}", description=text)
    what = "campaign folder, or a file with sweeps" if sweeps else "campaign folder"
    if effect:
        parser.add_argument("effect", metavar="EFFECT", help="identifier, see `flatplank effects`")
        parser.add_argument("folder", metavar="DIR", nargs="?", help=what)
    else:
        parser.add_argument("folder", metavar="DIR", help=what)
    if sweeps:
        what = "of sweeps: the tire file; default: that of the model file"
        parser.add_argument("--tir", metavar="FILE", help=what)
        what = "further files with sweeps of the same tire, in the order of measurement"
        parser.add_argument("more", metavar="FILE", nargs="*", help=more or what)
        parser.add_argument("--swept", choices=FORCE, help="of sweeps: the slip")
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
    path = _beside(arguments.folder)
    return path if os.access(path.parent, os.W_OK) else Path(path.name)


def _beside(folder: str) -> Path:
    """Path of the model file of a campaign folder, or of a file with sweeps: the model file has
    the name of that one."""
    path = Path(folder)
    return path.with_suffix(f".{MODEL}") if path.is_file() else path / MODEL


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
        there = _beside(arguments.folder)
        named = str(there) if there.is_file() else None
    model = load_model(named) if named else None
    return session_of(arguments, arguments.folder, model), model


def session_of(arguments: argparse.Namespace, folder: str, model: ModelFile | None) -> Session:
    """The campaign, or the sweeps, with the effects of the command line and of the model file."""
    if hasattr(arguments, "tir") and Path(folder).is_file():
        return _session_of_sweeps(arguments, folder, model)
    if getattr(arguments, "more", ()):
        what, remedy = "is one campaign more", "name one folder, or files with sweeps"
        raise FlatplankError(what, arguments.more[0], remedy)
    mapping = common.read_mapping(arguments.mapping)
    session = Session.open(folder, _effect_files(arguments, model), mapping)
    common.print_problems(session.campaign.problems)
    return session


def _session_of_sweeps(
    arguments: argparse.Namespace, file: str, model: ModelFile | None
) -> SweepSession:
    """The sweeps of a file, with the tire file that is named or that of the model file."""
    tir = arguments.tir or (model.base if model and model.base.endswith(TIR) else "")
    if not tir:
        raise FlatplankError(
            "no tire file to compare with", file,
            f"give --tir FILE; `flatplank sweeps {file} --fit FILE.tir` makes one",
        )  # fmt: skip
    mapping = common.read_mapping(arguments.mapping)
    files = _effect_files(arguments, model)
    return SweepSession.of_file(file, tir, arguments.swept, mapping, files, arguments.more)


def _effect_files(arguments: argparse.Namespace, model: ModelFile | None) -> list[str]:
    """The effect files of the command line and of the model file."""
    own = [e.file for e in model.effects if e.file] if model else []
    return [*common.effect_files(arguments), *own]


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
