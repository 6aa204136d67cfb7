"""The paper's column with OpenSees: 20 quadUP elements, 10 m high, drained and loaded by a ramp of 50 kPa in 1000 s at its top.

    python column_opensees.py --steps 20000 --repeats 5

The steps are made by OpenSees itself, not one by one from Python. Everything is linear, and so is the solution algorithm: one solve per step.
"""

import argparse
import ctypes
import importlib.util
import json
import statistics
import time
from pathlib import Path

STEP, ELEMENTS, HEIGHT = 5e-4, 20, 10.0
YOUNG, POISSON, DENSITY = 4.35e6, 0.45, 1.5e3
BULK, POROSITY, CONDUCTIVITY, UNIT_WEIGHT, FLUID_DENSITY = 2.2e9, 0.4, 5.52e-5, 9800.0, 1e3
LOAD, RAMP = 50e3, 1e3


def opensees():
    """The package brings libraries along that the loader does not find by itself."""
    folder = Path(importlib.util.find_spec("openseespylinux").origin).parent / "lib"
    for name in ["libquadmath.so.0", "libgfortran.so.4", "libgomp.so.1", "libblas.so.3", "liblapack.so.3"]:
        ctypes.CDLL(str(folder / name), mode=ctypes.RTLD_GLOBAL)
    import openseespy.opensees as ops

    return ops


def build(ops, system):
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for row in range(ELEMENTS + 1):
        for side in range(2):
            node = 2 * row + side + 1
            ops.node(node, float(side), row * HEIGHT / ELEMENTS)
            # Rollers at base and sides, no pressure at the top.
            ops.fix(node, 1, int(row == 0), int(row == ELEMENTS))
    ops.nDMaterial("ElasticIsotropic", 1, YOUNG, POISSON, DENSITY)
    mobility = CONDUCTIVITY / UNIT_WEIGHT
    for row in range(ELEMENTS):
        first = 2 * row + 1
        nodes = [first, first + 1, first + 3, first + 2]
        ops.element("quadUP", row + 1, *nodes, 1.0, 1, BULK / POROSITY, FLUID_DENSITY, mobility, mobility, 0.0, 0.0, 0.0)
    ops.timeSeries("Path", 1, "-time", 0.0, RAMP, 1e9, "-values", 0.0, 1.0, 1.0)
    ops.pattern("Plain", 1, 1)
    for node in (2 * ELEMENTS + 1, 2 * ELEMENTS + 2):
        ops.load(node, 0.0, -0.5 * LOAD, 0.0)
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system(system)
    ops.algorithm("Linear")
    ops.integrator("Newmark", 0.6, 0.3025)
    ops.analysis("Transient")


def advance(ops, steps, step):
    if ops.analyze(steps, step) != 0:
        raise SystemExit("OpenSees failed")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--system", default="BandGeneral")
    options = parser.parse_args()
    ops = opensees()
    # At the end of loading, in long steps: it is the right problem.
    build(ops, options.system)
    advance(ops, 1000, 1.0)
    settlement, pressure = -ops.nodeDisp(2 * ELEMENTS + 1, 2), ops.nodeVel(1, 3)
    build(ops, options.system)
    advance(ops, 5, STEP)
    seconds = []
    for _ in range(options.repeats):
        start = time.perf_counter()
        advance(ops, options.steps, STEP)
        seconds.append(time.perf_counter() - start)
    print(json.dumps({
        "tool": "OpenSees " + ops.version(),
        "us_per_step": 1e6 * statistics.median(seconds) / options.steps,
        "check": {"settlement": settlement, "base_pressure": pressure},
    }))


main()
