"""Recordings: good ones are read into SI units, and every bad one is refused with its code and place."""

from __future__ import annotations

import gzip
import hashlib
import math
import time as clock
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from symdyn.base.errors import InputError
from symdyn.numeric.recording import Recording, read_recording
from symdyn.numeric.tables import table_readers, text_file
from symdyn.spec.records import Channel, ChannelMap, Quantity, Side

DEG = math.pi / 180


def channel(column: str, quantity: Quantity, unit: str, factor: float = 1.0, **more: object) -> Channel:
    settings = {"joint": "arm", "side": Side.LINK, **more}
    return Channel(column, quantity, unit=unit, factor=factor, **settings)  # type: ignore[arg-type]


Q = channel("q", Quantity.POSITION, "rad")
V = channel("v", Quantity.VELOCITY, "rad/s")
U = channel("u", Quantity.VOLTAGE, "V")


def channel_map(*channels: Channel, time_factor: float = 1.0) -> ChannelMap:
    return ChannelMap("t", time_factor, channels or (Q, U))


def motion(count: int = 500, step: float = 1e-3) -> dict[str, np.ndarray]:
    t = step * np.arange(count)
    return {"t": t, "q": np.sin(3 * t) + 0.1, "v": 3 * np.cos(3 * t), "u": np.cos(5 * t)}


def text(columns: dict[str, np.ndarray]) -> str:
    rows = [",".join(columns)]
    rows += [",".join(f"{value:.9g}" for value in row) for row in zip(*columns.values(), strict=True)]
    return "\n".join(rows) + "\n"


def good() -> str:
    return text(motion())


def with_line(number: int, line: str) -> str:
    """The good table with one of its lines (1-based) replaced."""
    lines = good().splitlines()
    lines[number - 1] = line
    return "\n".join(lines) + "\n"


def without_lines(start: int, stop: int, source: str) -> str:
    lines = source.splitlines()
    return "\n".join(lines[: start - 1] + lines[stop - 1 :]) + "\n"


def swapped(first: int, second: int) -> str:
    lines = good().splitlines()
    lines[first - 1], lines[second - 1] = lines[second - 1], lines[first - 1]
    return "\n".join(lines) + "\n"


def scaled(**factors: float) -> str:
    return text({name: values * factors.get(name, 1.0) for name, values in motion().items()})


def read(path: Path, content: str | bytes, *channels: Channel, time_factor: float = 1.0) -> Recording:
    data = content.encode() if isinstance(content, str) else content
    path.write_bytes(data)
    return read_recording(path, channel_map(*channels, time_factor=time_factor))


