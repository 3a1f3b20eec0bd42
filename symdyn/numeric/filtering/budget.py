"""How much a search has filtered, and how much it may: counted, not timed, so that no answer depends on the machine."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

ENOUGH = 2e11  # multiplications: some minutes on two cores


class Budget:
    """Multiplications that filters may take before a search asks nothing more; what it did not ask, then."""

    def __init__(self, enough: float) -> None:
        self.enough = enough
        self.spent = 0.0
        self.not_asked: tuple[str, ...] = ()
        self._lock = threading.Lock()

    def spend(self, multiplications: float) -> None:
        with self._lock:
            self.spent += multiplications

    def allows(self, question: str) -> bool:
        """Whether something more may be asked: to be called where no filter runs, for the same answer every time."""
        if self.spent < self.enough:
            return True
        self.not_asked = tuple(dict.fromkeys((*self.not_asked, question)))
        return False


_now: ContextVar[Budget | None] = ContextVar("budget", default=None)


@contextmanager
def within(budget: Budget) -> Iterator[Budget]:
    """Filters that run here, and side by side from here, spend from ``budget``."""
    before = _now.set(budget)
    try:
        yield budget
    finally:
        _now.reset(before)


def allowed(question: str) -> bool:
    """``Budget.allows``; everything is, where there is none."""
    budget = _now.get()
    return budget is None or budget.allows(question)


def spend(multiplications: float) -> None:
    """To be told by what filters."""
    budget = _now.get()
    if budget is not None:
        budget.spend(multiplications)
