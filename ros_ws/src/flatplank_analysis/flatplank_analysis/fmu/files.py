# SPDX-License-Identifier: Apache-2.0
"""The files of an FMU: model description, build description, C sources."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from importlib import resources
from importlib.metadata import version
from xml.etree import ElementTree

from flatplank_analysis.fmu.tire import LAWS, Tire, tire_of
from flatplank_tire.tir import TirFile, format_tir

IDENTIFIER = "flatplank_tire"
"""name of the binary, and of the model in programs that import it"""
UNITS: Mapping[str, dict[str, str]] = {
    "s": {"s": "1"}, "m": {"m": "1"}, "m/s": {"m": "1", "s": "-1"},
    "rad": {"rad": "1"}, "rad/s": {"rad": "1", "s": "-1"},
    "N": {"kg": "1", "m": "1", "s": "-2"}, "N.m": {"kg": "1", "m": "2", "s": "-2"},
    "Pa": {"kg": "1", "m": "-1", "s": "-2"},
}  # fmt: skip
"""unit -> exponents of SI"""
STEP = 1e-3
"""communication step that importing programs are offered first [s]"""
HEADER = "/* Made by flatplank {version} from {source}: {law}. */"


def files_of(tir: TirFile, law: str, name: str) -> dict[str, str]:
    """Path in the FMU -> text; `name` of the tire, `law` a key of `LAWS`.

    Raises FlatplankError where a coefficient that the model needs is missing.
    """
    tire = tire_of(tir, law)
    record = format_tir(tir)
    head = HEADER.format(version=version("flatplank_analysis"), source=name, law=LAWS[law].title)
    c_text = _tire_c(head, tire)
    # equal content has an equal token: a binary belongs to the description that it was made with
    token = hashlib.sha256((c_text + record).encode()).hexdigest()[:32]
    own = resources.files("flatplank_analysis") / "fmu" / "fmi3.c"
    return {
        "modelDescription.xml": _description(tire, law, name, token),
        "sources/buildDescription.xml": _build_description(),
        "sources/fmi3.c": own.read_text(encoding="utf-8"),
        "sources/tire.c": c_text,
        "sources/tire.h": _tire_h(head, tire, token),
        f"resources/{name}.tir": record,
    }


def _xml(root: ElementTree.Element) -> str:
    ElementTree.indent(root)
    text = ElementTree.tostring(root, encoding="unicode")
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{text}\n'


def _description(tire: Tire, law: str, name: str, token: str) -> str:
    root = ElementTree.Element(
        "fmiModelDescription", fmiVersion="3.0", modelName=name, instantiationToken=token,
        description=f"Transient tire {name}: {LAWS[law].title}. SI units, ISO W axes.",
        generationTool=f"flatplank {version('flatplank_analysis')}",
        variableNamingConvention="flat",
    )  # fmt: skip
    ElementTree.SubElement(
        root, "CoSimulation", modelIdentifier=IDENTIFIER, canGetAndSetFMUState="true",
        canSerializeFMUState="true", canHandleVariableCommunicationStepSize="true",
    )  # fmt: skip
    units = ElementTree.SubElement(root, "UnitDefinitions")
    for unit in dict.fromkeys(v.unit for v in tire.variables if v.unit):
        one = ElementTree.SubElement(units, "Unit", name=unit)
        ElementTree.SubElement(one, "BaseUnit", UNITS[unit])
    ElementTree.SubElement(root, "DefaultExperiment", startTime="0", stepSize=repr(STEP))
    variables = ElementTree.SubElement(root, "ModelVariables")
    structure = ElementTree.Element("ModelStructure")
    found = []
    for reference, v in enumerate(tire.variables):
        said = {
            "name": v.name, "valueReference": str(reference), "causality": v.causality,
            "variability": v.variability, "description": v.text,
        }  # fmt: skip
        said |= {"unit": v.unit} if v.unit else {}
        said |= {"start": repr(float(v.start))} if v.start is not None else {}
        ElementTree.SubElement(variables, "Float64", said)
        if v.causality == "output":
            found.append(str(reference))
    for kind in ("Output", "InitialUnknown"):
        for reference_text in found:
            ElementTree.SubElement(structure, kind, valueReference=reference_text)
    root.append(structure)
    return _xml(root)


def _build_description() -> str:
    root = ElementTree.Element("fmiBuildDescription", fmiVersion="3.0")
    build = ElementTree.SubElement(root, "BuildConfiguration", modelIdentifier=IDENTIFIER)
    files = ElementTree.SubElement(build, "SourceFileSet", language="C99")
    for file in ("fmi3.c", "tire.c"):
        ElementTree.SubElement(files, "SourceFile", name=file)
    return _xml(root)


def _tire_h(head: str, tire: Tire, token: str) -> str:
    kinds = [(v.causality, v.variability) for v in tire.variables]
    first = {
        "FIRST_INPUT": 1,
        "FIRST_FIXED": kinds.index(("parameter", "fixed")),
        "FIRST_TUNABLE": kinds.index(("parameter", "tunable")),
        "FIRST_OUTPUT": kinds.index(("output", "continuous")),
        "N_VALUES": len(kinds),
        "N_STATES": tire.states,
    }
    return "\n".join(
        [
            head, "#ifndef TIRE_H", "#define TIRE_H", f'#define TOKEN "{token}"',
            "enum {", *(f"    {name} = {number}," for name, number in first.items()), "};",
            "extern const double START_VALUES[N_VALUES];",
            "void tire_start(const double *in, double *state, double *out);",
            "void tire_step(const double *in, double h, double *state, double *out);",
            "#endif", "",
        ]
    )  # fmt: skip


def _tire_c(head: str, tire: Tire) -> str:
    starts = ", ".join(repr(float(v.start or 0.0)) for v in tire.variables)
    return "\n".join(
        [
            head, '#include "tire.h"', "", "#include <math.h>", "",
            f"const double START_VALUES[N_VALUES] = {{{starts}}};", "",
            "static double lesser(double a, double b) { return a < b || a != a ? a : b; }",
            "static double greater(double a, double b) { return a > b || a != a ? a : b; }", "",
            "void tire_start(const double *in, double *state, double *out) {", *tire.start, "}",
            "", "void tire_step(const double *in, double h, double *state, double *out) {",
            *tire.step, "}", "",
        ]
    )  # fmt: skip
