"""The filter itself, compiled once for all machines: innovations, their variances, their sensitivities."""

from __future__ import annotations

import numpy as np
from numba import njit, types
from numpy.typing import NDArray

from symdyn.numeric.filtering.transition import product, room, transition

Array = NDArray[np.float64]

KINK = 0.1  # of a usual rate: what the slope at the start of a step does not foretell of it
MEMORY = 1000.0  # samples that say what is usual
FINE = 16  # pieces of a step with a kink in it
ALIKE = 1e-4  # relative change of the machine's Jacobian: with the one before a step goes as far
NEARLY = 1e-2  # the same for a piece of a step, which is that much shorter
STEADY = 1e-6  # relative change of every variance in a step below which gains are kept

_vector, _matrix, _cube = (types.Array(types.float64, d, "C") for d in (1, 2, 3))
_counts = types.Array(types.int64, 1, "C")
_to_vector = types.FunctionType(types.none(_vector, _vector, _vector, _vector))
_to_matrix = types.FunctionType(types.none(_vector, _vector, _vector, _matrix))


@njit(
    types.float64(
        *(
            _to_vector,
            _to_matrix,
            _to_matrix,
            _to_matrix,
        ),  # rate of the state, its derivatives by state, input, parameters
        *(_to_vector, _to_matrix, _to_matrix),  # outputs, their derivatives by state and parameters
        *(_matrix, _matrix, _matrix, _vector),  # inputs, their slopes, measurements, steps
        *(_vector, _counts, _matrix, _vector),  # parameters, by which is differentiated, how far, signals' variances
        *(_counts, _matrix, _vector, _vector),  # measured signals, latent directions, their decay rates and variances
        *(_vector, _matrix, types.int64, types.int64),  # start, its covariance, substeps, how many outputs
        *(_matrix, _matrix, _cube, _matrix),  # innovations, variances, sensitivities, states
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
    p,
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
    e,
    s,
    de,
    xs,
):
    """Extended Kalman filter over a recording; returns -log L up to a constant. All arrays C-contiguous.

    State z = [x, w]: w (l,) are latent forces, Ornstein-Uhlenbeck processes along ``latent`` (np, l) in
    the space of parameters. Measurement c shows state ``signals[c]``, or output ``signals[c] - n``. A
    measurement that is nan is left out; a step that is not finite starts the state anew.
    Sensitivities (d innovation / d p) take the gains as given (Ljung 1999, ch. 10: pseudo-linear regression);
    ``weight`` (N, q) is how far a parameter goes along in each step: a force with a course of its own is one, too.
    """
    n, nu, nl, m, q, count = len(x0), u.shape[1], len(decay), y.shape[1], len(which), len(y)
    nz, na = n + nl, n + nu
    wide, wide_z, wide_q = room(na), room(nz), room(q)
    x, w = x0.copy(), np.zeros(nl)
    rate, out = np.zeros(n), np.zeros(outputs)
    a_old, c_all = np.full((na, na), np.nan), np.zeros((len(out), n))
    by_x, by_u, control = np.zeros((n, n)), np.zeros((n, nu)), np.zeros(nu)
    there, arrived, usual, ahead = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(nu)
    a, term, space = np.zeros((wide, wide)), np.zeros((wide, wide)), np.zeros((wide, wide))
    # of [x, u]: an input goes straight along its slope
    change, integral, ramp = np.zeros((wide, wide)), np.zeros((wide, wide)), np.zeros((wide, wide))
    by_p, by_p_there, outputs_by_p = np.zeros((n, len(p))), np.zeros((n, len(p))), np.zeros((len(out), len(p)))
    pushes = np.array([i for i in range(len(p)) if np.any(latent[i] != 0.0)], dtype=np.int64)
    force, forced = np.zeros((wide, room(nl))), np.zeros((wide, room(nl)))
    dz, source, growth, moved = (  # those of rates have rows for inputs: zero, as integrals reach over both
        np.zeros((wide_z, wide_q)),
        np.zeros((wide, wide_q)),
        np.zeros((wide, wide_q)),
        np.zeros((wide_z, wide_q)),
    )
    cov, phi, work, turned = (
        np.zeros((wide_z, wide_z)),
        np.zeros((wide_z, wide_z)),
        np.zeros((wide_z, wide_z)),
        np.zeros((wide_z, wide_z)),
    )
    row, gain = np.zeros(nz), np.zeros(nz)
    total, h_old = 0.0, -1.0
    gains, spread, predicted = np.zeros((m, nz)), np.zeros(m), np.zeros(nz)
    steady = False  # gains as in the step before: neither the machine nor its covariance changed
    cov[:n, :n] = p0
    for i in range(nl):
        cov[n + i, n + i] = power[i]
    for k in range(count):
        # what was measured
        if len(out):
            g(x, u[k], p, out)
            g_x(x, u[k], p, c_all)
            if q:
                g_p(x, u[k], p, outputs_by_p)
        shown = x.copy()
        for c in range(m):
            if np.isnan(y[k, c]):
                e[k, c], s[k, c] = 0.0, 1.0
                for j in range(q):
                    de[k, c, j] = 0.0
                steady = False
                continue
            index = signals[c]
            if index < n:
                for i in range(nz):
                    row[i] = 1.0 if i == index else 0.0
                value = x[index]
            else:
                value = out[index - n]
                for i in range(n):
                    row[i] = c_all[index - n, i]
                    value += row[i] * (x[i] - shown[i])
                for i in range(n, nz):
                    row[i] = 0.0
            if steady:
                gain[:] = gains[c]
                variance = spread[c]
            else:
                variance = r[c]
                for i in range(nz):
                    gain[i] = 0.0
                    for j in range(nz):
                        gain[i] += cov[i, j] * row[j]
                    variance += row[i] * gain[i]
                variance = max(variance, r[c])  # rounding may make a covariance of nearly nothing negative
                gains[c] = gain
                spread[c] = variance
            innovation = y[k, c] - value
            e[k, c], s[k, c] = innovation, variance
            total += 0.5 * (innovation * innovation / variance + np.log(variance))
            for j in range(q):
                slope = outputs_by_p[index - n, which[j]] if index >= n else 0.0
                for i in range(n):
                    slope += row[i] * dz[i, j]
                de[k, c, j] = -slope
            for i in range(nz):
                part = gain[i] / variance
                if i < n:
                    x[i] += part * innovation
                else:
                    w[i - n] += part * innovation
                for j in range(q):
                    dz[i, j] += part * de[k, c, j]
                if not steady:
                    for j in range(nz):
                        cov[i, j] -= part * gain[j]
        for i in range(nz):
            xs[k, i] = x[i] if i < n else w[i - n]
        if k + 1 == count:
            break
        # the way to the next sample
        if not np.isfinite(steps[k]):
            steady = False
            cov[:] = 0.0
            cov[:n, :n] = p0
            dz[:] = 0.0
            for i in range(nl):
                cov[n + i, n + i] = power[i]
            for c in range(m):
                if signals[c] < n and not np.isnan(y[k + 1, c]):
                    x[signals[c]] = y[k + 1, c]
            continue
        pieces, piece = substeps, 0
        h = steps[k] / pieces
        control[:] = u[k]
        unchanged = True
        while piece < pieces:
            f(x, control, p, rate)
            f_x(x, control, p, by_x)
            f_u(x, control, p, by_u)
            same, tolerance = h == h_old, ALIKE if pieces == substeps else NEARLY
            for i in range(n):
                for j in range(na):
                    a[i, j] = by_x[i, j] if j < n else by_u[i, j - n]
                    if not abs(a[i, j] - a_old[i, j]) <= tolerance * abs(a_old[i, j]):
                        same = False
            if not same:
                unchanged = False
                transition(a, na, h, q > 0, change, integral, ramp, term, space)
                a_old[:] = a[:na, :na]
                h_old = h
            if piece == 0 and pieces == substeps:
                # a kink on the way (friction turns, a flank touches) shows in the rate at the end
                for i in range(n):
                    there[i] = x[i]
                    for j in range(n):
                        there[i] += integral[i, j] * rate[j]
                    for j in range(nu):
                        there[i] += integral[i, n + j] * slope_u[k, j]
                for j in range(nu):
                    ahead[j] = control[j] + h * slope_u[k, j]
                f(there, ahead, p, arrived)
                for i in range(n):
                    expected = rate[i]
                    usual[i] += (abs(rate[i]) - usual[i]) / min(k + 1.0, MEMORY)
                    for j in range(n):
                        expected += by_x[i, j] * (there[j] - x[j])
                    for j in range(nu):
                        expected += by_u[i, j] * h * slope_u[k, j]
                    if abs(arrived[i] - expected) > KINK * usual[i]:
                        pieces = substeps * FINE
                if pieces != substeps:
                    h = steps[k] / pieces
                    unchanged = False
                    transition(a, na, h, q > 0, change, integral, ramp, term, space)
                    h_old = h
            if steady and not unchanged:  # what was left out while nothing changed
                for c in range(m):
                    for i in range(nz):
                        for j in range(nz):
                            cov[i, j] -= gains[c, i] * gains[c, j] / spread[c]
                steady = False
            piece += 1
            if nl or q:
                f_p(x, control, p, by_p)
            if nl:
                for i in range(n):
                    for j in range(nl):
                        force[i, j] = 0.0
                        for c in pushes:
                            force[i, j] += by_p[i, c] * latent[c, j]
                product(integral, force, n, n, forced)
                for i in range(n):
                    for j in range(nl):
                        rate[i] += force[i, j] * w[j]
            for i in range(n):
                for j in range(n):
                    x[i] += integral[i, j] * rate[j]
                for j in range(nu):
                    x[i] += integral[i, n + j] * slope_u[k, j]
            for j in range(nu):
                control[j] += h * slope_u[k, j]
            if q:  # what a parameter adds to the rate goes straight from its value here to that at the end
                f_p(x, control, p, by_p_there)
                for i in range(n):
                    for j in range(q):
                        source[i, j] = weight[k, j] * by_p[i, which[j]]
                        growth[i, j] = weight[k, j] * (by_p_there[i, which[j]] - by_p[i, which[j]]) / h
                        for c in range(nl):
                            source[i, j] += force[i, c] * dz[n + c, j]
                product(integral, source, n, n, moved)
                for i in range(n):
                    for j in range(q):
                        source[i, j], dz[i, j] = dz[i, j], dz[i, j] + moved[i, j]
                product(ramp, growth, n, n, moved)
                for i in range(n):
                    for j in range(q):
                        dz[i, j] += moved[i, j]
                product(change, source, n, n, moved)
                for i in range(n):
                    for j in range(q):
                        dz[i, j] += moved[i, j]
            for j in range(nl):
                kept = np.exp(-decay[j] * h)
                w[j] *= kept
                for i in range(q):
                    dz[n + j, i] *= kept
            if steady:
                continue
            for i in range(n):
                for j in range(n):
                    phi[i, j] = change[i, j] + (1.0 if i == j else 0.0)
                for j in range(nl):
                    phi[i, n + j] = forced[i, j]
            for j in range(nl):
                phi[n + j, n + j] = np.exp(-decay[j] * h)
            product(phi, cov, nz, nz, work)
            for i in range(nz):
                for j in range(nz):
                    turned[j, i] = work[i, j]
            product(phi, turned, nz, nz, cov)
            for i in range(nz):
                for j in range(i):
                    cov[i, j] = cov[j, i]
            for j in range(nl):
                cov[n + j, n + j] += power[j] * (1.0 - np.exp(-2.0 * decay[j] * h))
        if not steady and unchanged:
            steady = True
            for i in range(nz):
                if abs(cov[i, i] - predicted[i]) > STEADY * cov[i, i]:
                    steady = False
        for i in range(nz):
            predicted[i] = cov[i, i]
        if not np.all(np.isfinite(x)):
            return np.inf
    return total
