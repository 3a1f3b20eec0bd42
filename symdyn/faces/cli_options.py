"""Arguments that many commands share."""

from __future__ import annotations

from typing import Annotated

import typer

Model = Annotated[str, typer.Argument(help="A robot.toml, a URDF, or the name of a bundled machine (`symdyn check`).")]
Json = Annotated[bool, typer.Option("--json", help="Print the facts as JSON on stdout.")]
