# SPDX-License-Identifier: Apache-2.0
"""The RO-Crate of a campaign folder: what the specification and DataCite ask for is there."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from urllib.parse import unquote

import pytest
from rocrate.rocrate import ROCrate
from steptable import step_table

from flatplank_analysis.cli.publish import main as publish
from flatplank_data.errors import FlatplankError
from flatplank_data.exporters import export_campaign
from flatplank_data.run_record import record_from_dict

WORDS = ["--publisher", "4TU.ResearchData", "--license", "CC-BY-4.0"]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    tables = [
        step_table(kappa, operator="Ada Lovelace", date="2026-05-01", file=f"TOY {k}.parquet")
        for k, kappa in enumerate((0.01, -0.01))
    ]
    out = export_campaign(tables, tmp_path / "c")
    (out / ".flatplank-cache").mkdir()
    (out / ".flatplank-cache" / "x").touch()
    return out


def crate(folder: Path, *more: str) -> dict[str, dict]:
    assert publish([str(folder), *WORDS, *more]) == 0
    text = (folder / "ro-crate-metadata.json").read_text(encoding="utf-8")
    return {entity["@id"]: entity for entity in json.loads(text)["@graph"]}


def references(value: object) -> list[str]:
    """All identifiers that an entity points to."""
    if isinstance(value, dict):
        return [value["@id"]] if set(value) == {"@id"} else references(list(value.values()))
    return [r for v in value for r in references(v)] if isinstance(value, list) else []


def test_the_crate_has_what_the_specification_asks_for(folder: Path) -> None:
    found = crate(folder)
    descriptor = found["ro-crate-metadata.json"]
    assert descriptor["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    assert descriptor["about"] == {"@id": "./"}
    root = found["./"]
    assert {"name", "description", "datePublished", "license"} <= root.keys()
    outside = {"https://w3id.org/ro/crate/1.1"}
    assert set(references(list(found.values()))) <= found.keys() | outside
    reached = set(references(root["hasPart"]))
    assert {k for k, v in found.items() if v["@type"] == "File"} == reached


def test_every_file_is_in_it_with_its_checksum_and_a_run_with_its_condition(folder: Path) -> None:
    found = crate(folder)
    files = {k: v for k, v in found.items() if v["@type"] == "File"}
    there = {p.name for p in folder.iterdir() if p.is_file()} - {"ro-crate-metadata.json"}
    assert {unquote(k) for k in files} == there
    for place, entity in files.items():
        content = (folder / unquote(place)).read_bytes()
        assert entity["sha256"] == hashlib.sha256(content).hexdigest()
        assert int(entity["contentSize"]) == len(content)
    assert found["TOY%200.parquet"]["description"].startswith("slip, κ +1 %, Fz 3700 N")


def test_what_datacite_requires_is_there(folder: Path) -> None:
    root = crate(folder, "--doi", "10.4121/abc.v1", "--date", "2026-06-01")["./"]
    assert root["identifier"] == "https://doi.org/10.4121/abc.v1"
    assert root["datePublished"] == "2026-06-01" and root["temporalCoverage"].startswith("2026-05")
    found = crate(folder, "--author", "Grace Hopper 0000-0002-1825-0097", "Ada Lovelace")
    authors = [found[r]["name"] for r in references(found["./"]["author"])]
    assert authors == ["Grace Hopper", "Ada Lovelace"]
    assert found["https://orcid.org/0000-0002-1825-0097"]["@type"] == "Person"
    assert found["#publisher"]["name"] == "4TU.ResearchData"


def test_rocrate_reads_the_crate_and_writes_it_again(folder: Path, tmp_path: Path) -> None:
    words = ["--doi", "10.4121/abc.v1", "--date", "2026-06-01", "--title", "Slip steps"]
    ours = crate(folder, *words, "--author", "Grace Hopper 0000-0002-1825-0097")
    read = ROCrate(folder)
    assert read.version == "1.1" and read.name == "Slip steps"
    assert read.datePublished.isoformat().startswith("2026-06-01")
    assert read.license["name"] == "CC-BY-4.0"
    assert read.publisher["name"] == "4TU.ResearchData"
    author = read.root_dataset["author"]
    (author,) = author if isinstance(author, list) else [author]
    assert (author.id, author["name"]) == ("https://orcid.org/0000-0002-1825-0097", "Grace Hopper")
    files = {entity.id for entity in read.data_entities if entity.type == "File"}
    assert files == {k for k, v in ours.items() if v["@type"] == "File"}
    # what it writes has our files and every entity with its properties
    read.write(tmp_path / "again")
    for place in map(unquote, files):
        assert (tmp_path / "again" / place).read_bytes() == (folder / place).read_bytes()
    text = (tmp_path / "again" / "ro-crate-metadata.json").read_text(encoding="utf-8")
    again = {entity["@id"]: entity for entity in json.loads(text)["@graph"]}
    assert again.keys() == ours.keys()
    for name, entity in ours.items():
        assert entity.items() <= again[name].items(), name


def test_a_bag_is_a_dataset_of_its_files(tmp_path: Path) -> None:
    bag = tmp_path / "c" / "one"
    bag.mkdir(parents=True)
    record = {"tire": "TOY", "status": "complete", "operator": "A", "kappa": 0.05, "fz": 3700.0}
    record_from_dict(record).save(bag)
    (bag / "metadata.yaml").write_text("rosbag2_bagfile_information: {}\n")
    found = crate(tmp_path / "c")
    assert references(found["./"]["hasPart"]) == ["one/"]
    assert references(found["one/"]["hasPart"]) == ["one/metadata.yaml", "one/run.yaml"]


@pytest.mark.parametrize(
    ("words", "said"), [(["--doi", "abc"], "'abc' is no DOI"), ([], "no author")]
)
def test_what_is_missing_or_wrong_is_told(folder: Path, words: list[str], said: str) -> None:
    if not words:
        text = (folder / "campaign.yaml").read_text()
        (folder / "campaign.yaml").write_text(text.replace("operator: Ada Lovelace", ""))
    with pytest.raises(FlatplankError, match=said):
        publish([str(folder), *WORDS, *words])
