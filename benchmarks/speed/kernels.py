"""The generated functions of one arm in every form that is timed, and whether they agree with the others."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numba import njit

from benchmarks.speed.arms import Arm, Array
from benchmarks.speed.native import FUNCTIONS, Rival
from benchmarks.speed.targets import BATCH, LOOP, MILLION, ONCE, WHEEL
from symdyn.emit.kernel import Kernel

Run = Callable[[], object]
TOLERANCE = 1e-10
IN_CACHE, LARGE, CALLS, CHECKED = 6400, 10**6, 2000, 1000
LARGE_FUNCTIONS = ("inverse_dynamics",)


@dataclass(frozen=True)
class Contestant:
    """One thing that is timed: ``run`` computes ``states`` states of a function in a form."""

    function: str
    form: str
    who: str
    run: Run
    states: int
    threads: bool = False  # several


@dataclass(frozen=True)
class Bench:
    """One arm: its kernel, the states, and the contestants."""

    arm: Arm
    kernel: Kernel
    pin: Any

    @cached_property
    def states(self) -> tuple[Array, Array, Array]:
        return self._random(IN_CACHE)

    def _random(self, count: int) -> tuple[Array, Array, Array]:
        rng = np.random.default_rng(0)
        q, qd, third = (rng.uniform(-np.pi, np.pi, (count, self.arm.joints)) for _ in range(3))
        return q, qd, third

    def contestants(self, rivals: list[Rival]) -> Iterator[Contestant]:
        """Those whose working set fits the second or third cache."""
        q, qd, third = self.states
        for name in FUNCTIONS:
            arguments, out = self._arguments(name, self.states), self._empty(name, IN_CACHE)
            loop = compiled_loop(getattr(self.kernel, f"{name}_into"), len(arguments))
            yield Contestant(name, LOOP, "symdyn", _call(loop, *arguments, out), IN_CACHE)
            yield from self._batches(name, arguments, BATCH, IN_CACHE)
            for rival in rivals:
                work = self._empty(name, IN_CACHE)
                run = _call(rival.loops[name], q, qd, third, work)
                yield Contestant(name, LOOP, f"{rival.kind}: {rival.build}", run, IN_CACHE)
            first = tuple(a[0].copy() for a in arguments)
            into, result = getattr(self.kernel, f"{name}_into"), out[0].copy()
            yield Contestant(name, ONCE, "symdyn, _into", _times(into, *first, result), CALLS)
            packed, both = getattr(self.kernel, f"{name}_packed"), np.concatenate([*first, result.ravel()])
            yield Contestant(name, ONCE, "symdyn, _packed", _times(packed, both), CALLS)
            if self.pin is not None:
                function, model, data = self._wheel(name)
                yield Contestant(name, ONCE, WHEEL, _times(function, model, data, *first), CALLS)

    def large(self, rivals: list[Rival]) -> Iterator[Contestant]:
        """A million states, which no cache holds; rivals loop over the same."""
        states = self._random(LARGE)
        for name in LARGE_FUNCTIONS:
            yield from self._batches(name, self._arguments(name, states), MILLION, LARGE)
            out = self._empty(name, LARGE)
            for rival in rivals:
                run = _call(rival.loops[name], *states, out)
                yield Contestant(name, MILLION, f"{rival.kind}: {rival.build}", run, LARGE)

    def check(self, rivals: list[Rival]) -> None:
        """Everyone agrees with the wheel to 1e-10 of the largest entry; raises AssertionError otherwise."""
        states = tuple(a[:CHECKED].copy() for a in self.states)
        q, qd, third = states
        for name in FUNCTIONS:
            arguments = self._arguments(name, states)
            wanted = getattr(self.kernel, f"{name}_batch")(*arguments)
            for k in range(CHECKED):
                self._near(getattr(self.kernel, name)(*(a[k] for a in arguments)), wanted[k], name)
                if self.pin is not None:
                    self._near(self._by_wheel(name, [a[k] for a in arguments]), wanted[k], f"{name}, pin")
            columns = [np.ascontiguousarray(a.T) for a in arguments]
            self._near(np.moveaxis(getattr(self.kernel, f"{name}_soa")(*columns), -1, 0), wanted, f"{name}_soa")
            self._near(getattr(self.kernel, f"{name}_batch_parallel")(*arguments), wanted, f"{name}_batch_parallel")
            for rival in rivals:
                out = np.empty_like(wanted)
                rival.loops[name](q, qd, third, out)
                self._near(out, wanted, f"{name}, {rival.build}")

    def _batches(self, name: str, arguments: tuple[Array, ...], form: str, count: int) -> Iterator[Contestant]:
        yield Contestant(name, form, "symdyn, rows", _call(getattr(self.kernel, f"{name}_batch"), *arguments), count)
        into, out = getattr(self.kernel, f"{name}_batch_into"), self._empty(name, count)
        yield Contestant(name, form, "symdyn, rows, in place", _call(into, *arguments, out), count)
        parallel = getattr(self.kernel, f"{name}_batch_parallel")
        yield Contestant(name, form, "symdyn, rows, all cores", _call(parallel, *arguments), count, threads=True)
        both, there = getattr(self.kernel, f"{name}_batch_parallel_into"), self._empty(name, count)
        run = _call(both, *arguments, there)
        yield Contestant(name, form, "symdyn, rows, in place, all cores", run, count, threads=True)
        columns = tuple(np.ascontiguousarray(a.T) for a in arguments)
        yield Contestant(name, form, "symdyn, columns", _call(getattr(self.kernel, f"{name}_soa"), *columns), count)

    def _arguments(self, name: str, states: tuple[Array, ...]) -> tuple[Array, ...]:
        return states[:1] if name == "mass_matrix" else states

    def _empty(self, name: str, count: int) -> Array:
        n = self.arm.joints
        shape = {"mass_matrix": (n, n), "forward_dynamics_state_jacobian": (n, 2 * n)}.get(name, (n,))
        return np.full((count, *shape), np.nan)

    def _wheel(self, name: str) -> tuple[Callable[..., Any], Any, Any]:
        model = self.arm.pin_model(self.pin)
        names = ("rnea", "crba", "aba", "computeABADerivatives")
        return getattr(self.pin, dict(zip(FUNCTIONS, names, strict=True))[name]), model, model.createData()

    def _by_wheel(self, name: str, arguments: list[Array]) -> Array:
        function, model, data = self._wheel(name)
        found = function(model, data, *arguments)
        if name == "mass_matrix":
            found = np.triu(found) + np.triu(found, 1).T
        result: Array = np.hstack(found[:2]) if isinstance(found, tuple) else np.asarray(found)
        return result

    def _near(self, found: Array, wanted: Array, what: str) -> None:
        scale = np.abs(wanted).max()
        np.testing.assert_allclose(found, wanted, rtol=TOLERANCE, atol=TOLERANCE * scale, err_msg=what)


def compiled_loop(into: Callable[..., None], count: int) -> Callable[..., None]:
    """One state after the other from compiled code, as a controller or an integrator calls it."""

    def of_one(a: Any, out: Any) -> None:
        for k in range(a.shape[0]):
            into(a[k], out[k])

    def of_three(a: Any, b: Any, c: Any, out: Any) -> None:
        for k in range(a.shape[0]):
            into(a[k], b[k], c[k], out[k])

    loop: Callable[..., None] = njit(of_one if count == 1 else of_three)
    return loop


def _call(function: Callable[..., Any], *arguments: Any) -> Run:
    return lambda: function(*arguments)


def _times(function: Callable[..., Any], *arguments: Any) -> Run:
    def run() -> None:
        for _ in range(CALLS):
            function(*arguments)

    return run
