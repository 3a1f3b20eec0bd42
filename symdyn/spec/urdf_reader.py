"""Reads a serial robot from a URDF: the same Robot that a TOML file gives, with the TOML that says the same."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from symdyn.base.errors import Problem
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.findings import Findings
from symdyn.spec.physical_checks import check_mass_matrix, doubtful_moments
from symdyn.spec.records import Robot
from symdyn.spec.toml_source import read_text
from symdyn.spec.toml_writer import to_toml
from symdyn.spec.urdf_chain import WHOLE, Chain, UrdfChain, choose_chain
from symdyn.spec.urdf_document import UrdfDocument, read_document
from symdyn.spec.urdf_robot import build_robot
from symdyn.spec.xml_source import LARGEST_XML, at, parse_xml

Catalogue = Mapping[str, EffectSchema]


def read_urdf(path: str | Path, catalogue: Catalogue, chain: Chain = WHOLE) -> tuple[Robot, tuple[Problem, ...]]:
    """The robot in a URDF file, and what is doubtful in it. InputError with every problem found."""
    return read_urdf_text(read_text(path, LARGEST_XML), str(path), catalogue, chain)


def read_urdf_text(
    text: str, file: str, catalogue: Catalogue, chain: Chain = WHOLE
) -> tuple[Robot, tuple[Problem, ...]]:
    """As ``read_urdf``; ``file`` is the name that its errors show."""
    document, selected, findings = read_chain(text, file, chain)
    robot = build_robot(document, selected, catalogue, findings)
    check_mass_matrix(robot, findings)
    findings.raise_errors()
    doubts = (*document.source.foreign, *findings.warnings)
    return replace(robot, text=to_toml(robot, catalogue)), doubts


def read_chain(text: str, file: str, chain: Chain) -> tuple[UrdfDocument, UrdfChain, Findings]:
    """The chain of a URDF text, before it is a robot. InputError where there is none."""
    source = parse_xml(text.removeprefix("\ufeff"), file)
    findings = Findings(source)
    document = read_document(source, findings)
    findings.raise_errors()
    assert document is not None  # without a document there are errors
    selected = choose_chain(document, chain, findings)
    findings.raise_errors()
    assert selected is not None
    _check_moments(selected, findings)
    return document, selected, findings


def _check_moments(chain: UrdfChain, findings: Findings) -> None:
    """Public URDFs are full of inertias that no body has: told, and refused only where the robot cannot be moved."""
    for segment in chain.segments:
        for link, _ in segment.links:
            if link.inertial is not None and np.isfinite(link.inertial.tensor).all():
                doubt = doubtful_moments(link.inertial.tensor, link.name)
                if doubt is not None:
                    findings.warning(at(link.inertial.element), *doubt)
