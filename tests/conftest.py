"""Compiled kernels of the tests: one folder for all workers of a run, kept from run to run."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

# Machines are small and busy: how long an example takes says nothing here.
_BUSY = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
# A change is judged by the same examples every time; `make test-random` looks for new ones.
settings.register_profile("repeatable", _BUSY, derandomize=True, database=None)
settings.register_profile("random", _BUSY)
settings.load_profile("repeatable")

# Each worker begins with a part of its own, and Numba takes a minute for the event-exact integrator: tests that need it
# in the parts of two workers compile it twice, unless the first of them come first.
_FIRST = "tests/numeric/hybrid/"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    items.sort(key=lambda item: not item.nodeid.startswith(_FIRST))


@pytest.fixture(scope="session", autouse=True)
def kernel_cache(pytestconfig: pytest.Config, tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """SYMDYN_CACHE, unless it is set already: a folder of pytest's own cache, which git ignores.

    Kernels are keyed by the content of their source, so that one of other code is never taken for one
    of this. Where pytest keeps no cache (``-p no:cacheprovider``), kernels last for the run alone.
    """
    with pytest.MonkeyPatch.context() as patch:
        if "SYMDYN_CACHE" not in os.environ:
            kept = getattr(pytestconfig, "cache", None)
            base = Path(kept.mkdir("symdyn")) if kept is not None else tmp_path_factory.getbasetemp()
            patch.setenv("SYMDYN_CACHE", str(base / "kernels"))
        yield
