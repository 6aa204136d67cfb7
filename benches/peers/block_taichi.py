"""The block with Taichi as its users write it, sums by atomic additions: `python block_taichi.py --dim 2 --threads 1`.

linear    FLIP, stress from the velocities after the step, small strain
bspline2  MLS-MPM: APIC, neo-Hookean from the deformation gradient
"""

import os

from problem import DENSITY, GRAVITY, LAME, SHEAR, Problem

os.environ["ENABLE_TAICHI_HEADER_PRINT"] = "0"
import numpy as np
import taichi as ti

problem = Problem()
ti.init(arch=ti.cpu, cpu_max_num_threads=problem.threads, default_fp=ti.f64, log_level=ti.ERROR)
D, DT, INV, H, V = problem.dim, problem.dt, 1 / problem.spacing, problem.spacing, problem.volume
FIRST, LAST = problem.first, problem.last
positions = problem.positions()
count = len(positions)
grid = (problem.nodes,) * D

vectors = lambda shape: ti.Vector.field(D, ti.f64, shape)
matrices = lambda shape: ti.Matrix.field(D, D, ti.f64, shape)
x, v, mass = vectors(count), vectors(count), ti.field(ti.f64, grid)
x.from_numpy(positions)


@ti.func
def held(I, velocity):
    for d in ti.static(range(D)):
        if I[d] <= FIRST or (ti.static(d < D - 1) and I[d] >= LAST):
            velocity[d] = 0.0
    return velocity


def linear():
    stress, volume, old, new = matrices(count), ti.field(ti.f64, count), vectors(grid), vectors(grid)
    volume.fill(V)
    corners = tuple(np.ndindex(*(2,) * D))

    @ti.func
    def place(p):
        base = ti.floor(x[p] * INV).cast(int)
        return base, x[p] * INV - base.cast(ti.f64)

    @ti.func
    def weight(f, corner: ti.template()):
        value = 1.0
        gradient = ti.Vector([INV] * D)
        for d in ti.static(range(D)):
            w = f[d] if ti.static(corner[d] == 1) else 1 - f[d]
            value *= w
            for e in ti.static(range(D)):
                gradient[e] *= (1.0 if ti.static(corner[d] == 1) else -1.0) if ti.static(e == d) else w
        return value, gradient

    @ti.kernel
    def scatter():
        for I in ti.grouped(mass):
            mass[I] = 0
            old[I] = ti.Vector.zero(ti.f64, D)
            new[I] = ti.Vector.zero(ti.f64, D)
        for p in x:
            base, f = place(p)
            m = DENSITY * V
            for corner in ti.static(corners):
                w, gradient = weight(f, corner)
                I = base + ti.Vector(corner)
                mass[I] += w * m
                old[I] += w * m * v[p]
                new[I] += -volume[p] * stress[p] @ gradient

    @ti.kernel
    def advance():
        for I in ti.grouped(mass):
            if mass[I] > 0:
                before = old[I] / mass[I]
                after = before + DT * new[I] / mass[I]
                after[D - 1] += DT * GRAVITY
                old[I], new[I] = held(I, before), held(I, after)

    @ti.kernel
    def gather():
        for p in x:
            base, f = place(p)
            change, velocity, L = ti.Vector.zero(ti.f64, D), ti.Vector.zero(ti.f64, D), ti.Matrix.zero(ti.f64, D, D)
            for corner in ti.static(corners):
                w, gradient = weight(f, corner)
                u = new[base + ti.Vector(corner)]
                change += w * (u - old[base + ti.Vector(corner)])
                velocity += w * u
                L += u.outer_product(gradient)
            x[p] += DT * velocity
            v[p] += change
            stress[p] += DT * (LAME * L.trace() * ti.Matrix.identity(ti.f64, D) + SHEAR * (L + L.transpose()))
            volume[p] *= 1 + DT * L.trace()

    return (scatter, advance, gather), lambda: float(stress.to_numpy()[:, D - 1, D - 1].mean())


def quadratic():
    C, F, velocities = matrices(count), matrices(count), vectors(grid)
    F.from_numpy(np.tile(np.eye(D), (count, 1, 1)))
    stencil = tuple(np.ndindex(*(3,) * D))

    @ti.func
    def place(p):
        base = ti.floor(x[p] * INV - 0.5).cast(int)
        f = x[p] * INV - base.cast(ti.f64)
        return base, f, [0.5 * (1.5 - f) ** 2, 0.75 - (f - 1) ** 2, 0.5 * (f - 0.5) ** 2]

    @ti.kernel
    def scatter():
        for I in ti.grouped(mass):
            mass[I] = 0
            velocities[I] = ti.Vector.zero(ti.f64, D)
        for p in x:
            base, f, w = place(p)
            F[p] = F[p] + DT * C[p] @ F[p]
            kirchhoff = SHEAR * F[p] @ F[p].transpose()
            kirchhoff += (LAME * ti.log(F[p].determinant()) - SHEAR) * ti.Matrix.identity(ti.f64, D)
            affine = -DT * V * 4 * INV * INV * kirchhoff + DENSITY * V * C[p]
            for node in ti.static(stencil):
                t = 1.0
                for d in ti.static(range(D)):
                    t *= w[node[d]][d]
                I = base + ti.Vector(node)
                mass[I] += t * DENSITY * V
                velocities[I] += t * (DENSITY * V * v[p] + affine @ ((ti.Vector(node).cast(ti.f64) - f) * H))

    @ti.kernel
    def advance():
        for I in ti.grouped(mass):
            if mass[I] > 0:
                velocity = velocities[I] / mass[I]
                velocity[D - 1] += DT * GRAVITY
                velocities[I] = held(I, velocity)

    @ti.kernel
    def gather():
        for p in x:
            base, f, w = place(p)
            velocity, B = ti.Vector.zero(ti.f64, D), ti.Matrix.zero(ti.f64, D, D)
            for node in ti.static(stencil):
                t = 1.0
                for d in ti.static(range(D)):
                    t *= w[node[d]][d]
                u = t * velocities[base + ti.Vector(node)]
                velocity += u
                B += u.outer_product(ti.Vector(node).cast(ti.f64) - f)
            v[p] = velocity
            C[p] = 4 * INV * B
            x[p] += DT * velocity

    return (scatter, advance, gather), lambda: None


def main():
    passes, stress = (linear if problem.arguments.shape == "linear" else quadratic)()
    version = ".".join(map(str, ti.__version__))
    check = lambda: (float(v.to_numpy()[:, D - 1].mean()), stress())
    problem.measure("taichi " + version, count, lambda: [one() for one in passes], check, ti.sync)


main()
