"""Angle sums and squares of sine and cosine recognised: cos a cos b - sin a sin b is cos(a + b).

One law covers all forms, with any common factor R: two terms of a sum that hold cos a cos b and
sin a sin b, or sin a cos b and cos a sin b, are one sine or cosine of a + b or a - b. For a = b that
is cos^2 + sin^2 = 1 and cos^2 - sin^2 = cos 2a. In addition R - R sin^2 is R cos^2, and the reverse.
A group of rewrites for one pair of angles is kept only if the program's weight does not rise, which
with a sine at twenty additions means: if other sines or cosines are no longer needed.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from symdyn.program.cost import WEIGHTS, weight
from symdyn.program.polynomial import Call, PolynomialProgram, Polynomials, Product, Sum, Term
from symdyn.program.polynomial_read import from_program
from symdyn.program.polynomial_write import to_program
from symdyn.program.ssa import Op, Program

_WAVES = frozenset({Op.SIN, Op.COS})
_WAVE = WEIGHTS[Op.SIN]
_TRIALS = 64  # groups tried one by one when all of them together cost more

_Group = tuple[str, int, int]  # kind of law and the two angles
_Key = tuple[_Group, float, tuple[int, ...]]  # group, size of the coefficient, the other factors


@dataclass(frozen=True, slots=True)
class _Half:
    """One of the two terms of a law: where it stands in its sum, and which half it is."""

    place: int
    coefficient: float
    rest: tuple[int, ...]  # the common factor
    form: str  # "cc", "ss"; "sc" is sin a cos b with a < b, "cs" the reverse; "1" is the bare common factor


def trigonometric(program: Program) -> Program:
    """Apply the laws where they cost nothing."""
    groups = _groups(program)
    if not groups:
        return program
    everything = _rewritten(program, groups)
    if everything is not None and weight(everything) <= weight(program):
        return everything
    kept: list[_Group] = []
    best = program
    for group in groups[:_TRIALS]:
        trial = _rewritten(program, [*kept, group])
        if trial is not None and weight(trial) <= weight(best):
            kept, best = [*kept, group], trial
    return best


def _groups(program: Program) -> list[_Group]:
    """Every law and pair of angles that some sum offers, in order of appearance."""
    view = from_program(program)
    found: dict[_Group, None] = {}
    for _, element in _sums(view):
        for group, _, _ in _matches(view.graph, element, None):
            found[group] = None
    return list(found)


def _rewritten(program: Program, groups: Collection[_Group]) -> Program | None:
    """The program after the rewrites; None where its new sines and cosines cost more than the terms could save."""
    view = from_program(program)
    graph = view.graph
    waves, saved = _live_waves(view), 0
    for node, element in _sums(view):
        constant, terms = element.constant, dict(enumerate(element.terms))
        origin = graph.origins[node]
        added: list[Term] = []
        for group, first, second in _matches(graph, element, groups):
            new = _combined(graph, group, first, second, origin)
            saved += 2 * (len(first.rest) + 3)  # the operations of both terms, and their sum
            for half in (first, second):
                if half.place < 0:
                    constant = 0.0
                else:
                    del terms[half.place]
            added.append(graph.single_term(new) or (1.0, new))
        if added:
            replacement = graph.sum(constant, [*terms.values(), *added], origin)
            if replacement != node:
                graph.replace(node, Sum(0.0, ((1.0, replacement),)))
    if _WAVE * (_live_waves(view) - waves) > saved:
        return None
    return to_program(view)


def _live_waves(view: PolynomialProgram) -> int:
    uses, elements = view.graph.uses(view.outputs), view.graph.elements
    return sum(isinstance(e, Call) and e.op in _WAVES for e, times in zip(elements, uses, strict=True) if times)


def _sums(view: PolynomialProgram) -> Iterator[tuple[int, Sum]]:
    uses = view.graph.uses(view.outputs)
    for node, element in enumerate(view.graph.elements[: len(uses)]):
        if uses[node] and isinstance(element, Sum):
            yield node, element


def _matches(
    graph: Polynomials, element: Sum, groups: Collection[_Group] | None
) -> Iterator[tuple[_Group, _Half, _Half]]:
    """Pairs of terms of one sum that a law combines, no term twice; limited to ``groups`` if given."""
    terms = list(_monomials(graph, element))
    pairs = {place: list(_waves(graph, factors)) for place, _, factors in terms if len(factors) > 1}
    if not any(pairs.values()):
        return
    used: set[int] = set()
    waiting: dict[_Key, list[_Half]] = {}
    for place, coefficient, _ in terms:
        for group, rest, form in pairs.get(place, ()):
            if groups is not None and group not in groups:
                continue
            half = _Half(place, coefficient, rest, form)
            candidates = waiting.setdefault((group, abs(coefficient), rest), [])
            partner = next((c for c in candidates if c.place not in used and c.form != form), None)
            if partner is not None:
                used.update((partner.place, place))
                yield group, partner, half
                break
            candidates.append(half)

    bare = {(coefficient, factors): place for place, coefficient, factors in terms if place not in used}
    for place, coefficient, _ in terms:
        for (_, a, b), rest, form in pairs.get(place, ()):
            group = ("square", a, b)
            partner_place = bare.get((-coefficient, rest))
            free = partner_place is not None and not {place, partner_place} & used
            if a == b and form in ("cc", "ss") and free and (groups is None or group in groups):
                assert partner_place is not None
                used.update((partner_place, place))
                yield group, _Half(partner_place, -coefficient, rest, "1"), _Half(place, coefficient, rest, form)
                break


def _monomials(graph: Polynomials, element: Sum) -> Iterator[tuple[int, float, tuple[int, ...]]]:
    """(place, coefficient, factors) of each term; the constant has place -1 and no factors."""
    if element.constant != 0.0:
        yield -1, element.constant, ()
    for place, (coefficient, node) in enumerate(element.terms):
        inner = graph.elements[node]
        yield place, coefficient, inner.factors if isinstance(inner, Product) else (node,)


def _waves(graph: Polynomials, factors: tuple[int, ...]) -> Iterator[tuple[_Group, tuple[int, ...], str]]:
    """Each pair of sines and cosines in a product: the law it belongs to, the other factors, its form."""
    elements = graph.elements
    calls = [(place, call) for place, factor in enumerate(factors) if isinstance(call := elements[factor], Call)]
    if len(calls) < 2:
        return
    waves = [(place, call) for place, call in calls if call.op in _WAVES]
    for i, (place, first) in enumerate(waves):
        for other, second in waves[i + 1 :]:
            (a, x), (b, y) = sorted(((first.args[0], first.op), (second.args[0], second.op)))
            rest = factors[:place] + factors[place + 1 : other] + factors[other + 1 :]
            yield ("cos" if x is y else "sin", a, b), rest, x[0] + y[0]


def _combined(graph: Polynomials, group: _Group, first: _Half, second: _Half, origin: str) -> int:
    """The node that the two terms add up to."""
    kind, a, b = group
    lead = first if first.form in ("cc", "sc", "1") else second  # its sign is that of the result
    same = (first.coefficient > 0.0) == (second.coefficient > 0.0)
    if kind == "square":
        squared = second if lead is first else first
        wave = graph.add(Call(Op.COS if squared.form == "ss" else Op.SIN, (a,)), origin)
        return graph.product(lead.coefficient, (*lead.rest, wave, wave), origin)
    if kind == "cos" and same and a == b:
        return graph.product(lead.coefficient, lead.rest, origin)
    turn = same == (kind == "sin")  # cos a cos b - sin a sin b and sin a cos b + cos a sin b belong to a + b
    angle = graph.sum(0.0, [(1.0, a), (1.0 if turn else -1.0, b)], origin)
    wave = graph.add(Call(Op.COS if kind == "cos" else Op.SIN, (angle,)), origin)
    return graph.product(lead.coefficient, (*lead.rest, wave), origin)
