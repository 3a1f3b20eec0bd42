"""The serial chain of a URDF's tree: from its base to a tip, fixed links merged, other branches refused or locked."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symdyn.base.wording import did_you_mean, listed, quoted
from symdyn.spec.findings import Findings
from symdyn.spec.rotations import Array, snapped
from symdyn.spec.urdf_document import MOVING, UrdfDocument, UrdfJoint, UrdfLink
from symdyn.spec.urdf_tree import UrdfTree, read_tree
from symdyn.spec.xml_source import at

_SHOWN = 6


@dataclass(frozen=True, slots=True)
class Chain:
    """Which chain of a tree to take. ``lock_others``: moving branches on it are fixed at zero, else refused."""

    base: str | None = None
    tip: str | None = None
    lock_others: bool = False


WHOLE = Chain()


@dataclass(frozen=True, eq=False)
class Segment:
    """One moving joint and all links that move with it, placed (4, 4) in the joint's child link.

    ``before`` (4, 4) places the joint in the previous segment's child link (the base, for the first).
    """

    joint: UrdfJoint
    before: Array
    links: list[tuple[UrdfLink, Array]]


@dataclass(frozen=True, eq=False)
class UrdfChain:
    """``tip`` (4, 4) places the tip in the last segment's child link; None: no tip was named."""

    base: str
    segments: list[Segment]
    tip: Array | None


Exit = tuple[UrdfJoint, Array]  # a moving joint, and its parent link's place


def choose_chain(document: UrdfDocument, wanted: Chain, findings: Findings) -> UrdfChain | None:
    """None where there is no such chain: SD406 no tree, SD412 it branches, SD414 nothing moves, SD415 no such link."""
    tree = read_tree(document, wanted.base, findings)
    if tree is None:
        return None
    path = _path(document, tree, wanted.tip, findings)
    if path is None:
        return None
    segments: list[Segment] = []
    links, exits = _rigid(tree.root, np.eye(4), document, tree)
    while exits:
        chosen = _chosen(exits, path, wanted, tree, findings)
        if chosen is None and wanted.tip is None:
            return None
        others = [each for each in exits if chosen is None or each[0] is not chosen[0]]
        if segments:
            links += _locked(others, wanted, document, tree, findings)
        elif others and chosen is not None:
            names = listed(quoted(joint.name) for joint, _ in others)
            findings.warning(
                at(others[0][0].element), "SD412", f"left out, as they hang on the base, which does not move: {names}"
            )
        if chosen is None:
            break
        joint, place = chosen
        if not _is_supported(joint, findings):
            return None
        links, exits = _rigid(joint.child, np.eye(4), document, tree)
        segments.append(Segment(joint, _product(place, joint.origin), links))
    if not segments:
        findings.error(at(document.source.root), "SD414", "no joint of the chain moves", "all are fixed")
        return None
    tip = None
    if wanted.tip is not None:
        tip = next((place for link, place in segments[-1].links if link.name == wanted.tip), None)
    return UrdfChain(tree.root, segments, tip)


def _path(document: UrdfDocument, tree: UrdfTree, tip: str | None, findings: Findings) -> list[UrdfJoint] | None:
    """The joints to the tip; empty where none is named."""
    if tip is None:
        return []
    root = at(document.source.root)
    if tip not in document.links:
        findings.error(
            root, "SD415", f"no link {quoted(tip)} to be the tip", did_you_mean(tip, document.links, "links")
        )
        return None
    path = tree.path_to(tip, tree.root)
    if path is None:
        findings.error(root, "SD415", f"link {quoted(tip)} is not behind the base {quoted(tree.root)}")
    return path


def _rigid(
    link: str, place: Array, document: UrdfDocument, tree: UrdfTree
) -> tuple[list[tuple[UrdfLink, Array]], list[Exit]]:
    """The links fixed to one, with their places, itself first; and the moving joints that hang on them."""
    links, exits = [], []
    pending = [(link, place)]
    while pending:
        name, where = pending.pop()
        links.append((document.links[name], where))
        fixed = []
        for joint in tree.joints_of.get(name, []):
            if joint.kind == "fixed":
                fixed.append((joint.child, _product(where, joint.origin)))
            else:
                exits.append((joint, where))
        pending.extend(reversed(fixed))
    return links, exits


def _chosen(exits: list[Exit], path: list[UrdfJoint], wanted: Chain, tree: UrdfTree, findings: Findings) -> Exit | None:
    """The joint by which the chain goes on; None at its end, or where several could (told)."""
    if wanted.tip is not None:
        return next((each for each in exits if any(each[0] is joint for joint in path)), None)
    if len(exits) == 1:
        return exits[0]
    parents = dict.fromkeys(joint.parent for joint, _ in exits)
    names = listed((quoted(joint.name) for joint, _ in exits), _SHOWN)
    ends = [end for joint, _ in exits for end in tree.ends_behind(joint)]
    findings.error(
        at(exits[1][0].element),
        "SD412",
        f"the robot branches at {listed(quoted(name) for name in parents)}: joints {names}",
        f"symdyn derives serial chains: choose one with --tip LINK (ends here: {listed(ends, _SHOWN)}); "
        "--lock-others fixes the branches that it carries",
    )
    return None


def _locked(
    exits: list[Exit], wanted: Chain, document: UrdfDocument, tree: UrdfTree, findings: Findings
) -> list[tuple[UrdfLink, Array]]:
    """The links of branches that are carried, all their joints at zero."""
    found: list[tuple[UrdfLink, Array]] = []
    for joint, place in exits:
        if not wanted.lock_others:
            findings.error(
                at(joint.element),
                "SD412",
                f"link {quoted(joint.parent)} of the chain carries a branch that moves, joint {quoted(joint.name)}",
                "give --lock-others to fix it at zero, as a part of that link",
            )
            continue
        moving = listed((quoted(each.name) for each in tree.behind(joint) if each.kind != "fixed"), _SHOWN)
        findings.warning(at(joint.element), "SD412", f"locked at zero, as parts of {quoted(joint.parent)}: {moving}")
        pending = [(joint, place)]
        while pending:
            branch, parent = pending.pop()
            links, further = _rigid(branch.child, _product(parent, branch.origin), document, tree)
            found += links
            pending.extend(reversed(further))
    return found


def _is_supported(joint: UrdfJoint, findings: Findings) -> bool:
    if joint.mimics is not None:
        findings.error(
            at(joint.element),
            "SD407",
            f"joint {quoted(joint.name)} mimics {quoted(joint.mimics)}: coupled joints are not supported",
            "choose a chain without it (--tip LINK), or remove <mimic> to let it move by itself",
        )
        return False
    if joint.kind not in MOVING:
        findings.error(
            at(joint.element.attributes["type"]),
            "SD407",
            f"joint {quoted(joint.name)} is {joint.kind}, which is not supported",
            f"begin the chain behind it: --base {joint.child}",
        )
        return False
    return True


def _product(first: Array, second: Array) -> Array:
    result: Array = first @ second
    result[:3, :3] = snapped(result[:3, :3])
    return result
