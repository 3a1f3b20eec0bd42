"""The filter itself, compiled once for all machines: innovations, their variances, their sensitivities."""

from __future__ import annotations

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from symdyn.numeric.filtering.kinks import HASTY, KINK, PATIENCE, RUNGS, SHORTEST, bent, reach
from symdyn.numeric.filtering.measure import measured
from symdyn.numeric.hybrid.compiled import compiled
from symdyn.numeric.transition import HALVES, product, room, source_weights, transition

Array = NDArray[np.float64]

KINKED = 0.05  # of the square of what a kink does to a step: variance, as it may come sooner or later
MEMORY = 1000.0  # samples that say what is usual
ALIKE = 1e-4  # relative change of the machine's Jacobian: with the one before a step goes as far
GENTLE = 0.25  # of what a step does to a state: a Jacobian that changes that by more does not correct it
STEADY = 1e-6  # relative change of every variance in a step below which gains are kept

_vector, _matrix, _cube = (types.Array(types.float64, d, "C") for d in (1, 2, 3))
_counts = types.Array(types.int64, 1, "C")
_to_vector = types.FunctionType(types.none(_vector, _vector, _vector, _vector))
_to_matrix = types.FunctionType(types.none(_vector, _vector, _vector, _matrix))


@compiled
def _begin(cov: Array, p0: Array, power: Array, n: int) -> None:
    """Covariance before the first sample, and after a gap: of the state, and of forces as they usually are."""
    for i in range(len(cov)):
        for j in range(len(cov)):
            cov[i, j] = p0[i, j] if i < n and j < n else 0.0
    for i in range(len(power)):
        cov[n + i, n + i] = power[i]


@compiled
def _turned(
    by_x: Array, a: Array, phi: Array, h: float, n: int, dz: Array, moved: Array, change: Array, way: Array, more: Array
) -> None:
    """Add to sensitivities ``moved`` (n, q) that a step took ``dz`` (n, q) to what the Jacobian's change adds.

    From ``a`` at its start to ``by_x`` at its end: what a step does is, to second order, what the mean of both does.
    All matrices have room (``product``).
    """
    for i in range(n):
        for j in range(n):
            change[i, j] = 0.25 * h * (by_x[i, j] - a[i, j])
    for i in range(n):
        own = 0.0
        for j in range(n):
            own += change[i, j] * phi[j, i] + phi[i, j] * change[j, i]
        if not abs(own) <= GENTLE:
            return
    product(change, dz, n, n, way)
    product(phi, way, n, n, more)
    product(change, moved, n, n, way)
    for i in range(n):
        for j in range(moved.shape[1]):
            moved[i, j] += more[i, j] + way[i, j]


