"""The commands that work on models: check, derive, generate, latex, convert, effects."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from typing import Any

from symdyn import compiler
from symdyn.base.errors import Problem, UsageError
from symdyn.base.files import write_atomically
from symdyn.emit.targets import DEFAULT_TARGET
from symdyn.faces.console import err, out, print_json, print_table, print_warnings, status
from symdyn.faces.recordings import open_recording
from symdyn.numeric.recording import Recording
from symdyn.spec.machines import machine_file, machine_names
from symdyn.spec.places import places
from symdyn.spec.records import Robot
from symdyn.spec.urdf_chain import WHOLE, Chain


def check(model: str | None, chain: Chain, recordings: list[Path], channel_map: Path | None, json: bool) -> None:
    if model is None:
        if chain != WHOLE:
            raise UsageError(Problem("SD010", "--base, --tip and --lock-others choose from a URDF: name one"))
        _list_machines(json)
        return
    robot, warnings = compiler.load_with_warnings(model, chain)
    print_warnings(warnings)
    read = [open_recording(path, robot, channel_map) for path in recordings]
    for recording in read:
        print_warnings(recording.warnings)
    if json:
        print_json(
            {
                "robot": robot.name,
                "joints": [joint.name for joint in robot.joints],
                "places": [place.address for place in places(robot)],
                "effects": [{"type": e.type, "at": e.at} for e in robot.effects],
                "parameters": {p.name: {"value": p.value, "unit": p.unit} for p in robot.parameters},
                "warnings": [str(w) for w in (*warnings, *(w for r in read for w in r.warnings))],
                "recordings": [_recording_facts(recording) for recording in read],
            }
        )
        return
    out.print(f"{robot.name}: {robot.description}", markup=False)
    kinds = ", ".join(f"{joint.name} ({joint.kind})" for joint in robot.joints)
    out.print(f"joints: {kinds}", markup=False)
    out.print(f"places for effects: {', '.join(place.address for place in places(robot))}", markup=False)
    rows = [(p.name, "free" if p.value is None else f"{p.value:.6g}", p.unit, p.meaning) for p in robot.parameters]
    print_table("", ("parameter", "value", "unit", "meaning"), rows)
    for recording in read:
        length = recording.time[-1] - recording.time[0]
        out.print(
            f"{recording.name}: {len(recording.time)} samples, {length:.6g} s at {1 / recording.sample_time:.6g} Hz, "
            f"{len(recording.segments)} segment(s)",
            markup=False,
        )


def derive(model: str, chain: Chain, steps: bool, json: bool) -> None:
    from symdyn.derive.equations import equations_of_motion
    from symdyn.emit import plain_text

    equations = equations_of_motion(compiler.load_robot(model, chain))
    shown = plain_text.equations(equations)
    named = plain_text.steps(equations) if steps else []
    if json:
        print_json(
            {
                "coordinates": [{"name": str(a.q), "place": a.address, "unit": a.unit} for a in equations.axes],
                "equations": dict(shown),
                "steps": [{"symbol": s, "expression": e, "origin": o} for s, e, o in named],
            }
        )
        return
    for axis in equations.axes:
        out.print(f"{axis.q}: {axis.address} [{axis.unit}]", markup=False)
    for place, text in shown:
        out.print(f"\n{place}:\n  {text}", markup=False)
    for symbol, expression, origin in named:
        out.print(f"{symbol} = {expression}    # {origin}", markup=False)


def generate(models: list[str], chain: Chain, folder: Path, everything: bool, targets: list[str], json: bool) -> None:
    if everything == bool(models):
        raise UsageError(Problem("SD011", "name the robots to generate, or give --all for the bundled machines"))
    wanted = list(machine_names()) if everything else models
    robots = [compiler.load_robot(model, chain) for model in wanted]
    names = Counter(robot.name for robot in robots)
    for name, times in names.items():
        if times > 1:
            raise UsageError(Problem("SD010", f"{times} robots are named {name}; the name is the folder to write to"))
    written: dict[str, list[str]] = {}
    with status(json) as progress:
        for robot in robots:
            progress(f"generating {robot.name}")
            paths = compiler.generate(robot, folder / robot.name.replace("-", "_"), targets or (DEFAULT_TARGET,))
            written[robot.name] = [str(path) for path in paths]
    if json:
        print_json(written)
        return
    for name, files in written.items():
        out.print(f"{name}: {', '.join(files)}", markup=False)


def latex(model: str, chain: Chain, path: Path | None) -> None:
    from symdyn.derive.equations import equations_of_motion
    from symdyn.emit.latex import document

    _write(document(equations_of_motion(compiler.load_robot(model, chain))), path)


def convert(model: str, chain: Chain, into: Path | None, path: Path | None) -> None:
    """``chain`` chooses from the tree of the URDF: that which is read, or that which is written into."""
    is_toml = machine_file(model).suffix == ".toml"
    robot, warnings = compiler.load_with_warnings(model, WHOLE if is_toml and into is not None else chain)
    print_warnings(warnings)
    _write(robot.text if into is None else compiler.robot_into_urdf(robot, into, chain), path)


def _write(text: str, path: Path | None) -> None:
    if path is None:
        sys.stdout.write(text)
        return
    write_atomically(path, text)
    err.print(f"written: {path}", markup=False)


def effects(json: bool) -> None:
    from symdyn.emit.plain_text import catalogue_rows

    rows = catalogue_rows()
    if json:
        print_json(rows)
        return
    shown = [
        (r["effect"], ", ".join(r["at"]), ", ".join(r["parameters"]), r["signature"] or "is declared, never proposed")
        for r in rows
    ]
    print_table("", ("effect", "attaches to", "parameters", "how it shows in a recording"), shown, whole="effect")
    for r in rows:
        out.print(f"\n{r['effect']}: {r['title']} ({r['source']})", markup=False)
        for quantity, law in r["laws"].items():
            out.print(f"  {quantity} = {law}", markup=False)
        for name, parameter in r["parameters"].items():
            units = " or ".join(dict.fromkeys(parameter["units"].values()))
            null = "" if parameter["null"] is None else f"; none at {float(parameter['null']):g}"
            out.print(f"  {name} [{units}]: {parameter['meaning']}{null}", markup=False)
        if r["builds_on"]:
            out.print(f"  corrects: {r['builds_on']}", markup=False)
        if r["rivals"]:
            out.print(f"  rivals: {', '.join(r['rivals'])}", markup=False)


def refuse_free_parameters(robot: Robot) -> None:
    """Raises UsageError (SD304) for a robot that has parameters without a value."""
    free = [p.name for p in robot.parameters if p.value is None]
    if free:
        raise UsageError(Problem("SD304", f"these parameters have no value: {', '.join(free)}", robot.where))


def _recording_facts(recording: Recording) -> dict[str, Any]:
    return {
        "name": recording.name,
        "samples": len(recording.time),
        "sample_time": recording.sample_time,
        "segments": len(recording.segments),
        "channels": [
            {"quantity": quantity, "joint": joint, "side": side, "quantisation_noise": noise}
            for (quantity, joint, side), noise in recording.quantisation.items()
        ],
    }


def _list_machines(json: bool) -> None:
    robots = [compiler.load_robot(machine_file(name)) for name in machine_names()]
    if json:
        print_json([{"name": r.name, "description": r.description} for r in robots])
        return
    print_table("bundled machines", ("name", "description"), [(r.name, r.description) for r in robots])
