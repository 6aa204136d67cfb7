"""The block with numba, as one would write a fast step in Python: `python block_numba.py --dim 2 --threads 1`.

linear    FLIP, stress from the velocities after the step, small strain
bspline2  MLS-MPM: APIC, neo-Hookean from the deformation gradient

A particle is a row of P, a node a row of g. With threads, each sums into a grid of its own, and the grids are added.
"""

import os

from problem import DENSITY, GRAVITY, LAME, SHEAR, Problem

problem = Problem()
os.environ["NUMBA_NUM_THREADS"] = str(problem.threads)

import numba
import numpy as np

D, W = problem.dim, problem.nodes
DT, INV, H = problem.dt, 1 / problem.spacing, problem.spacing
FIRST, LAST = problem.first, problem.last
FALL = DT * GRAVITY
compiled = numba.njit(fastmath=True, error_model="numpy", boundscheck=False)
inlined = numba.njit(fastmath=True, error_model="numpy", boundscheck=False, inline="always")


def linear_2d():
    """Rows: x, y, vx, vy, sxx, syy, sxy, mass, volume; nodes: mass, momentum (then old velocity), force (then new velocity)."""

    @compiled
    def scatter(P, g, lo, hi):
        for p in range(lo, hi):
            x, y = P[p, 0] * INV, P[p, 1] * INV
            i, j = int(x), int(y)
            x, y = x - i, y - j
            mass, volume = P[p, 7], P[p, 8]
            mx, my = mass * P[p, 2], mass * P[p, 3]
            sxx, syy, sxy = -volume * P[p, 4], -volume * P[p, 5], -volume * P[p, 6]
            for a in range(2):
                wx, dx = (x, INV) if a else (1 - x, -INV)
                for b in range(2):
                    wy, dy = (y, INV) if b else (1 - y, -INV)
                    w, gx, gy = wx * wy, dx * wy, wx * dy
                    k = (i + a) * W + j + b
                    g[k, 0] += w * mass
                    g[k, 1] += w * mx
                    g[k, 2] += w * my
                    g[k, 3] += sxx * gx + sxy * gy
                    g[k, 4] += sxy * gx + syy * gy

    @compiled
    def gather(P, g, lo, hi):
        for p in range(lo, hi):
            x, y = P[p, 0] * INV, P[p, 1] * INV
            i, j = int(x), int(y)
            x, y = x - i, y - j
            ax = ay = vx = vy = lxx = lxy = lyx = lyy = 0.0
            for a in range(2):
                wx, dx = (x, INV) if a else (1 - x, -INV)
                for b in range(2):
                    wy, dy = (y, INV) if b else (1 - y, -INV)
                    w, gx, gy = wx * wy, dx * wy, wx * dy
                    k = (i + a) * W + j + b
                    u, v = g[k, 3], g[k, 4]
                    ax += w * (u - g[k, 1])
                    ay += w * (v - g[k, 2])
                    vx += w * u
                    vy += w * v
                    lxx += u * gx
                    lxy += u * gy
                    lyx += v * gx
                    lyy += v * gy
            P[p, 0] += DT * vx
            P[p, 1] += DT * vy
            P[p, 2] += ax
            P[p, 3] += ay
            volumetric = lxx + lyy
            P[p, 4] += DT * (LAME * volumetric + 2 * SHEAR * lxx)
            P[p, 5] += DT * (LAME * volumetric + 2 * SHEAR * lyy)
            P[p, 6] += DT * SHEAR * (lxy + lyx)
            P[p, 8] *= 1 + DT * volumetric

    return scatter, gather, 9, 5, 7, 5


