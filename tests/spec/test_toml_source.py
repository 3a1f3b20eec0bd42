from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from symdyn.base.errors import InputError, Problem
from symdyn.spec.toml_positions import KeyPath, positions_of
from symdyn.spec.toml_source import LARGEST_FILE, parse, read_text

TEXT = """\
a.b.c = [1, [2, "x"]]
"q r" = { x = 1, y = { z = 2 } }
rows = [ [1, 2],
  [3, "µ", 4] ]
[[j]]
n = 1  # c
[j.d]
v = 3
[[j.k]]
z = [
 { a = 1 },
 # a comment between
 { a = 2, "µ.µ" = 3 }]
[[j]]
n = 2
[j.d]
k = 1
[e.f]
"""


def problem_of(text: str) -> Problem:
    with pytest.raises(InputError) as caught:
        parse(text, "f")
    (problem,) = caught.value.problems
    return problem


@pytest.mark.parametrize(
    ("path", "value", "key"),
    [
        (("a", "b", "c", 1, 1), (1, 17), (1, 17)),
        (("q r", "y", "z"), (2, 28), (2, 24)),
        (("rows", 1, 2), (4, 12), (4, 12)),
        (("j", 0, "n"), (6, 5), (6, 1)),
        (("j", 0, "d", "v"), (8, 5), (8, 1)),
        (("j", 0, "k", 0, "z", 1, "a"), (13, 8), (13, 4)),
        (("j", 0, "k", 0, "z", 1, "µ.µ"), (13, 19), (13, 11)),
        (("j", 1), (14, 3), (14, 3)),
        (("j", 1, "n"), (15, 5), (15, 1)),
        (("j", 1, "d", "k"), (17, 5), (17, 1)),
        (("j", 1, "not", "there"), (14, 3), (14, 3)),
        (("e", "f"), (18, 2), (18, 2)),
        (("nowhere",), (None, None), (None, None)),
    ],
)
def test_position_of_a_key_path(
    path: KeyPath, value: tuple[int | None, int | None], key: tuple[int | None, int | None]
) -> None:
    source = parse(TEXT, "f")
    here, there = source.where(path), source.where(path, key=True)
    assert ((here.line, here.column), (there.line, there.column)) == (value, key)


@pytest.mark.parametrize(
    ("text", "code", "line", "column", "told"),
    [
        ("mass = 1,5\n", "SD001", 1, 9, "decimal point"),
        ("x = 1\ny = 2\nx = 3\n", "SD001", 3, 1, "`x` is defined twice, first at f:1:1"),
        ("[a]\n[b]\n[a]\n", "SD001", 3, 2, "`a` is defined twice, first at f:1:2"),
        ("a = { b = 1, b = 2 }", "SD001", 1, 14, "`a.b` is defined twice, first at f:1:7"),
        ("a = { x = 1,\n y = 2 }", "SD001", 1, 13, "stands on one line"),
        ("ok = 1\n[robot\n", "SD001", 2, 7, "']'"),
        ("x = [1, 2", "SD001", 1, 10, "nclosed array"),
        ("x = 1\ny = " + "7" * 5000, "SD001", 2, 5, "thousands of digits"),
        ("x = " + "[" * 3000, "SD002", 1, 69, "nested deeper"),
        ("x = " + "[" * 100 + "]" * 100, "SD002", 1, 69, "nested deeper"),
        ("ok = 1\na" + ".a" * 5000 + " = 1", "SD002", 2, 1, "nested deeper"),
    ],
)
def test_what_is_no_toml(text: str, code: str, line: int, column: int, told: str) -> None:
    problem = problem_of(text)
    assert problem.where is not None
    assert (problem.code, problem.where.line, problem.where.column) == (code, line, column)
    assert told in str(problem)


def test_half_a_surrogate_pair_is_refused() -> None:
    assert problem_of("x = '\ud800'").code == "SD005"


def test_windows_line_ends_do_not_shift_positions() -> None:
    windows = parse(TEXT.replace("\n", "\r\n"), "f")
    assert windows.where(("j", 1, "n")) == parse(TEXT, "f").where(("j", 1, "n"))


def test_unreadable_files(tmp_path: Path) -> None:
    large, binary, marked = tmp_path / "large.toml", tmp_path / "binary.toml", tmp_path / "bom.toml"
    large.write_bytes(b"#" * (LARGEST_FILE + 1))
    binary.write_bytes(b"a = 1\nb = '\xc3\xa9\xff'\n")
    marked.write_bytes(b"\xef\xbb\xbfa = 1\n")
    for path, code, told in [
        (tmp_path / "missing.toml", "SD003", "does not exist"),
        (tmp_path, "SD003", "is a directory"),
        ("a\0b", "SD003", "null"),
        (large, "SD004", "1 MiB"),
        (binary, "SD005", "binary.toml:2:7"),
    ]:
        with pytest.raises(InputError) as caught:
            read_text(path)
        assert caught.value.problems[0].code == code
        assert told in str(caught.value)
    assert read_text(marked) == "a = 1\n"


@settings(deadline=None)
@given(st.text(alphabet=st.sampled_from("ab.=[]{}\"'\\\n #,1é"), max_size=60))
def test_any_text_parses_or_is_told(text: str) -> None:
    positions_of(text)
    try:
        source = parse(text, "f")
    except InputError as error:
        places = [problem.where for problem in error.problems]
    else:
        places = [source.where((key,), key=True) for key in source.data]
    assert all(place is not None and place.line for place in places)
