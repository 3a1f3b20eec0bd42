"""A chain of a URDF as a Robot. A link's frame is that of the URDF, turned so that the joint's axis is z."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from symdyn.base.names import collisions, identifier_problem, robot_name_problem
from symdyn.base.wording import listed, quoted
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.findings import Findings
from symdyn.spec.inertias import Inertial, cleaned, joined
from symdyn.spec.numbers import NumberReader, Slot
from symdyn.spec.parameters import Parameters
from symdyn.spec.places import joint_places
from symdyn.spec.records import (
    ZERO,
    Convention,
    EffectSpec,
    Joint,
    JointKind,
    Link,
    Monomial,
    Placement,
    Robot,
    Tool,
)
from symdyn.spec.rotations import Array, as_record, onto
from symdyn.spec.slots import com_slots, effect_slot, gravity_slots, inertia_slots, mass_slot, position_slots
from symdyn.spec.toml_positions import KeyPath
from symdyn.spec.urdf_chain import Segment, UrdfChain
from symdyn.spec.urdf_document import UrdfDocument, UrdfInertial, UrdfLink
from symdyn.spec.urdf_names import joint_identifier, robot_identifier, shown
from symdyn.spec.xml_source import at

Catalogue = Mapping[str, EffectSchema]

GRAVITY = (0.0, 0.0, -9.81)
DYNAMICS = (("damping", "viscous_friction", "coefficient"), ("friction", "coulomb_friction", "level"))


def own_inertial(inertial: UrdfInertial) -> Inertial:
    """A link's inertial in the axes of the link."""
    rotation = inertial.rotation
    return Inertial(inertial.mass, inertial.com, cleaned(rotation @ inertial.tensor @ rotation.T))


def aligned(segment: Segment) -> Array:
    """(4, 4) the symdyn frame of a segment in its URDF link: turned so that z is the joint's axis."""
    turn = np.eye(4)
    turn[:3, :3] = onto(segment.joint.axis)
    return turn


def bodies(segment: Segment) -> list[tuple[UrdfLink, Inertial]]:
    """Every link of a segment that has an inertial, seen from the segment's symdyn frame."""
    back = aligned(segment).T  # a turn alone
    return [
        (link, own_inertial(link.inertial).seen_from(back @ place))
        for link, place in segment.links
        if link.inertial is not None
    ]


def build_robot(document: UrdfDocument, chain: UrdfChain, catalogue: Catalogue, findings: Findings) -> Robot:
    """The robot, its numbers as parameters with the place of their attribute; what is doubtful is told."""
    numbers = NumberReader(Parameters({}, findings), findings)
    make = _Maker(document, numbers)
    x, y, z = make.monomials(GRAVITY, gravity_slots())
    names = _joint_names(chain.segments, findings)
    name = robot_identifier(document.name)
    problem = robot_name_problem(name)
    if problem is not None:
        findings.error(at(document.source.root), problem.code, problem.message, problem.hint)
    placements = list(make.placements(chain, names))
    joints = tuple(
        make.joint(segment, ("joint", i), names[i], placements[i]) for i, segment in enumerate(chain.segments)
    )
    tool = make.tool(chain)
    effects = tuple(make.effects(chain.segments, joints, catalogue))
    return Robot(
        name,
        _description(document, chain),
        Convention.MODIFIED,
        (x, y, z),
        joints,
        effects,
        numbers.parameters.every,
        where=findings.where(at(document.source.root)),
        tool=tool,
    )


