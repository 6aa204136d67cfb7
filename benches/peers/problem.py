"""The block of ground that every program steps, and the line of JSON that it prints about it.

The unit square or cube in n cells per axis, 2 particles per axis and cell, cell by cell, 3 empty cells all round; rollers on base and sides and on
the nodes beyond them, gravity put on at once. It is the block of `benches/src/block.rs`.
"""

import argparse
import json
import statistics
import time

import numpy as np

PADDING = 3
DENSITY, YOUNG, POISSON, GRAVITY = 1000.0, 1e7, 0.3, -9.81
LAME = YOUNG * POISSON / ((1 + POISSON) * (1 - 2 * POISSON))
SHEAR = YOUNG / (2 * (1 + POISSON))
WARM = 5


class Problem:
    def __init__(self):
        parser = argparse.ArgumentParser()
        parser.add_argument("--dim", type=int, default=2, choices=(2, 3))
        parser.add_argument("--particles", type=int, default=100_000)
        parser.add_argument("--shape", default="linear", choices=("linear", "bspline2"))
        parser.add_argument("--threads", type=int, default=1)
        parser.add_argument("--steps", type=int, default=100)
        parser.add_argument("--repeats", type=int, default=3)
        self.arguments = parser.parse_args()
        self.dim, self.threads = self.arguments.dim, self.arguments.threads
        self.cells = max(2, round((self.arguments.particles / 2**self.dim) ** (1 / self.dim)))
        self.spacing = 1 / self.cells
        self.nodes = self.cells + 2 * PADDING + 1
        self.first, self.last = PADDING, PADDING + self.cells
        self.dt = 0.2 * self.spacing / ((LAME + 2 * SHEAR) / DENSITY) ** 0.5
        self.volume = (0.5 * self.spacing) ** self.dim

    def positions(self):
        axes = [np.arange(self.cells)] * self.dim
        cells = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, 1, self.dim)
        places = np.stack(np.meshgrid(*[[0.25, 0.75]] * self.dim, indexing="ij"), -1).reshape(1, -1, self.dim)
        return ((cells + places + PADDING) * self.spacing).reshape(-1, self.dim)

    def measure(self, tool, count, step, check, finish=lambda: None):
        """Times `step`; `check` gives the mean velocity (m/s) and stress (Pa) along the last axis, or None where it has no such stress."""
        for _ in range(WARM):
            step()
        finish()
        seconds, before = [], time.process_time()
        for _ in range(self.arguments.repeats):
            start = time.perf_counter()
            for _ in range(self.arguments.steps):
                step()
            finish()
            seconds.append(time.perf_counter() - start)
        cpu = time.process_time() - before
        velocity, stress = check()
        steps, repeats = self.arguments.steps, self.arguments.repeats
        print(json.dumps({
            "tool": tool, "dim": self.dim, "shape": self.arguments.shape, "threads": self.threads, "particles": count,
            "particle_steps_per_s": count * steps / statistics.median(seconds),
            "particle_steps_per_cpu_s": count * steps * repeats / cpu,
            "check": {"total_steps": WARM + repeats * steps, "mean_v": velocity, "probe": stress},
        }))
