"""The tree that the joints of a URDF make of its links, checked: one root, no loops, every link there."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from symdyn.base.wording import did_you_mean, listed, quoted
from symdyn.spec.findings import Findings
from symdyn.spec.urdf_document import UrdfDocument, UrdfJoint
from symdyn.spec.xml_source import at


@dataclass(frozen=True, slots=True)
class UrdfTree:
    """``joints_of`` holds the joints on a link, in the order of the file; ``joint_to`` the one that leads to it."""

    root: str
    joints_of: dict[str, list[UrdfJoint]]
    joint_to: dict[str, UrdfJoint]

    def behind(self, joint: UrdfJoint) -> Iterator[UrdfJoint]:
        """The joint and all that hang on it, depth first."""
        pending = [joint]
        while pending:
            current = pending.pop()
            yield current
            pending.extend(reversed(self.joints_of.get(current.child, [])))

    def ends_behind(self, joint: UrdfJoint) -> list[str]:
        """The links at which the branches behind a joint end."""
        return [each.child for each in self.behind(joint) if not self.joints_of.get(each.child)]

    def path_to(self, link: str, base: str) -> list[UrdfJoint] | None:
        """The joints that lead from one link to another; None where none do."""
        path: list[UrdfJoint] = []
        while link != base:
            joint = self.joint_to.get(link)
            if joint is None:
                return None
            path.append(joint)
            link = joint.parent
        return path[::-1]


def read_tree(document: UrdfDocument, base: str | None, findings: Findings) -> UrdfTree | None:
    """The tree, from ``base`` if that is given; None where the joints make none (SD406, told)."""
    joint_to: dict[str, UrdfJoint] = {}
    joints_of: dict[str, list[UrdfJoint]] = {}
    sound = True
    for joint in document.joints.values():
        sound = _ends_exist(joint, document, findings) and sound
        other = joint_to.setdefault(joint.child, joint)
        if other is not joint:
            message = (
                f"link {quoted(joint.child)} has two parents: joints {quoted(other.name)} and {quoted(joint.name)}"
            )
            findings.error(at(joint.element), "SD406", message, "a robot is a tree; loops are not supported")
            sound = False
        joints_of.setdefault(joint.parent, []).append(joint)
    if not sound:
        return None
    tree = UrdfTree("", joints_of, joint_to)
    if _tell_loop(tree, findings):
        return None
    roots = [name for name in document.links if name not in joint_to]
    if base is not None:
        if base not in document.links:
            hint = did_you_mean(base, document.links, "links")
            findings.error(at(document.source.root), "SD415", f"no link {quoted(base)} to be the base", hint)
            return None
        return UrdfTree(base, joints_of, joint_to)
    if len(roots) != 1:
        message = f"several links have no parent: {listed(roots)}" if roots else "the robot has no links"
        element = document.links[roots[1]].element if roots else document.source.root
        hint = "join them with fixed joints, or choose one: --base LINK" if roots else ""
        findings.error(at(element), "SD406", message, hint)
        return None
    return UrdfTree(roots[0], joints_of, joint_to)


def _ends_exist(joint: UrdfJoint, document: UrdfDocument, findings: Findings) -> bool:
    sound = True
    for end in ("parent", "child"):
        link = getattr(joint, end)
        element = joint.element.first(end)
        if link not in document.links and element is not None:
            message = f"the {end} of joint {quoted(joint.name)}, {quoted(link)}, does not exist"
            findings.error(
                at(element.attributes["link"]), "SD406", message, did_you_mean(link, document.links, "links")
            )
            sound = False
    if joint.parent == joint.child:
        message = f"joint {quoted(joint.name)} joins link {quoted(joint.child)} to itself"
        findings.error(at(joint.element), "SD406", message)
        sound = False
    return sound


def _tell_loop(tree: UrdfTree, findings: Findings) -> bool:
    known: set[str] = set()  # links that lead to a root
    for start in tree.joint_to:
        walked: dict[str, UrdfJoint] = {}
        link = start
        while link in tree.joint_to and link not in known and link not in walked:
            walked[link] = tree.joint_to[link]
            link = walked[link].parent
        if link in walked:
            names = list(walked)
            loop = [walked[name].name for name in names[names.index(link) :]][::-1]
            message = f"joints {listed(quoted(name) for name in loop)} make a loop"
            findings.error(at(walked[link].element), "SD406", message, "a robot is a tree; loops are not supported")
            return True
        known.update(walked)
    return False