def with_gaps(gap: float, every: int) -> str:
    return text({**motion(), "t": motion()["t"] + gap * (np.arange(500) // every)})


def decimal_commas() -> str:
    return good().replace(",", ";").replace(".", ",")


# content, code, line of the first problem, 1-based column, a piece of what is told
BAD: dict[str, tuple[Callable[[], str | bytes], str, int | None, int | None, str]] = {
    "unsorted": (lambda: swapped(100, 300), "SD501", 101, 1, "sort the rows"),
    "clock set anew": (lambda: good() + without_lines(1, 2, good()), "SD501", 502, 1, "cut the file"),
    "duplicate": (lambda: with_line(50, good().splitlines()[48]), "SD502", 50, 1, "1 row repeats"),
    "few digits of time": (lambda: text({**motion(), "t": np.floor(np.arange(500) / 2)}), "SD502", 3, 1, "more digits"),
    "most of the time lost": (lambda: with_gaps(1.0, 300), "SD503", 302, 1, "67 % of the time span is lost"),
    "gaps everywhere": (lambda: with_gaps(7e-3, 100), "SD503", 102, 1, "has 100 samples, 200 are needed"),
    "nan": (lambda: with_line(7, "0.005,nan,1,1"), "SD504", 7, 2, "'nan'"),
    "infinite": (lambda: with_line(8, "0.006,1,1,-inf"), "SD504", 8, 4, "'-inf'"),
    "beyond float": (lambda: with_line(8, "0.006,1e400,1,1"), "SD504", 8, 2, "'1e400'"),
    "text": (lambda: with_line(9, "0.007,1,1,off"), "SD504", 9, 4, "1 of 500 rows (0.2 %)"),
    "python underscore": (lambda: with_line(9, "0.007,1_0,1,1"), "SD504", 9, 2, "'1_0'"),
    "empty cell": (lambda: with_line(9, "0.007,,1,1"), "SD504", 9, 2, "an empty cell"),
    "truth values": (lambda: "t,q,u\n" + "".join(f"{n},1,True\n" for n in range(300)), "SD504", 2, 3, "and 290 more"),
    "decimal commas": (decimal_commas, "SD505", 1, None, "';' and numbers have decimal commas"),
    "semicolons": (lambda: good().replace(",", ";"), "SD505", 1, None, "separated by ';'"),
    "tabs": (lambda: good().replace(",", "\t"), "SD505", 1, None, "separated by a tab"),
    "comma for both": (lambda: with_line(3, "0,001,0,1,1,0,1,0"), "SD505", 3, None, "decimal commas?"),
    "row too long": (lambda: with_line(12, "0.01,1,1,1,1"), "SD505", 12, None, "5 fields where the header has 4"),
    "row cut off": (lambda: good() + "0.5,0.1\n", "SD505", 502, None, "2 fields where the header has 4"),
    "long and short": (lambda: with_line(12, "0.01,1,1,1,1") + "0.5,1,1\n", "SD505", 12, None, "5 fields"),
    "header only": (lambda: "t,q,u\n", "SD505", 2, None, "no rows"),
    "no header": (lambda: without_lines(1, 2, good()), "SD505", 1, None, "columns' names"),
    "empty": (lambda: "", "SD505", None, None, "empty"),
    "blank": (lambda: "\n \n", "SD505", None, None, "empty"),
    "utf-16": (lambda: good().encode("utf-16"), "SD505", None, None, "UTF-16"),
    "latin-1": (lambda: good().encode() + b"\xb0\n", "SD505", 502, None, "0xb0"),
    "binary": (lambda: good().encode() + b"\0\n", "SD505", 502, None, "NUL"),
    "quote only": (lambda: '"', "SD510", 1, None, "no column 't'"),
    "one name twice": (lambda: good().replace("v", "q", 1), "SD505", 1, 3, "2 columns are named 'q'"),
    "break in quotes": (lambda: good().replace("v", '"v\n"', 1), "SD505", None, None, "several lines"),
    "open quote": (lambda: with_line(20, '0.018,1,1,"1'), "SD504", 20, 4, "no finite number"),
    "column missing": (lambda: good().replace("q", "Q_", 1), "SD510", 1, None, "mean 'Q_'? columns there: t, Q_, v, u"),
    "nanoseconds": (lambda: scaled(t=1e9), "SD506", 2, 1, 'unit = "ms", "us" or "ns"'),
    "too short": (lambda: without_lines(201, 502, good()), "SD508", 200, 1, "199 samples"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_bad_table_is_refused_with_code_and_place(case: str, tmp_path: Path) -> None:
    content, code, line, column, told = BAD[case]
    path = tmp_path / "run.csv"
    with pytest.raises(InputError) as caught:
        read(path, content())
    first = caught.value.problems[0]
    assert first.where is not None
    assert (first.code, first.where.file, first.where.line, first.where.column) == (code, str(path), line, column)
    assert told in str(caught.value)


def test_the_table_of_bad_files_starts_from_a_good_one(tmp_path: Path) -> None:
    recording = read(tmp_path / "run.csv", good())
    assert recording.warnings == ()
    assert recording.segments == (slice(0, 500),)


def test_all_problems_are_told_at_once(tmp_path: Path) -> None:
    lines = good().splitlines()
    lines[4], lines[8], lines[20] = "0.003,x,1,1", "0.007,1,1", "0.019,1,1,"
    with pytest.raises(InputError) as caught:
        read(tmp_path / "run.csv", "\n".join(lines))
    found = [(p.code, p.where.line, p.where.column) for p in caught.value.problems if p.where]
    assert found == [("SD505", 9, None), ("SD504", 5, 2), ("SD504", 21, 4)]


def test_unsorted_and_duplicate_times_are_told_together(tmp_path: Path) -> None:
    t = motion()["t"].copy()
    t[50], t[200] = t[49], t[100]
    with pytest.raises(InputError) as caught:
        read(tmp_path / "run.csv", text({**motion(), "t": t}))
    assert [(p.code, p.where.line) for p in caught.value.problems if p.where] == [("SD501", 202), ("SD502", 52)]


def test_every_missing_column_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path / "run.csv", good(), channel("a", Quantity.POSITION, "rad"), channel("b", Quantity.EFFORT, "N m"))
    assert [p.message for p in caught.value.problems] == ["no column 'a'", "no column 'b'"]


def test_many_bad_cells_are_counted_not_all_listed(tmp_path: Path) -> None:
    u = motion()["u"].copy()
    u[100:200] = np.nan
    with pytest.raises(InputError) as caught:
        read(tmp_path / "run.csv", text({**motion(), "u": u}))
    assert len(caught.value.problems) == 10
    assert "and 90 more cells; 100 of 500 rows (20 %)" in caught.value.problems[-1].hint


@pytest.mark.parametrize(
    ("name", "content", "code"),
    [
        ("run.csv.gz", good().encode(), "SD505"),
        ("run.csv.gz", gzip.compress(good().encode(), mtime=0)[:-200], "SD505"),
        ("run.csv.gz", gzip.compress(good().encode(), mtime=0)[:40] + b"\xff" * 40, "SD505"),
        ("run.csv.gz", b"", "SD505"),
        ("run.mat", b"MATLAB 5.0", "SD523"),
    ],
    ids=["not packed", "cut off", "damaged", "empty", "another format"],
)
def test_bad_file_is_refused(name: str, content: bytes, code: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path / name, content)
    assert [p.code for p in caught.value.problems] == [code]


def test_missing_file_and_folder_are_refused(tmp_path: Path) -> None:
    (tmp_path / "folder.csv").mkdir()
    for name in ("nothing.csv", "folder.csv"):
        with pytest.raises(InputError, match=r"SD513: cannot read the file"):
            read_recording(tmp_path / name, channel_map())


@pytest.mark.parametrize("name", ["run.csv", "run.csv.gz"])
def test_too_big_a_file_is_refused(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(text_file, "MAX_BYTES", 10_000)
    content = good().encode()
    with pytest.raises(InputError, match=r"SD522: the recording is too big"):
        read(tmp_path / name, gzip.compress(content, mtime=0) if name.endswith(".gz") else content)


def test_values_are_in_si_units_with_sign_and_scale(tmp_path: Path) -> None:
    columns = motion()
    scaled_columns = {"t": 1e3 * columns["t"], "q": columns["q"] / DEG, "i": columns["u"]}
    recording = read(
        tmp_path / "run.csv",
        text(scaled_columns),
        channel("q", Quantity.POSITION, "deg", DEG, side=Side.MOTOR),
        channel("i", Quantity.CURRENT, "mA", 1e-3, scale=2.0, sign=-1),
        time_factor=1e-3,
    )
    np.testing.assert_allclose(recording.time, columns["t"], rtol=1e-8)
    np.testing.assert_allclose(recording.channel(Quantity.POSITION, "arm"), columns["q"], rtol=1e-7)
    np.testing.assert_allclose(recording.channel(Quantity.CURRENT, "arm", Side.LINK), -2e-3 * columns["u"], rtol=1e-7)
    assert recording.sample_time == pytest.approx(1e-3)
    assert recording.name == "run"


def test_digest_is_that_of_the_file_and_arrays_cannot_be_written(tmp_path: Path) -> None:
    path = tmp_path / "run.csv.gz"
    recording = read(path, gzip.compress(good().encode(), mtime=0))
    assert recording.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert recording.name == "run"
    for values in (recording.time, *recording.channels.values()):
        with pytest.raises(ValueError, match="read-only"):
            values[0] = 0.0


@pytest.mark.parametrize(
    "change",
    [
        lambda s: b"\xef\xbb\xbf" + s.encode(),
        lambda s: s.replace("\n", "\r\n").encode(),
        lambda s: s.replace("t,q,v,u", ' t , "q",v,u').encode(),
        lambda s: ("\n" + s + "\n\n").encode(),
        lambda s: s.replace("\n", "\n\n", 40).encode(),
        lambda s: s.rstrip("\n").encode(),
        lambda s: s.replace("\n", ",any text\n").encode(),
    ],
    ids=["bom", "crlf", "quotes and spaces", "blank ends", "blank lines", "no last newline", "text column"],
)
def test_harmless_differences_do_not_matter(change: Callable[[str], bytes], tmp_path: Path) -> None:
    recording = read(tmp_path / "run.csv", change(good()))
    written = [float(f"{value:.9g}") for value in motion()["q"]]
    np.testing.assert_array_equal(recording.channel(Quantity.POSITION, "arm"), written)


def test_blank_lines_do_not_shift_the_line_told(tmp_path: Path) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path / "run.csv", good().replace("\n", "\n\n", 30).replace("\n0.1,", "\n0.1,x"))
    assert caught.value.problems[0].where is not None
    assert caught.value.problems[0].where.line == 132


def test_gaps_split_the_recording_with_a_warning_each(tmp_path: Path) -> None:
    t = motion()["t"] + 0.006 * (np.arange(500) >= 100) + 0.004 * (np.arange(500) >= 150)
    recording = read(tmp_path / "run.csv", text({**motion(), "t": t}))
    assert recording.segments == (slice(0, 100), slice(100, 500))  # the second step is 5 times the median: no gap
    assert [(w.code, w.where.line) for w in recording.warnings if w.where] == [("SD503", 102)]


@pytest.mark.parametrize(
    ("content", "channels", "code", "told"),
    [
        (lambda: scaled(t=1e3), (Q, U), "SD506", 'unit = "ms"'),
        (lambda: scaled(t=1e-3), (Q, U), "SD506", 'unit = "s"'),
        (lambda: scaled(q=1 / DEG), (Q, U), "SD506", 'unit = "deg"'),
        (lambda: scaled(u=0.0), (Q, U), "SD508", "'u' is constant (0)"),
        (lambda: text({**motion(), "v": np.cos(977 * np.arange(500.0))}), (Q, V), "SD507", "correlation is"),
    ],
    ids=["time in ms", "time in s taken for ms", "degrees", "constant", "unrelated velocity"],
)
def test_suspicions_are_warnings(
    content: Callable[[], str], channels: Sequence[Channel], code: str, told: str, tmp_path: Path
) -> None:
    recording = read(tmp_path / "run.csv", content(), *channels)
    assert [warning.code for warning in recording.warnings] == [code]
    assert told in str(recording.warnings[0])


@pytest.mark.parametrize(
    ("factors", "ratio", "told"),
    [
        ({"v": -1.0}, "-1", "for 'v' write sign = -1;"),
        ({"v": 1 / DEG}, "0.01745", "the velocity is in deg/s"),
        ({"q": 1 / DEG}, "57.3", "the position is in degrees"),
        ({"q": -1e3}, "-1000", "for 'v' write sign = -1 and scale = 1000"),
        ({"t": 1e3}, "0.001", "the time is in ms"),
        ({"v": 30 / math.pi}, "0.1047", "rev/min"),
        ({"v": 1 / 3}, "3", "for 'v' write scale = 3;"),
    ],
)
def test_velocity_that_is_no_derivative_is_refused(
    factors: dict[str, float], ratio: str, told: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as caught:
        read(tmp_path / "run.csv", scaled(**factors), Q, V)
    (problem,) = caught.value.problems
    assert (problem.code, problem.where and (problem.where.line, problem.where.column)) == ("SD507", (1, 3))
    assert f"is {ratio} times the velocity" in problem.message
    assert told in str(problem)


@pytest.mark.slow
@given(scale=st.floats(1e-3, 1e3), sign=st.sampled_from([1, -1]), already=st.floats(0.1, 10.0))
@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)
def test_the_advice_on_a_velocity_cures_it(tmp_path: Path, scale: float, sign: int, already: float) -> None:
    content = scaled(v=sign / scale)
    path = tmp_path / "run.csv"
    try:
        read(path, content, Q, channel("v", Quantity.VELOCITY, "rad/s", scale=already))
    except InputError as error:
        words = error.problems[0].hint.partition(";")[0].split()
        new_scale = float(words[words.index("scale") + 2]) if "scale" in words else already
        new_sign = int(words[words.index("sign") + 2]) if "sign" in words else 1
        read(path, content, Q, channel("v", Quantity.VELOCITY, "rad/s", scale=new_scale, sign=new_sign))
    else:
        assert sign == 1
        assert 0.79 < scale / already < 1.26


def test_velocity_is_held_against_its_own_side_and_within_segments(tmp_path: Path) -> None:
    columns = motion()
    jump = np.where(np.arange(500) < 250, 0.0, 5.0)
    t = columns["t"] + 0.006 * (np.arange(500) >= 250)
    content = text({**columns, "t": t, "q": columns["q"] + jump, "w": 100 * columns["v"]})
    recording = read(tmp_path / "run.csv", content, Q, V, channel("w", Quantity.VELOCITY, "rad/s", side=Side.MOTOR))
    assert [warning.code for warning in recording.warnings] == ["SD503"]


def test_two_columns_for_one_quantity_are_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"SD511: columns 'q' and 'v' both claim the position of 'arm'"):
        read(tmp_path / "run.csv", good(), Q, channel("v", Quantity.POSITION, "rad"))


def test_channel_is_found_by_side_and_a_missing_one_is_told(tmp_path: Path) -> None:
    motor = channel("v", Quantity.POSITION, "rad", side=Side.MOTOR)
    recording = read(tmp_path / "run.csv", good(), motor, Q)
    assert recording.channel(Quantity.POSITION, "arm")[0] == pytest.approx(0.1)
    assert recording.channel(Quantity.POSITION, "arm", Side.MOTOR)[0] == pytest.approx(3.0)
    assert recording.has(Quantity.POSITION, "arm", Side.MOTOR)
    assert not recording.has(Quantity.EFFORT, "arm")
    with pytest.raises(InputError, match=r"SD510: recording 'run' has no effort of 'arm'\n.*position of arm \(motor\)"):
        recording.channel(Quantity.EFFORT, "arm")


def test_readers_are_found_by_suffix() -> None:
    assert list(table_readers()) == [".csv.gz", ".csv"]


def test_a_long_recording_is_read_fast(tmp_path: Path) -> None:
    path = tmp_path / "run.csv"
    read(path, text(motion(25_000)), Q, V, U)
    ours, numpys = [], []
    for _ in range(3):
        start = clock.perf_counter()
        read_recording(path, channel_map(Q, V, U))
        ours.append(clock.perf_counter() - start)
        start = clock.perf_counter()
        np.genfromtxt(path, delimiter=",", skip_header=1)
        numpys.append(clock.perf_counter() - start)
    assert min(ours) < 3.0 * min(numpys)  # with all checks of what was recorded


@given(st.binary(max_size=400))
@settings(
    max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow]
)
def test_only_input_errors_escape(tmp_path: Path, junk: bytes) -> None:
    for name, content in (("a.csv", junk), ("b.csv", b"t,q,u\n0,1,2\n" + junk), ("c.csv.gz", junk)):
        with pytest.raises(InputError):
            read(tmp_path / name, content)