def linear_3d():
    """Rows: position, velocity, sxx, syy, szz, sxy, syz, szx, mass, volume; nodes as in 2-D."""

    @compiled
    def scatter(P, g, lo, hi):
        for p in range(lo, hi):
            x, y, z = P[p, 0] * INV, P[p, 1] * INV, P[p, 2] * INV
            i, j, l = int(x), int(y), int(z)
            x, y, z = x - i, y - j, z - l
            mass, volume = P[p, 12], P[p, 13]
            mx, my, mz = mass * P[p, 3], mass * P[p, 4], mass * P[p, 5]
            sxx, syy, szz = -volume * P[p, 6], -volume * P[p, 7], -volume * P[p, 8]
            sxy, syz, szx = -volume * P[p, 9], -volume * P[p, 10], -volume * P[p, 11]
            for a in range(2):
                wx, dx = (x, INV) if a else (1 - x, -INV)
                for b in range(2):
                    wy, dy = (y, INV) if b else (1 - y, -INV)
                    for c in range(2):
                        wz, dz = (z, INV) if c else (1 - z, -INV)
                        w, gx, gy, gz = wx * wy * wz, dx * wy * wz, wx * dy * wz, wx * wy * dz
                        k = ((i + a) * W + j + b) * W + l + c
                        g[k, 0] += w * mass
                        g[k, 1] += w * mx
                        g[k, 2] += w * my
                        g[k, 3] += w * mz
                        g[k, 4] += sxx * gx + sxy * gy + szx * gz
                        g[k, 5] += sxy * gx + syy * gy + syz * gz
                        g[k, 6] += szx * gx + syz * gy + szz * gz

    @compiled
    def gather(P, g, lo, hi):
        for p in range(lo, hi):
            x, y, z = P[p, 0] * INV, P[p, 1] * INV, P[p, 2] * INV
            i, j, l = int(x), int(y), int(z)
            x, y, z = x - i, y - j, z - l
            ax = ay = az = vx = vy = vz = 0.0
            lxx = lxy = lxz = lyx = lyy = lyz = lzx = lzy = lzz = 0.0
            for a in range(2):
                wx, dx = (x, INV) if a else (1 - x, -INV)
                for b in range(2):
                    wy, dy = (y, INV) if b else (1 - y, -INV)
                    for c in range(2):
                        wz, dz = (z, INV) if c else (1 - z, -INV)
                        w, gx, gy, gz = wx * wy * wz, dx * wy * wz, wx * dy * wz, wx * wy * dz
                        k = ((i + a) * W + j + b) * W + l + c
                        u, v, t = g[k, 4], g[k, 5], g[k, 6]
                        ax += w * (u - g[k, 1])
                        ay += w * (v - g[k, 2])
                        az += w * (t - g[k, 3])
                        vx += w * u
                        vy += w * v
                        vz += w * t
                        lxx += u * gx
                        lxy += u * gy
                        lxz += u * gz
                        lyx += v * gx
                        lyy += v * gy
                        lyz += v * gz
                        lzx += t * gx
                        lzy += t * gy
                        lzz += t * gz
            P[p, 0] += DT * vx
            P[p, 1] += DT * vy
            P[p, 2] += DT * vz
            P[p, 3] += ax
            P[p, 4] += ay
            P[p, 5] += az
            volumetric = lxx + lyy + lzz
            P[p, 6] += DT * (LAME * volumetric + 2 * SHEAR * lxx)
            P[p, 7] += DT * (LAME * volumetric + 2 * SHEAR * lyy)
            P[p, 8] += DT * (LAME * volumetric + 2 * SHEAR * lzz)
            P[p, 9] += DT * SHEAR * (lxy + lyx)
            P[p, 10] += DT * SHEAR * (lyz + lzy)
            P[p, 11] += DT * SHEAR * (lxz + lzx)
            P[p, 13] *= 1 + DT * volumetric

    return scatter, gather, 14, 7, 12, 8


def quadratic():
    """Rows: position, velocity, affine motion C, deformation gradient F; nodes: mass, momentum (then new velocity)."""
    C, F = 2 * D, 2 * D + D * D
    mass = DENSITY * problem.volume
    push = -DT * problem.volume * 4 * INV * INV

    @inlined
    def splines(P, p, offset, w):
        """The first node of a particle; fills its offsets from there (cells) and its weights."""
        k = 0
        for d in range(D):
            s = P[p, d] * INV
            b = int(s - 0.5)
            f = s - b
            offset[d] = f
            w[d, 0] = 0.5 * (1.5 - f) * (1.5 - f)
            w[d, 1] = 0.75 - (f - 1) * (f - 1)
            w[d, 2] = 0.5 * (f - 0.5) * (f - 0.5)
            k = k * W + b
        return k

    @compiled
    def scatter(P, g, lo, hi):
        w, offset, momentum = np.empty((D, 3)), np.empty(D), np.empty(D)
        new, A = np.empty((D, D)), np.empty((D, D))
        for p in range(lo, hi):
            first = splines(P, p, offset, w)
            for r in range(D):
                momentum[r] = mass * P[p, D + r]
                for c in range(D):
                    t = P[p, F + r * D + c]
                    for e in range(D):
                        t += DT * P[p, C + r * D + e] * P[p, F + e * D + c]
                    new[r, c] = t
            for r in range(D):
                for c in range(D):
                    P[p, F + r * D + c] = new[r, c]
            if D == 2:
                J = new[0, 0] * new[1, 1] - new[0, 1] * new[1, 0]
            else:
                J = (new[0, 0] * (new[1, 1] * new[2, 2] - new[1, 2] * new[2, 1])
                     - new[0, 1] * (new[1, 0] * new[2, 2] - new[1, 2] * new[2, 0])
                     + new[0, 2] * (new[1, 0] * new[2, 1] - new[1, 1] * new[2, 0]))
            for r in range(D):
                for c in range(D):
                    t = LAME * np.log(J) - SHEAR if r == c else 0.0
                    for e in range(D):
                        t += SHEAR * new[r, e] * new[c, e]
                    A[r, c] = push * t + mass * P[p, C + r * D + c]
            if D == 2:
                for a in range(3):
                    x = (a - offset[0]) * H
                    for b in range(3):
                        y = (b - offset[1]) * H
                        k, t = first + a * W + b, w[0, a] * w[1, b]
                        g[k, 0] += t * mass
                        g[k, 1] += t * (momentum[0] + A[0, 0] * x + A[0, 1] * y)
                        g[k, 2] += t * (momentum[1] + A[1, 0] * x + A[1, 1] * y)
            else:
                for a in range(3):
                    x = (a - offset[0]) * H
                    for b in range(3):
                        y = (b - offset[1]) * H
                        for c in range(3):
                            z = (c - offset[2]) * H
                            k, t = first + (a * W + b) * W + c, w[0, a] * w[1, b] * w[2, c]
                            g[k, 0] += t * mass
                            g[k, 1] += t * (momentum[0] + A[0, 0] * x + A[0, 1] * y + A[0, 2] * z)
                            g[k, 2] += t * (momentum[1] + A[1, 0] * x + A[1, 1] * y + A[1, 2] * z)
                            g[k, 3] += t * (momentum[2] + A[2, 0] * x + A[2, 1] * y + A[2, 2] * z)

    @compiled
    def gather(P, g, lo, hi):
        w, offset, v, B = np.empty((D, 3)), np.empty(D), np.empty(D), np.empty((D, D))
        for p in range(lo, hi):
            first = splines(P, p, offset, w)
            v[:] = 0
            B[:] = 0
            if D == 2:
                for a in range(3):
                    x = a - offset[0]
                    for b in range(3):
                        y = b - offset[1]
                        k, t = first + a * W + b, w[0, a] * w[1, b]
                        for r in range(2):
                            u = t * g[k, 1 + r]
                            v[r] += u
                            B[r, 0] += u * x
                            B[r, 1] += u * y
            else:
                for a in range(3):
                    x = a - offset[0]
                    for b in range(3):
                        y = b - offset[1]
                        for c in range(3):
                            z = c - offset[2]
                            k, t = first + (a * W + b) * W + c, w[0, a] * w[1, b] * w[2, c]
                            for r in range(3):
                                u = t * g[k, 1 + r]
                                v[r] += u
                                B[r, 0] += u * x
                                B[r, 1] += u * y
                                B[r, 2] += u * z
            for r in range(D):
                P[p, r] += DT * v[r]
                P[p, D + r] = v[r]
                for c in range(D):
                    P[p, C + r * D + c] = 4 * INV * B[r, c]

    return scatter, gather, F + D * D, 1 + D, None, None


