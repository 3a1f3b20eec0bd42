"""The command cost: operations of every function, and what each pass earned and took."""

from __future__ import annotations

from symdyn.compiler import compile_robot, load_robot
from symdyn.program.cost import count

from .command_line import run


def test_every_function_has_its_row() -> None:
    done = run("cost", "two-link")
    assert (done.code, done.err) == (0, "")
    forms = compile_robot(load_robot("two-link")).forms
    cells = [[cell.strip() for cell in line.split("│")] for line in done.out.splitlines()]
    rows = {name: numbers for name, *numbers in cells}
    for form in forms:
        cost = count(form.program)
        expected = [cost.additions, cost.multiplications, cost.divisions, cost.trigonometric, cost.other]
        assert [int(word) for word in rows[form.name][:5]] == expected
        assert float(rows[form.name][5]) >= 0.0
    assert done.out.splitlines()[-1].startswith("all functions: ")


def test_the_passes_of_one_function() -> None:
    done = run("cost", "two-link", "--function", "inverse_dynamics", "--json")
    assert (done.code, done.err) == (0, "")
    (facts,) = done.json()
    passes = facts["passes"]
    form = next(f for f in compile_robot(load_robot("two-link")).forms if f.name == "inverse_dynamics")
    assert facts["function"] == "inverse_dynamics"
    assert [(row["pass"], row["round"]) for row in passes] == [(row.pass_name, row.round) for row in form.costs]
    assert passes[-1]["multiplications"] == count(form.program).multiplications
    assert passes[0]["milliseconds"] == 0.0  # the input: nothing was done yet
    assert sum(row["milliseconds"] for row in passes) > 0.0
    shown = run("cost", "two-link", "--function", "inverse_dynamics")
    assert shown.code == 0
    assert all(row["pass"] in shown.out for row in passes)


def test_a_function_that_the_kernel_does_not_have() -> None:
    done = run("cost", "two-link", "--function", "inverse_dynamic")
    assert (done.code, done.out) == (2, "")
    assert done.err == (
        "error: SD306: the kernel has no function `inverse_dynamic`\n    did you mean `inverse_dynamics`?\n"
    )