@dataclass(frozen=True, slots=True)
class _Maker:
    document: UrdfDocument
    numbers: NumberReader

    def monomials(self, values: Sequence[float] | Array, slots: Sequence[Slot]) -> list[Monomial]:
        """A parameter for each value that is not zero."""
        return [
            self.numbers.literal(float(value), slot) if value else ZERO
            for value, slot in zip(values, slots, strict=True)
        ]

    def placements(self, chain: UrdfChain, names: Sequence[str]) -> Iterator[Placement]:
        previous = np.eye(4)
        for i, (segment, name) in enumerate(zip(chain.segments, names, strict=True)):
            origin = segment.joint.element.first("origin") or segment.joint.element
            turn = aligned(segment)
            yield self._placement(previous.T @ segment.before @ turn, ("joint", i, "placement"), name, origin.start)
            previous = turn

    def tool(self, chain: UrdfChain) -> Tool | None:
        """The tip that was named, where it is not the last link's own frame."""
        if chain.tip is None or np.array_equal(chain.tip, np.eye(4)):
            return None
        place = aligned(chain.segments[-1]).T @ chain.tip
        return Tool(self._placement(place, ("tool", "placement"), "tool", self.document.source.root.start))

    def _placement(self, place: Array, path: KeyPath, owner: str, offset: int) -> Placement:
        self.document.source.named[path] = offset
        x, y, z = self.monomials(cleaned(place[:3, 3]), position_slots(path, owner))
        return Placement((x, y, z), as_record(place[:3, :3]))

    def joint(self, segment: Segment, path: KeyPath, name: str, placement: Placement) -> Joint:
        kind = JointKind.PRISMATIC if segment.joint.kind == "prismatic" else JointKind.REVOLUTE
        described = "moves " + " with ".join(
            part for part in (_told([segment.links[0]]), _told(segment.links[1:])) if part
        )
        self.document.source.named[path] = segment.joint.element.start
        link = self._link(segment, (*path, "link"), name)
        return Joint(name, kind, placement, link, limits=segment.joint.limits, description=described)

    def _link(self, segment: Segment, path: KeyPath, name: str) -> Link:
        own = segment.links[0][0]
        found = bodies(segment)
        whole = joined(body for _, body in found)
        named = next((link.inertial.element for link, _ in found if link.inertial is not None), own.element)
        self.document.source.named[path] = named.start
        if not found:
            self.numbers.findings.warning(
                at(own.element), "SD410", f"link {quoted(own.name)} has no <inertial>: taken as massless"
            )
        tensor = whole.tensor
        entries = (*np.diag(tensor), tensor[0, 1], tensor[0, 2], tensor[1, 2])
        (mass,) = self.monomials([whole.mass], [mass_slot(path, name)])
        cx, cy, cz = self.monomials(whole.com, com_slots(path, name))
        xx, yy, zz, xy, xz, yz = self.monomials(entries, inertia_slots(path, name))
        return Link(mass, (cx, cy, cz), (xx, yy, zz, xy, xz, yz))

    def effects(
        self, segments: Sequence[Segment], joints: Sequence[Joint], catalogue: Catalogue
    ) -> Iterator[EffectSpec]:
        """Damping and friction of <dynamics>, where they are not zero."""
        count = 0
        for segment, joint in zip(segments, joints, strict=True):
            for attribute, effect, key in DYNAMICS:
                value = getattr(segment.joint, attribute)
                if not value:
                    continue
                path: KeyPath = ("effect", count)
                dynamics = segment.joint.element.first("dynamics")
                assert dynamics is not None
                self.document.source.named[path] = dynamics.attributes[attribute].start
                schema = catalogue[effect]
                parameter = next(p for p in schema.parameters if p.name == key)
                slot = effect_slot(path, parameter, schema, next(joint_places(joint)))
                monomial = self.numbers.literal(value, slot)
                yield EffectSpec(effect, joint.name, ((key, monomial),), self.numbers.findings.where(path))
                count += 1


def _joint_names(segments: Sequence[Segment], findings: Findings) -> list[str]:
    names = [joint_identifier(segment.joint.name) for segment in segments]
    for segment, name in zip(segments, names, strict=True):
        problem = identifier_problem(name)
        if problem is not None:
            findings.error(at(segment.joint.element.attributes["name"]), problem.code, problem.message, problem.hint)
    for later, first in collisions(names):
        joint, other = segments[later].joint, segments[first].joint
        findings.error(
            at(joint.element.attributes["name"]),
            "SD103",
            f"joints {quoted(joint.name)} and {quoted(other.name)} would both be called {quoted(names[first])}",
            "rename one of them",
        )
    return names


def _description(document: UrdfDocument, chain: UrdfChain) -> str:
    return f"{shown(document.name) or 'a robot'}, read from a URDF, from {shown(chain.base)} on"


def _told(links: Sequence[tuple[UrdfLink, Array]]) -> str:
    return listed(shown(link.name) for link, _ in links)
