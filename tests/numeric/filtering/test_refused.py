"""A hypothesis far likelier than the best one, and refused by free runs: fitted anew before play is asked for."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import pytest

from symdyn.numeric.filtering import refused as module
from symdyn.numeric.filtering.refused import fitted_anew, reconsidered


@dataclass(frozen=True, eq=False)
class Tried:
    """A step as far as is looked at here; free runs of what is fitted are ``off`` by so much."""

    worth: float
    after: Any
    gain: float = 0.0
    p_value: float = 0.0

    @property
    def score(self) -> Any:
        return SimpleNamespace(candidate=SimpleNamespace(label="a law"))


def explanation(off: float) -> Any:
    return SimpleNamespace(off=off, fit=SimpleNamespace(loss=off))


MODEL: Any = None
CURRENT = explanation(1.0)


class Search:
    """What a fit from the model as given leaves, how often one was asked for, and of what a second effect was."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, anew: Any) -> None:
        self.fits, self.beside = 0, []

        def relieved(*_: Any) -> Any:
            self.fits += 1
            return anew

        def both(model: Any, current: Any, tried: tuple[Any, ...], progress: Any) -> None:
            self.beside += [each.after for each in tried]

        for name, function in {
            "relieved": relieved,
            "both": both,
            "worth": lambda model, step: step.worth,
            "_sure": lambda *_: True,
            "heldout_p_value": lambda *_: 0.0,
            "earns": lambda *_: True,
            "improves": lambda before, after: after.off < 0.98 * before.off,
        }.items():
            monkeypatch.setattr(module, name, function)


def asked(best: Any, likeliest: Any) -> tuple[Any, Any]:
    """What is best once it was fitted anew, and after what is asked then."""
    now, tried, again = fitted_anew(MODEL, CURRENT, best, (best, likeliest), print)
    return now, reconsidered(MODEL, CURRENT, now, tried, again, print)[0]


def test_it_is_best_where_it_was_refused_for_a_fit_that_went_astray(monkeypatch: pytest.MonkeyPatch) -> None:
    search = Search(monkeypatch, explanation(0.1))
    first, last = asked(Tried(10.0, explanation(0.5)), Tried(100.0, explanation(0.9)))
    assert first is last
    assert (first.worth, first.after.off) == (100.0, 0.1)
    assert (search.fits, search.beside) == (1, [])


@pytest.mark.parametrize("anew", [None, explanation(0.7)])
def test_it_is_fitted_anew_once_and_asked_with_another_one(monkeypatch: pytest.MonkeyPatch, anew: Any) -> None:
    search, best, likeliest = Search(monkeypatch, anew), Tried(10.0, explanation(0.5)), Tried(100.0, explanation(0.9))
    assert asked(best, likeliest) == (best, best)
    assert (search.fits, search.beside) == (1, [anew or likeliest.after])


def test_what_is_about_as_likely_is_not_asked_again(monkeypatch: pytest.MonkeyPatch) -> None:
    search, best = Search(monkeypatch, explanation(0.1)), Tried(99.0, explanation(0.5))
    assert asked(best, Tried(100.0, explanation(0.9))) == (best, best)
    assert (search.fits, search.beside) == (0, [])


def test_a_play_that_was_likelier_than_either_is_fitted_anew_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    search, best, likeliest = Search(monkeypatch, None), Tried(10.0, explanation(0.5)), Tried(100.0, explanation(0.9))
    now, tried, again = fitted_anew(MODEL, CURRENT, best, (best, likeliest), print)
    play = Tried(1000.0, explanation(0.8))
    reconsidered(MODEL, CURRENT, now, (*tried, play), again, print)
    assert (search.fits, search.beside) == (2, [play.after])
