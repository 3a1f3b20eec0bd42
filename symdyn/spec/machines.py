"""The machines that ship with the package, by name."""

from __future__ import annotations

from pathlib import Path

from symdyn.base.errors import InputError, Problem, Where

FOLDER = Path(__file__).parent.parent / "machines"


def machine_names() -> tuple[str, ...]:
    return tuple(sorted(path.stem for path in FOLDER.glob("*.toml")))


def machine_file(model: str | Path) -> Path:
    """A path as it is; a bare name that is no file means a bundled machine. Raises InputError (SD003) if neither.

    A folder does not hide the machine of its name: ``generate`` makes such folders.
    """
    path = Path(model)
    if path.is_file() or path.suffix or len(path.parts) > 1:
        return path
    bundled = FOLDER / f"{model}.toml"
    if not bundled.is_file():
        if path.exists():
            return path
        names = ", ".join(machine_names())
        raise InputError(
            Problem(
                "SD003", f"no file and no bundled machine is called {model!r}", Where(str(model)), f"bundled: {names}"
            )
        )
    return bundled
