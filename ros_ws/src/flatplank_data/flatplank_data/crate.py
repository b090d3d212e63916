# SPDX-License-Identifier: Apache-2.0
"""A campaign folder as a research object: RO-Crate 1.1 metadata with what DataCite asks for."""

from __future__ import annotations

import hashlib
import mimetypes
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

from flatplank_data.campaign import Campaign
from flatplank_data.errors import FlatplankError
from flatplank_data.run_record import RunRecord

FILE = "ro-crate-metadata.json"
SPECIFICATION = "https://w3id.org/ro/crate/1.1"
CONTEXT = [f"{SPECIFICATION}/context", {"sha256": "https://schema.org/sha256"}]
FORMATS = {
    ".parquet": "application/vnd.apache.parquet", ".mcap": "application/octet-stream",
    ".yaml": "application/yaml", ".jsonl": "application/jsonl", ".tdx": "text/plain",
}  # fmt: skip
"""media types that the standard library does not know"""
_ORCID = re.compile(r"(.+?)\s*(\d{4}-\d{4}-\d{4}-\d{3}[\dX])")
_DOI = re.compile(r"10\.\d{4,9}/\S+")

Entity = dict[str, Any]


@dataclass(frozen=True)
class Publication:
    """What a folder cannot say of itself."""

    authors: Sequence[str]
    """names, each with its ORCID after it where there is one"""
    publisher: str
    licence: str
    """SPDX identifier, as CC-BY-4.0"""
    date: str
    """ISO 8601"""
    title: str = ""
    description: str = ""
    doi: str = ""
    """as 10.4121/abc; empty before it is registered"""


def crate_of(campaign: Campaign, publication: Publication) -> dict[str, Any]:
    """The JSON-LD of a campaign folder with all its files.

    Raises FlatplankError for a publication without author, and for a DOI that is none.
    """
    if not publication.authors:
        raise FlatplankError("no author", "publish", "give --author 'NAME ORCID'")
    if publication.doi and not _DOI.fullmatch(publication.doi):
        raise FlatplankError(f"'{publication.doi}' is no DOI", "--doi", "write it as 10.4121/abc")
    authors = [_person(text) for text in publication.authors]
    publisher = {"@id": "#publisher", "@type": "Organization", "name": publication.publisher}
    licence = {
        "@id": f"https://spdx.org/licenses/{publication.licence}", "@type": "CreativeWork",
        "name": publication.licence,
    }  # fmt: skip
    tires = [_tire(name) for name in sorted({i.tire for i in campaign.infos if i.tire})]
    parts = list(_parts(Path(campaign.path), campaign.infos))
    inner = {inner["@id"] for part in parts for inner in part.get("hasPart", ())}
    outer = [part for part in parts if part["@id"] not in inner]
    root = {
        "@id": "./", "@type": "Dataset", **_said(campaign, publication), "author": _ids(authors),
        "publisher": _id(publisher), "license": _id(licence), "about": _ids(tires),
        "hasPart": _ids(outer),
    }  # fmt: skip
    descriptor = {
        "@id": FILE, "@type": "CreativeWork", "conformsTo": {"@id": SPECIFICATION},
        "about": {"@id": "./"},
    }  # fmt: skip
    graph = [descriptor, root, *authors, publisher, licence, *tires, *parts]
    return {"@context": CONTEXT, "@graph": graph}


def _said(campaign: Campaign, publication: Publication) -> Entity:
    """Texts of the whole."""
    infos = campaign.infos
    names = ", ".join(sorted({i.tire for i in infos if i.tire})) or "a tire"
    days = sorted({day for record in campaign.records() if (day := record.day)})
    kinds = sorted({i.kind for i in infos})
    usual = (
        f"{len(infos)} runs ({', '.join(kinds)}) of {names} on a flat plank tire tester: forces "
        "and moments at the hub, rotation of the wheel and travel of the plank over time. Units "
        "are SI, axes are ISO W."
    )
    said = {
        "name": publication.title or f"Flat plank measurements of {names}",
        "description": publication.description or usual,
        "datePublished": publication.date,
        "keywords": ", ".join(["tire", "flat plank", *kinds]),
    }
    if days:
        said["temporalCoverage"] = f"{days[0]}/{days[-1]}"
    if publication.doi:
        said["identifier"] = f"https://doi.org/{publication.doi}"
    return said


def _person(text: str) -> Entity:
    found = _ORCID.fullmatch(text.strip())
    name = found[1] if found else text.strip()
    place = f"https://orcid.org/{found[2]}" if found else f"#{quote(name)}"
    return {"@id": place, "@type": "Person", "name": name}


def _tire(name: str) -> Entity:
    return {"@id": f"#tire-{quote(name)}", "@type": "Product", "name": f"tire {name}"}


def _parts(folder: Path, infos: Sequence[RunRecord]) -> Iterator[Entity]:
    """Every file, and every bag as a dataset of its files; runs have their condition."""
    runs = {info.file: info for info in infos}
    files = sorted(_files(folder))
    for name in files:
        yield _file(folder, name) | _run(runs.get(name))
    for name, info in runs.items():
        own = [f for f in files if f.startswith(f"{name}/")]
        if own:
            content = [{"@id": quote(f)} for f in own]
            yield {"@id": f"{quote(name)}/", "@type": "Dataset", "hasPart": content} | _run(info)


def _run(info: RunRecord | None) -> Entity:
    if info is None:
        return {}
    return {"name": info.name, "description": f"{info.kind}, {info.condition.label()}"}


def _files(folder: Path) -> Iterator[str]:
    """Files below a folder without hidden ones, relative to it, with '/'."""
    for path, folders, names in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".")]
        here = Path(path).relative_to(folder)
        yield from ((here / name).as_posix() for name in names if name[0] != "." and name != FILE)


def _file(folder: Path, name: str) -> Entity:
    path = folder / name
    kind = FORMATS.get(path.suffix.lower()) or mimetypes.guess_type(name)[0]
    with path.open("rb") as stream:
        digest = hashlib.sha256()
        while block := stream.read(1 << 20):
            digest.update(block)
    return {
        "@id": quote(name), "@type": "File", "name": path.name,
        "contentSize": str(path.stat().st_size),
        "encodingFormat": kind or "application/octet-stream", "sha256": digest.hexdigest(),
    }  # fmt: skip


def _id(entity: Entity) -> Entity:
    return {"@id": entity["@id"]}


def _ids(entities: Sequence[Entity]) -> list[Entity]:
    return [_id(entity) for entity in entities]
