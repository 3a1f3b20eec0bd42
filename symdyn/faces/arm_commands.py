"""The commands that ask about the rigid arm alone: base-parameters, variants."""

from __future__ import annotations

import math
from dataclasses import asdict

from symdyn import compiler
from symdyn.base.errors import Problem, UsageError
from symdyn.faces.console import out, print_json, print_table
from symdyn.faces.model_commands import refuse_free_parameters
from symdyn.spec.urdf_chain import Chain


def base_parameters(model: str, chain: Chain, json: bool) -> None:
    from symdyn.emit import plain_text

    robot = compiler.load_robot(model, chain)
    rows = plain_text.base_parameters(robot)
    if json:
        print_json([{"link": a, "entry": b, "expression": c, "unit": d} for a, b, c, d in rows])
        return
    out.print(f"{len(rows)} base parameters, entries of the pseudo-inertias in the joint frames:", markup=False)
    for link, entry, expression, unit in rows:
        out.print(f"{link} {entry} [{unit}] = {expression}", markup=False)


def variants(model: str, chain: Chain, states: int, speed: float, json: bool) -> None:
    from symdyn.derive.equations import equations_of_motion
    from symdyn.program.variants import variant_table

    if states < 1 or not (math.isfinite(speed) and speed > 0):
        raise UsageError(Problem("SD302", "--states and --speed must be positive"))
    robot = compiler.load_robot(model, chain)
    refuse_free_parameters(robot)
    rows = variant_table(equations_of_motion(robot), states, speed)
    joints = [joint.name for joint in robot.joints]
    if json:
        facts = [
            {
                "variant": row.name,
                "is": row.doc,
                "operations": asdict(row.cost),
                "weight": row.weight,
                "error": {name: None if math.isnan(e) else e for name, e in zip(joints, row.error, strict=True)},
            }
            for row in rows
        ]
        print_json(facts)
        return
    table = [
        ("additions", *(str(row.cost.additions) for row in rows)),
        ("multiplications", *(str(row.cost.multiplications) for row in rows)),
        ("sines and cosines", *(str(row.cost.trigonometric) for row in rows)),
        ("estimated time", *(f"{100 * row.weight / (rows[0].weight or 1):.0f} %" for row in rows)),
        *((f"error at {name}", *(_percent(row.error[k]) for row in rows)) for k, name in enumerate(joints)),
    ]
    columns = ("", *(row.doc for row in rows))
    print_table(f"{robot.name}: inverse dynamics of the arm, at {states} random states", columns, table)


def _percent(error: float) -> str:
    return "no effort" if math.isnan(error) else f"{100 * error:.3g} %"
