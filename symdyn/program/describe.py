"""A program as a listing for people: ``%12 = mul %3 %4  # link 2: angular velocity``."""

from __future__ import annotations

from symdyn.program.ssa import Node, Op, Program


def describe(program: Program) -> str:
    """One line per node, after a head with the arguments and before a foot with the outputs."""
    arguments = ", ".join(f"{argument.name}[{len(argument.symbols)}]" for argument in program.arguments)
    shape = " x ".join(str(extent) for extent in program.shape) or "scalar"
    body = [_line(index, node) for index, node in enumerate(program.nodes)]
    outputs = " ".join(f"%{output}" for output in program.outputs)
    return "\n".join([f"{program.name}({arguments}) -> {shape}", *body, f"return {outputs}".rstrip()])


def _line(index: int, node: Node) -> str:
    if node.op is Op.CONST:
        return f"%{index} = {node.value!r}"
    if node.op is Op.INPUT:
        return f"%{index} = input {node.name}"
    text = f"%{index} = {node.op} " + " ".join(f"%{argument}" for argument in node.args)
    comment = ": ".join(part for part in (node.name, node.origin) if part)
    return f"{text}  # {comment}" if comment else text
