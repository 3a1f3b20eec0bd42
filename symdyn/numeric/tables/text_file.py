"""The bytes of a text file, plain or gzipped, checked to be UTF-8 and of a sane size."""

from __future__ import annotations

import gzip
import hashlib
import io
import zlib
from pathlib import Path

from symdyn.base.errors import InputError, Problem, Where

MAX_BYTES = 2 << 30

_UTF8_MARK = b"\xef\xbb\xbf"
_UTF16_MARKS = (b"\xff\xfe", b"\xfe\xff")


def load_text(path: Path) -> tuple[bytes, str]:
    """The text, unpacked and without a byte order mark, and the SHA-256 of the file as it lies.

    Raises InputError: SD513 for what cannot be read, SD505 for what is no text, SD522 beyond 2 GiB.
    """
    try:
        size = path.stat().st_size
        if size > MAX_BYTES:
            raise _too_big(path, f"{size / 2**30:.1f} GiB")
        packed = path.read_bytes()
    except OSError as error:
        hint = "check the path, relative to the folder that the command runs in"
        raise failure(path, "SD513", f"cannot read the file: {error.strerror}", hint=hint) from error
    data = _unpack(path, packed) if path.name.lower().endswith(".gz") else packed
    if data.startswith(_UTF16_MARKS):
        raise failure(path, "SD505", "the file is UTF-16", hint="save it as UTF-8")
    data = data.removeprefix(_UTF8_MARK)
    if not data.strip():
        raise failure(path, "SD505", "the file is empty")
    if b"\0" in data:
        line = data.count(b"\n", 0, data.index(b"\0")) + 1
        raise failure(path, "SD505", "the file holds NUL bytes: it is no text", line)
    try:
        data.decode("utf-8")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        message = f"byte 0x{data[error.start]:02x} is no UTF-8"
        raise failure(path, "SD505", message, line, "save the file as UTF-8") from error
    return data, hashlib.sha256(packed).hexdigest()


def failure(path: Path, code: str, message: str, line: int | None = None, hint: str = "") -> InputError:
    """The error of one problem in the file."""
    return InputError(Problem(code, message, Where(str(path), line), hint))


def _unpack(path: Path, packed: bytes) -> bytes:
    if not packed:
        raise failure(path, "SD505", "the file is empty")
    try:
        with gzip.GzipFile(fileobj=io.BytesIO(packed)) as stream:
            data = stream.read(MAX_BYTES + 1)
    except gzip.BadGzipFile as error:
        hint = "a plain table must end in .csv" if packed[:2] != b"\x1f\x8b" else "copy it again"
        raise failure(path, "SD505", f"named .gz but no sound gzip file: {error}", hint=hint) from error
    except (EOFError, zlib.error) as error:
        raise failure(path, "SD505", f"the gzip file is cut off or damaged: {error}", hint="copy it again") from error
    if len(data) > MAX_BYTES:
        raise _too_big(path, "more than 2 GiB when unpacked")
    return data


def _too_big(path: Path, size: str) -> InputError:
    hint = "cut it into shorter files, or keep every n-th row; 2 GiB is the limit"
    return failure(path, "SD522", f"the recording is too big: {size}", hint=hint)
