"""The diagnosed robot.toml with the lines marked that the diagnosis wrote."""

from __future__ import annotations

from difflib import SequenceMatcher

from markupsafe import Markup

from symdyn.spec.records import Robot


def marked_specification(given: Robot, diagnosed: Robot) -> Markup:
    """The text of ``diagnosed`` in a ``<pre>``; what ``given`` does not have stands in ``<ins>``."""
    before, after = given.text.splitlines(), diagnosed.text.splitlines()
    pieces = []
    for kind, _, _, start, stop in SequenceMatcher(None, before, after, autojunk=False).get_opcodes():
        for line in after[start:stop]:
            pieces.append((Markup("{}\n") if kind == "equal" or not line else Markup("<ins>{}</ins>\n")).format(line))
    return Markup("<pre>{}</pre>").format(Markup("").join(pieces))
