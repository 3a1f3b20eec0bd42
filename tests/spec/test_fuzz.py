"""Whatever a file holds, a reader gives a robot or an InputError: nothing else escapes, nothing is run."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.base.errors import InputError, Problem
from symdyn.spec.effect_schema import EffectSchema
from symdyn.spec.toml_reader import read_robot_text

Catalogue = Mapping[str, EffectSchema]

SCALARS = st.one_of(
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    st.sampled_from(["q", "q + 1 m", "m_2", "-1/2 l_2", "3 kg", "0 N m", "m_2^-9", "1e300 m", "joint", "elbow", "1"]),
)
VALUES = st.recursive(
    SCALARS, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=4), inner, max_size=3)
)


def toml_of(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return '"' + "".join(f"\\U{ord(c):08X}" for c in value if not 0xD800 <= ord(c) < 0xE000) + '"'
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_of, value)) + "]"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml_of(key)} = {toml_of(inner)}" for key, inner in value.items()) + "}"
    return str(value)


def read(text: str, catalogue: Catalogue) -> None:
    problems: tuple[Problem, ...] = ()
    try:
        assert read_robot_text(text, "f", catalogue).text == text
    except InputError as error:
        problems = error.problems or (Problem("", ""),)
    assert all(problem.code.startswith("SD") and problem.message for problem in problems)


@settings(deadline=None)
@given(st.text(max_size=200))
def test_random_text(catalogue: Catalogue, text: str) -> None:
    read(text, catalogue)


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_random_edits_of_a_valid_file(catalogue: Catalogue, valid: str, data: st.DataObject) -> None:
    start = data.draw(st.integers(0, len(valid)))
    length = data.draw(st.integers(0, 12))
    piece = data.draw(
        st.text(max_size=6) | st.sampled_from(["[", "{", '"', "= 1,5", "nan", "'''", "\n[x]\n", "[[joint]]"])
    )
    read(valid[:start] + piece + valid[start + length :], catalogue)


@settings(max_examples=250, deadline=None)
@given(st.data())
def test_random_values_in_a_valid_file(catalogue: Catalogue, valid: str, data: st.DataObject) -> None:
    lines = valid.splitlines()
    for _ in range(data.draw(st.integers(1, 2))):
        candidates = [i for i, line in enumerate(lines) if " = " in line and not line.lstrip().startswith("[")]
        i = data.draw(st.sampled_from(candidates))
        parts = lines[i].split(" = ")
        at = data.draw(st.integers(1, len(parts) - 1))
        tail = parts[at][len(parts[at].split(",")[0].split(" }")[0]) :] if at < len(parts) else ""
        parts[at] = toml_of(data.draw(VALUES)) + tail
        lines[i] = " = ".join(parts)
    read("\n".join(lines), catalogue)


@settings(deadline=None)
@given(st.dictionaries(st.sampled_from(["robot", "dh", "joint", "effect", "parameters", "recording"]), VALUES))
def test_random_tables(catalogue: Catalogue, tables: dict[str, object]) -> None:
    read("\n".join(f"{name} = {toml_of(value)}" for name, value in tables.items()), catalogue)


@pytest.mark.parametrize("name", ["é" * 3, "\x1b[31m", "a\u2028b", "ﬁ", "µ", "\u202e"])
def test_messages_are_printable(catalogue: Catalogue, valid: str, name: str) -> None:
    with pytest.raises(InputError) as caught:
        read_robot_text(valid.replace('name = "shoulder"', f"name = {toml_of(name)}"), "f", catalogue)
    assert all(c.isprintable() or c == "\n" for c in str(caught.value))
