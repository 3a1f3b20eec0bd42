"""Readers of tables by file suffix: a new format is one new module here, found by itself.

A reader module has ``SUFFIXES`` (``(".csv", ".csv.gz")``) and ``read_table(path, columns) -> RawTable``.
"""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from pathlib import Path
from types import MappingProxyType

from symdyn.base.errors import InputError, Problem, Where
from symdyn.numeric.tables.raw_table import RawTable

TableReader = Callable[[Path, Sequence[str]], RawTable]


@cache
def table_readers() -> Mapping[str, TableReader]:
    """Suffix (lower case, longest first) to reader, over every module of this package that declares any."""
    found: dict[str, TableReader] = {}
    for info in pkgutil.iter_modules(__path__):
        module = importlib.import_module(f"{__name__}.{info.name}")
        for suffix in getattr(module, "SUFFIXES", ()):
            found[suffix] = module.read_table
    return MappingProxyType(dict(sorted(found.items(), key=lambda item: (-len(item[0]), item[0]))))


def read_table(path: Path, columns: Sequence[str]) -> RawTable:
    """The named columns of the file, by the reader of its suffix.

    Raises InputError: SD523 for an unknown suffix, else what the reader finds.
    """
    for suffix, reader in table_readers().items():
        if path.name.lower().endswith(suffix):
            return reader(path, columns)
    known = ", ".join(sorted(table_readers()))
    message = f"no reader for a recording named '{path.name}'"
    raise InputError(Problem("SD523", message, Where(str(path)), f"formats that can be read: {known}"))
