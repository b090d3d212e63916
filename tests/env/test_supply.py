# SPDX-License-Identifier: Apache-2.0
"""What is installed is what was locked: hashes, licences, known vulnerabilities."""

from __future__ import annotations

import hashlib
import re
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
REQUIREMENTS = ROOT / "requirements"
LOCKS = sorted(REQUIREMENTS.glob("*.txt"))


@pytest.fixture
def virtual(monkeypatch: pytest.MonkeyPatch, tmp_path: Path):
    """The module of the set-up that installs, with a cache of its own."""
    monkeypatch.syspath_prepend(str(ROOT / "tools" / "setup"))
    import virtual

    monkeypatch.setattr(virtual, "CACHE", tmp_path)
    return virtual


def lines_of(lock: Path) -> list[str]:
    """Each package of a lock with its hashes on one line."""
    lines = lock.read_text(encoding="utf-8").replace("\\\n", "").splitlines()
    return [line for line in lines if not line.startswith("#")]


@pytest.mark.parametrize("lock", LOCKS, ids=lambda p: p.stem)
def test_every_line_of_a_lock_has_a_version_and_hashes(lock: Path) -> None:
    lines = lines_of(lock)
    assert len(lines) > 10
    for line in lines:
        pinned, *hashes = re.split(r"\s+--hash=", line.strip())
        assert re.fullmatch(r"[A-Za-z0-9-]+==[\w.+!]+( ; .+)?", pinned), line
        assert hashes and all(re.fullmatch("sha256:[0-9a-f]{64}", h) for h in hashes), pinned


def test_a_lock_has_the_files_of_every_python_and_processor() -> None:
    """numpy has a file per Python and processor: 4 Pythons, x86_64 and aarch64, at least."""
    numbers = {
        line.split()[0]: line.count("--hash=")
        for line in lines_of(REQUIREMENTS / "lock.txt")
        if line.startswith("numpy==")
    }
    assert numbers and min(numbers.values()) >= 8, numbers


def wheel(folder: Path) -> tuple[str, str]:
    """A package with one module in a folder: its requirement, the hash of its file."""
    info = "one-1.0.dist-info/"
    texts = {
        "one.py": "",
        info + "METADATA": "Metadata-Version: 2.1\nName: one\nVersion: 1.0\n",
        info + "WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    record = "".join(f"{name},,\n" for name in [*texts, info + "RECORD"])
    file = folder / "one-1.0-py3-none-any.whl"
    with zipfile.ZipFile(file, "w") as archive:
        for name, text in (texts | {info + "RECORD": record}).items():
            archive.writestr(name, text)
    return "one==1.0", f"sha256:{hashlib.sha256(file.read_bytes()).hexdigest()}"


@pytest.mark.parametrize("tool", [("pip",), ("uv", "pip")], ids=["pip", "uv"])
def test_a_file_that_is_not_the_locked_one_is_not_installed(
    virtual, tool: tuple[str, ...], tmp_path: Path
) -> None:
    """Both installers get the options that the set-up gives them."""
    package, true = wheel(tmp_path)
    false = f"sha256:{'0' * 64}"
    for name, hashes, installed in (("true", [false, true], True), ("false", [false], False)):
        options = virtual.requirements({package: hashes}, name)
        command = [sys.executable, "-m", *tool, "install", *options, "--no-index", "--no-deps"]
        command += ["--find-links", str(tmp_path), "--target", str(tmp_path / name)]
        log = tmp_path / f"{name}.log"
        if installed:
            virtual.run(command, log)
        else:
            with pytest.raises(virtual.SetupError, match="failed"):
                virtual.run(command, log)
            assert re.search("hash", log.read_text(), re.IGNORECASE), log.read_text()
        assert (tmp_path / name / "one.py").exists() == installed


def test_the_set_up_installs_with_hashes(virtual) -> None:
    found = virtual.locked("main")
    assert any(p.startswith("scipy==") for p in found) and all(found.values())
    options = virtual.requirements(found, "main")
    assert options[:2] == ["--require-hashes", "-r"]
    assert Path(options[2]).read_text().count("==") == len(found)


def test_the_list_of_licences_has_every_locked_package() -> None:
    page = (ROOT / "docs/reference/licences.md").read_text(encoding="utf-8")
    told = {
        (name, version)
        for name, versions in re.findall(r"(?m)^\| ([a-z0-9-]+) \| ([^|]+) \|", page)
        for version in versions.strip().split(", ")
    }
    locked = {
        tuple(re.split(r"==|[\s;]", line.lower())[:2])
        for lock in LOCKS
        for line in lines_of(lock)
        if "win32" not in line
    }
    assert locked - told == set(), "run .venv/bin/python tools/licences.py"
    assert not re.search(r"\| *\|$", page, re.MULTILINE), "a licence, or that none is stated"


ANSWER = """import json, sys
sys.exit(print(json.dumps({"dependencies": %s})) or 1)"""
VULNERABLE = [{"name": "one", "version": "1.0",
               "vulns": [{"id": "CVE-1", "fix_versions": ["1.1"]}]}]  # fmt: skip


@pytest.mark.parametrize(
    "program, code, words",
    [
        (ANSWER % VULNERABLE, 1, "one 1.0: CVE-1, mended in 1.1"),
        (ANSWER % [{"name": "one", "version": "1.0", "vulns": []}], 0, "0 vulnerabilities known"),
        (ANSWER % [{"name": "one", "skip_reason": "?"}], 2, "no database could be asked"),
        ("raise SystemExit('no route to host')", 2, "no route to host"),
    ],
)
def test_known_vulnerabilities_are_told_or_why_not(
    program: str, code: int, words: str, tmp_path: Path, monkeypatch, capfd
) -> None:
    """A stand-in for pip-audit, as it answers."""
    monkeypatch.syspath_prepend(str(ROOT / "tools"))
    import vulnerabilities

    (tmp_path / "pip_audit.py").write_text(program)
    (tmp_path / "done").write_text((REQUIREMENTS / "audit.txt").read_text())
    monkeypatch.setattr(vulnerabilities, "TOOL", tmp_path)
    lock = tmp_path / "lock.txt"
    lock.write_text("one==1.0\n")
    assert vulnerabilities.main([str(lock)]) == code
    told = capfd.readouterr()
    assert words in told.out + told.err
