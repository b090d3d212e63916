# SPDX-License-Identifier: Apache-2.0
"""Sources of effects: the files of this folder, entry points, and files of the user."""

from __future__ import annotations

import importlib
import importlib.util
import pkgutil
import sys
from collections.abc import Iterable
from functools import lru_cache
from importlib.machinery import SourceFileLoader
from importlib.metadata import entry_points
from pathlib import Path
from types import CodeType, ModuleType
from zlib import crc32

from flatplank_analysis.discovery.effect import Effect
from flatplank_analysis.effects import consent
from flatplank_analysis.effects.base import TireEffect
from flatplank_analysis.effects.grammar import file as proposal_file
from flatplank_analysis.effects.grammar import former
from flatplank_analysis.effects.grammar.sentence import Sentence, effect_of
from flatplank_analysis.effects.sweep_base import SweepEffect
from flatplank_data.errors import FlatplankError
from flatplank_data.names import similar_names

GROUP = "flatplank.effects"
SUFFIXES = (proposal_file.SUFFIX, ".py")
"""of effect files"""
_USER = "flatplank_user_effects_"
_NOT_EFFECTS = {"base", "sweep_base", "registry", "checks", "consent", "grammar"}


def effects_in(module: ModuleType) -> list[type[Effect]]:
    """Effects defined in a module."""
    return [
        value
        for value in vars(module).values()
        if isinstance(value, type)
        and issubclass(value, Effect)
        and value.__module__ == module.__name__
        and value.identifier
    ]


@lru_cache(maxsize=1)
def _shipped() -> tuple[type[Effect], ...]:
    folder = Path(__file__).parent
    found: list[type[Effect]] = []
    for item in sorted(pkgutil.iter_modules([str(folder)]), key=lambda i: i.name):
        if item.name not in _NOT_EFFECTS:
            module = importlib.import_module(f"flatplank_analysis.effects.{item.name}")
            found += effects_in(module)
    found.sort(key=lambda effect: effect.identifier)
    for point in sorted(entry_points(group=GROUP), key=lambda p: p.name):
        found += _from_entry(point)
    return tuple(found)


def _from_entry(point) -> list[type[Effect]]:
    try:
        loaded = point.load()
    except Exception as error:  # a broken plug-in must not stop the others
        what, where = f"cannot be loaded ({error})", f"entry point {point.name}"
        raise FlatplankError(what, where, "mend or remove the package") from error
    return [loaded] if isinstance(loaded, type) else effects_in(loaded)


def load_file(path: str | Path) -> list[type[Effect]]:
    """Effects of a user's file: a proposal, which is data, or Python that the user has allowed.

    ConsentError for Python that is not allowed; nothing of it has run then.
    """
    path = Path(path)
    content = consent.read(path)
    sentence = proposal_of(path, content)
    if sentence is not None:
        found = [effect_of(sentence)]
    elif path.suffix != ".py":
        raise FlatplankError("is no effect file", str(path), "give a file that ends in .py")
    elif not consent.is_given(content):
        raise consent.ConsentError(path, content)
    else:
        found = effects_in(_run(path, consent.text_of(path, content)))
    if not found:
        remedy = "define a frozen dataclass of TireEffect with identifier"
        raise FlatplankError("holds no effect", str(path), remedy)
    for effect in found:
        effect.file = str(path.resolve())
    return found


def load_files(files: Iterable[str | Path]) -> list[type[Effect]]:
    """Effects of several files; one that is given twice, under any path, is read once."""
    return [e for f in dict.fromkeys(Path(f).resolve() for f in files) for e in load_file(f)]


def proposal_of(path: Path, content: bytes) -> Sentence | None:
    """The sentence of a proposal's file; None for other effect files. Nothing is executed."""
    if path.suffix == proposal_file.SUFFIX:
        return proposal_file.sentence_of(content, str(path))
    return former.sentence_of(content) if path.suffix == ".py" else None


class _Allowed(SourceFileLoader):
    """Runs the text that was allowed, not what the file or its byte code has become since."""

    text = ""

    def get_code(self, fullname: str) -> CodeType:
        return self.source_to_code(self.text, self.path)


def _run(path: Path, text: str) -> ModuleType:
    # files with the same name in two folders are two modules
    name = f"{_USER}{path.stem}_{crc32(bytes(path.resolve())):08x}"
    loader = _Allowed(name, str(path))
    loader.text = text
    spec = importlib.util.spec_from_file_location(name, path, loader=loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        loader.exec_module(module)
    except Exception as error:
        what = f"cannot be read ({type(error).__name__}: {error})"
        raise FlatplankError(what, str(path), "mend the file") from error
    return module


def _origin(effect: type[Effect]) -> str:
    return effect.file or effect.__module__


def library(files: Iterable[str | Path] = ()) -> dict[str, type[Effect]]:
    """All effects by identifier: shipped ones, entry points, and those of the given files."""
    out: dict[str, type[Effect]] = {}
    own = load_files(files)
    for effect in own:
        if issubclass(effect, SweepEffect):
            raise FlatplankError("is of sweeps", effect.file, "name a file with sweeps with it")
    for effect in [*_shipped(), *own]:
        other = out.get(effect.identifier)
        if other is not None and other is not effect:
            what = f"identifier '{effect.identifier}' is taken by {_origin(other)}"
            raise FlatplankError(what, _origin(effect), "choose another identifier")
        out[effect.identifier] = effect
    return out


def find(identifier: str, files: Iterable[str | Path] = ()) -> type[TireEffect]:
    """One effect by name; an unknown name is reported with the nearest ones."""
    known = library(files)
    if identifier not in known:
        near = ", ".join(similar_names(identifier, known, most=3))
        remedy = f"nearest: {near}" if near else "flatplank effects lists them"
        raise FlatplankError(f"no effect '{identifier}'", "effects", remedy)
    return known[identifier]