def nodes_step(flip):
    """Velocities of the nodes lo to hi before (with FLIP) and after the step; rollers hold them."""

    @compiled
    def advance(g, lo, hi):
        for k in range(lo, hi):
            if g[k, 0] > 0:
                rest = k
                for back in range(D):
                    d = D - 1 - back
                    at = rest % W
                    rest //= W
                    old = g[k, 1 + d] / g[k, 0]
                    new = old + DT * g[k, 1 + D + d] / g[k, 0] if flip else old
                    if d == D - 1:
                        new += FALL
                    if at <= FIRST or (d < D - 1 and at >= LAST):
                        old = new = 0.0
                    if flip:
                        g[k, 1 + d], g[k, 1 + D + d] = old, new
                    else:
                        g[k, 1 + d] = new

    return advance


def stepper(scatter, gather, advance, count, total, width):
    if problem.threads == 1:
        @numba.njit
        def step(P, g, own):
            g[:] = 0
            scatter(P, g, 0, count)
            advance(g, 0, total)
            gather(P, g, 0, count)

        return step, np.zeros((0, 0, 0))
    T = problem.threads

    @numba.njit(parallel=True)
    def step(P, g, own):
        for t in numba.prange(T):
            own[t] = 0.0
            scatter(P, own[t], count * t // T, count * (t + 1) // T)
        for t in numba.prange(T):
            lo, hi = total * t // T, total * (t + 1) // T
            for k in range(lo, hi):
                for c in range(width):
                    s = own[0, k, c]
                    for other in range(1, T):
                        s += own[other, k, c]
                    g[k, c] = s
            advance(g, lo, hi)
        for t in numba.prange(T):
            gather(P, g, count * t // T, count * (t + 1) // T)

    return step, np.zeros((T, total, width))


def main():
    numba.set_num_threads(problem.threads)
    flip = problem.arguments.shape == "linear"
    kind = (linear_2d if D == 2 else linear_3d) if flip else quadratic
    scatter, gather, particle_width, node_width, mass, stress = kind()
    positions = problem.positions()
    count, total = len(positions), W**D
    P, g = np.zeros((count, particle_width)), np.zeros((total, node_width))
    P[:, :D] = positions
    if flip:
        P[:, mass], P[:, mass + 1] = DENSITY * problem.volume, problem.volume
    else:
        P[:, 2 * D + D * D:] = np.eye(D).ravel()
    step, own = stepper(scatter, gather, nodes_step(flip), count, total, node_width)
    check = lambda: (P[:, 2 * D - 1].mean(), P[:, stress].mean() if flip else None)
    problem.measure("numba " + numba.__version__, count, lambda: step(P, g, own), check)


main()