@njit(
    types.int64(
        *(
            _to_vector,
            _to_matrix,
            _to_matrix,
            _to_matrix,
        ),  # rate of the state, its derivatives by state, input, parameters
        *(_to_vector, _to_matrix, _to_matrix),  # outputs, their derivatives by state and parameters
        *(_matrix, _matrix, _matrix, _vector),  # inputs, their slopes, measurements, steps
        *(_matrix, _counts),  # sets of parameters, and which of them holds at each sample
        *(_counts, _matrix, _matrix),  # parameters by which is differentiated, how far, signals' variances
        *(_counts, _matrix, _matrix, _matrix),  # measured signals, latent directions, their decay rates and variances
        *(_vector, _matrix, types.int64, types.int64),  # start, its covariance, substeps, how many outputs
        *(_vector, _cube, _cube, _cube, _matrix),  # -log L, innovations, variances, sensitivities, states
    ),
    cache=True,
    nogil=True,
    error_model="numpy",
)
def run(  # type: ignore[no-untyped-def]
    f,
    f_x,
    f_u,
    f_p,
    g,
    g_x,
    g_p,
    u,
    slope_u,
    y,
    steps,
    sets,
    holds,
    which,
    weight,
    r,
    signals,
    latent,
    decay,
    power,
    x0,
    p0,
    substeps,
    outputs,
    loss,
    e,
    s,
    de,
    xs,
):
    """Extended Kalman filter over a recording, its -log L up to a constant. All arrays C-contiguous.

    Returns how many steps it took, and pieces of steps.

    State z = [x, w]: w (l,) are latent forces, Ornstein-Uhlenbeck processes along ``latent`` (np, l) in the space of
    parameters: of offsets, whose effect on the machine changes no sooner than its Jacobian. Measurement c shows state
    ``signals[c]``, or output ``signals[c] - n``. A measurement that is nan is left out; a step that is not finite
    starts the state anew.

    ``r`` (v, m), ``decay`` and ``power`` (v, l) are one filter in each row, each with its own state. The others share
    the Jacobians and the steps of the first, from which they keep the distance that those say: that is most of the
    work, and right for noise that is nearly the same.

    Across a kink a step goes in pieces (``kinks``), and what it did may be a little more or less: ``KINKED``.
    Parameters that a recording tells have one value here and another there: ``sets`` (S, np), of which row
    ``holds[k]`` is true from sample k to the next.
    A linearised filter is sometimes wrong about which way a machine went: an innovation beyond ``measure.SURPRISE``
    counts as one of larger variance, which ``s`` then says.

    Sensitivities (d innovation / d p) take the gains as given (Ljung 1999, ch. 10: pseudo-linear regression);
    ``weight`` (N, q) is how far a parameter goes along in each step: a force with a course of its own is one, too.
    """
    n, nu, nl, m, q, count, filters = len(x0), u.shape[1], latent.shape[1], y.shape[1], len(which), len(y), len(r)
    nz, na = n + nl, n + nu
    wide, wide_z, wide_q = room(na), room(nz), room(q)
    x, w, kept = np.zeros((filters, n)), np.zeros((filters, nl)), np.zeros((filters, nl))
    rate, out = np.zeros(n), np.zeros(outputs)
    a_old, c_all = np.empty((na, na)), np.zeros((len(out), n))
    by_x, by_u, control = np.zeros((n, n)), np.zeros((n, nu)), np.zeros(nu)
    there, arrived, usual, ahead, push = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(nu), np.zeros(n)
    a, term, space = np.zeros((wide, wide)), np.zeros((wide, wide)), np.zeros((wide, wide))
    # of [x, u], as an input goes straight along its slope: for what is left of a step, for half of it, ...
    ladder, many, rung, finer = np.zeros((RUNGS, 3, wide, wide)), 0, 0, 0
    begun, between, from_there = np.zeros(n), np.zeros(n), np.zeros(nu)
    parameters = sets.shape[1]
    by_p, outputs_by_p = np.zeros((n, parameters)), np.zeros((len(out), parameters))
    pushes, pushing = np.empty(parameters, dtype=np.int64), 0  # parameters that latent forces go along
    for i in range(parameters):
        for j in range(nl):
            if latent[i, j] != 0.0:
                pushes[pushing] = i
                pushing += 1
                break
    force, forced = np.zeros((wide, room(nl))), np.zeros((wide, room(nl)))
    dz, source, moved = np.zeros((wide_z, wide_q)), np.zeros((wide, wide_q)), np.zeros((wide_z, wide_q))
    turning, way, more = np.zeros((wide, wide)), np.zeros((wide, wide_q)), np.zeros((wide_z, wide_q))
    nodes, rest = np.zeros((HALVES + 2, wide, wide)), np.zeros((wide, wide))  # what that does over a step
    phi, work, turned = np.zeros((wide_z, wide_z)), np.zeros((wide_z, wide_z)), np.zeros((wide_z, wide_z))
    row, shown, h_old = np.zeros(nz), np.zeros(n), -1.0
    covs, gains, spread = np.zeros((filters, wide_z, wide_z)), np.zeros((filters, m, nz)), np.zeros((filters, m))
    predicted, beside, straight = np.zeros((filters, nz)), np.zeros((filters, n)), np.zeros(n)
    steady = np.zeros(filters, dtype=np.bool_)  # gains as before: neither the machine nor its covariance changed
    for v in range(filters):
        loss[v] = 0.0
        for i in range(n):
            x[v, i] = x0[i]
        _begin(covs[v], p0, power[v], n)
    taken = 0 * count
    for k in range(count):
        p = sets[holds[k]]
        # what was measured
        for v in range(filters):
            here = x[v]
            if len(out):
                g(here, u[k], p, out)
                if v == 0:
                    g_x(here, u[k], p, c_all)
                    if q:
                        g_p(here, u[k], p, outputs_by_p)
            loss[v], steady[v] = measured(
                y[k], signals, r[v], out, c_all, outputs_by_p, which, q if v == 0 else 0, steady[v], here, w[v],
                covs[v], gains[v], spread[v], dz, row, shown, loss[v], e[v, k], s[v, k], de[k],
            )  # fmt: skip
        for i in range(nz):
            xs[k, i] = x[0, i] if i < n else w[0, i - n]
        if k + 1 == count:
            break
        # the way to the next sample
        if not np.isfinite(steps[k]):
            for i in range(nz):
                for j in range(q):
                    dz[i, j] = 0.0
            for v in range(filters):
                steady[v] = False
                _begin(covs[v], p0, power[v], n)
                for c in range(m):
                    if signals[c] < n and not np.isnan(y[k + 1, c]):
                        x[v, signals[c]] = y[k + 1, c]
            continue
        whole, step, left, length = steps[k] / substeps, 0, 1.0, 1.0  # of a step what is left, and its next piece
        for j in range(nu):
            control[j] = u[k, j]
        unchanged, kinked, pieces = True, False, 0
        while step < substeps:
            f(x[0], control, p, rate)
            f_x(x[0], control, p, by_x)
            f_u(x[0], control, p, by_u)
            same = left == 1.0 and whole == h_old
            for i in range(n):
                for j in range(na):
                    a[i, j] = by_x[i, j] if j < n else by_u[i, j - n]
                    if not abs(a[i, j] - a_old[i, j]) <= ALIKE * abs(a_old[i, j]):
                        same = False
                push[i] = 0.0
                for j in range(nl):
                    push[i] += force[i, j] * w[0, j]
            if left == 1.0:  # a kink on the way (friction turns, a flank touches) shows in the rate at the end
                length, pieces, rung = 1.0, 0, 0
                for i in range(n):
                    usual[i] += (abs(rate[i]) - usual[i]) / min(k + 1.0, MEMORY)
                if not same:
                    finer = many = transition(a, na, whole, q > 0, ladder, term, space)
                if bent(
                    f, f_x, x[0], control, slope_u[k], p, rate, push, a, ladder[0, 1], whole, KINK, 0.0, usual,
                    there, ahead, arrived, by_x,
                ):  # fmt: skip
                    length, kinked = 0.0, True
                    for i in range(n):
                        straight[i] = there[i]
            if length != 1.0:
                same, finer = False, 0
                length, rung = reach(
                    f, f_x, x[0], control, slope_u[k], p, rate, push, a, na, whole, left,
                    HASTY if pieces >= PATIENCE else SHORTEST, q > 0, ladder, many if pieces == 0 else -1, usual,
                    there, ahead, arrived, by_x, term, space,
                )  # fmt: skip
                pieces += 1
            change, integral = ladder[rung, 0], ladder[rung, 1]
            left -= length
            ends = left == 0.0
            if ends:
                step, left = step + 1, 1.0
            taken += 1
            h = whole * length
            if not same:
                unchanged, h_old = False, h
                for i in range(na):
                    for j in range(na):
                        a_old[i, j] = a[i, j]
                for v in range(filters):
                    if steady[v]:  # what was left out while nothing changed
                        steady[v] = False
                        for c in range(m):
                            for i in range(nz):
                                for j in range(nz):
                                    covs[v, i, j] -= gains[v, c, i] * gains[v, c, j] / spread[v, c]
                    for j in range(nl):
                        kept[v, j] = np.exp(-decay[v, j] * h)
            if q or (nl and not same):
                f_p(x[0], control, p, by_p)
            if not same:  # else what a force does to the machine is as before, too
                for i in range(n):
                    for j in range(nl):
                        force[i, j] = 0.0
                        for c in pushes[:pushing]:
                            force[i, j] += by_p[i, c] * latent[c, j]
                if nl:
                    product(integral, force, n, n, forced)
                for i in range(n):
                    for j in range(n):
                        phi[i, j] = change[i, j] + (1.0 if i == j else 0.0)
                    for j in range(nl):
                        phi[i, n + j] = forced[i, j]
            for v in range(1, filters):  # they keep the distance that the Jacobian says
                for i in range(n):
                    shown[i] = x[v, i] - x[0, i]
                for i in range(n):
                    beside[v, i] = 0.0
                    for j in range(n):
                        beside[v, i] += phi[i, j] * shown[j]
                    for j in range(nl):
                        beside[v, i] += phi[i, n + j] * (w[v, j] - w[0, j])
            for i in range(n):
                for j in range(nl):
                    rate[i] += force[i, j] * w[0, j]
            if q:
                for i in range(n):
                    begun[i] = x[0, i]
                for j in range(nu):
                    from_there[j] = control[j]
            for i in range(n):
                for j in range(n):
                    x[0, i] += integral[i, j] * rate[j]
                for j in range(nu):
                    x[0, i] += integral[i, n + j] * slope_u[k, j]
            for v in range(filters):
                for i in range(n):
                    if v:
                        x[v, i] = x[0, i] + beside[v, i]
                for j in range(nl):
                    w[v, j] *= kept[v, j]
            for j in range(nu):
                control[j] += h * slope_u[k, j]
            if q:
                if not same:
                    source_weights(ladder[rung:], finer, n, h, nodes, rest, term, space)
                product(phi, dz, n, nz, moved)
                f_x(x[0], control, p, by_x)
                _turned(by_x, a, phi, h, n, dz, moved, turning, way, more)
                for i in range(n):
                    for j in range(q):
                        dz[i, j] = moved[i, j]
                # what a parameter adds to the rate goes straight between all h / 2^i: what is stiff settles early
                for node in range(finer + 2):
                    if node == finer + 1:
                        f_p(x[0], control, p, by_p)
                    elif node:
                        part_way = 0.5 ** (finer + 1 - node)
                        for i in range(n):
                            between[i] = begun[i]
                            for j in range(n):
                                between[i] += ladder[rung + finer - node + 1, 1, i, j] * rate[j]
                            for j in range(nu):
                                between[i] += ladder[rung + finer - node + 1, 1, i, n + j] * slope_u[k, j]
                        for j in range(nu):
                            ahead[j] = from_there[j] + part_way * h * slope_u[k, j]
                        f_p(between, ahead, p, by_p)
                    for i in range(n):
                        for j in range(q):
                            source[i, j] = weight[k, j] * by_p[i, which[j]]
                    product(nodes[node], source, n, n, moved)
                    for i in range(n):
                        for j in range(q):
                            dz[i, j] += moved[i, j]
                for j in range(nl):
                    for i in range(q):
                        dz[n + j, i] *= kept[0, j]
            for v in range(filters):
                if steady[v]:
                    continue
                cov = covs[v]
                for j in range(nl):
                    phi[n + j, n + j] = kept[v, j]
                product(phi, cov, nz, nz, work)
                for i in range(nz):
                    for j in range(nz):
                        turned[j, i] = work[i, j]
                product(phi, turned, nz, nz, cov)
                for i in range(nz):
                    for j in range(i):
                        cov[i, j] = cov[j, i]
                for j in range(nl):
                    cov[n + j, n + j] += power[v, j] * (1.0 - kept[v, j] * kept[v, j])
            if kinked and ends:
                kinked = False
                for i in range(n):
                    straight[i] = x[0, i] - straight[i]
                for v in range(filters):
                    for i in range(n):
                        for j in range(n):
                            covs[v, i, j] += KINKED * straight[i] * straight[j]
        for v in range(filters):
            if not steady[v] and unchanged:
                steady[v] = True
                for i in range(nz):
                    if abs(covs[v, i, i] - predicted[v, i]) > STEADY * covs[v, i, i]:
                        steady[v] = False
            for i in range(nz):
                predicted[v, i] = covs[v, i, i]
            lost = False
            for i in range(n):
                lost = lost or not np.isfinite(x[v, i])
            if lost:
                loss[v] = np.inf
                if v == 0:
                    for other in range(filters):
                        loss[other] = np.inf
                    return taken
    return taken
