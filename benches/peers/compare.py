#!/usr/bin/env python3
"""Steps one block of ground with this library and with other programs, in turns, and prints a Markdown table.

    python3 benches/peers/compare.py                 # numba and C
    python3 benches/peers/compare.py --taichi        # and Taichi
    python3 benches/peers/compare.py --opensees      # and the paper's column with OpenSees
    python3 benches/peers/compare.py --only "2-D"    # rows whose name holds the text
    python3 benches/peers/compare.py --smoke         # a block of a few particles: do all programs agree?

The Python programs are installed into target/peers. A ratio is taken within a round, in which every program runs once: what slows the machine down for a
while slows all of them down. The table has the median of the ratios, and the smallest and largest; "per core" is per second of processor time, which other
work on the machine disturbs less. It is measured on Linux only.
"""

import argparse
import json
import os
import platform
import statistics
import subprocess
import sys
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
BUILD = ROOT / "target" / "peers"
PACKAGES = {"numba": ["numba==0.68.*"], "taichi": ["taichi==1.7.*"], "opensees": ["openseespy==3.7.*"]}
C_FLAGS = ["-O3", "-march=native", "-ffast-math", "-fopenmp"]

LINEAR, SPLINE = ["--shape", "linear"], ["--shape", "bspline2", "--update", "apic"]
GIMP = ["--shape", "gimp"]
# Name, dimension, particles, steps, ours, the others'.
ROWS = [
    ("2-D linear, 100 k", 2, 100_000, 100, LINEAR, ["c", "c-by-cell", "numba", "taichi"]),
    ("2-D linear, 1 M", 2, 1_000_000, 15, LINEAR, ["c", "c-by-cell", "numba", "taichi"]),
    ("3-D linear, 1 M", 3, 1_000_000, 8, LINEAR, ["numba", "taichi"]),
    ("2-D bspline2 + APIC, 1 M", 2, 1_000_000, 8, SPLINE, ["numba", "taichi"]),
    ("3-D bspline2 + APIC, 1 M", 3, 1_000_000, 3, SPLINE, ["numba", "taichi"]),
    ("2-D GIMP, 1 M", 2, 1_000_000, 8, GIMP, ["tsutsumi-linear"]),
]
# The paper's column: name, our cells. OpenSees has 20 elements.
COLUMNS = [("paper's column, 10 cells", 10), ("column of 20 cells", 20)]
# By the clock, and by what the program had of the processors.
RATES = ["particle_steps_per_s", "particle_steps_per_cpu_s"]
NAMES = {"c": "C, particle by particle", "c-by-cell": "C, by cell", "tsutsumi-linear": "ours, linear"}


def output(command, **options):
    done = subprocess.run([str(part) for part in command], stdout=subprocess.PIPE, text=True, cwd=ROOT, **options)
    if done.returncode != 0:
        sys.exit(f"failed: {' '.join(str(part) for part in command)}")
    return done.stdout


def prepare(tools):
    """Builds our program, those in C, and an environment with the Python packages."""
    BUILD.mkdir(parents=True, exist_ok=True)
    output(["cargo", "build", "--release", "--quiet", "-p", "tsutsumi-benches", "--bin", "throughput", "--bin", "column"])
    for name in ["block", "block_by_cell", "triad"]:
        output(["cc", *C_FLAGS, HERE / f"{name}.c", "-o", BUILD / name, "-lm"])
    python = BUILD / "venv" / "bin" / "python"
    if not python.exists():
        venv.create(BUILD / "venv", with_pip=True)
    wanted = [package for tool in tools for package in PACKAGES[tool]]
    output([python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", *wanted])
    return python


def targets():
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))


def command(tool, python, row, threads, rounds_of):
    _, dimension, particles, steps, ours, _ = row
    target = targets()
    size = ["--dim", dimension, "--particles", particles, "--threads", threads, "--steps", steps, "--repeats", rounds_of]
    if tool == "tsutsumi":
        return [target / "release" / "throughput", *size, *ours]
    if tool == "tsutsumi-linear":
        return [target / "release" / "throughput", *size, *LINEAR]
    if tool in ("c", "c-by-cell"):
        return [BUILD / {"c": "block", "c-by-cell": "block_by_cell"}[tool], particles, steps, rounds_of]
    return [python, HERE / f"block_{tool}.py", *size, *ours[:2]]


def run(tool, python, row, threads):
    return said(command(tool, python, row, threads, 1))


def said(command):
    """What a program says of itself: its last line of JSON."""
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    lines = [line for line in output(command, env=environment).splitlines() if line.startswith("{")]
    return json.loads(lines[-1])


def agree(row, ours, theirs):
    """Linear shape functions: the programs do the same, but for round-off. With splines forces and law differ."""
    if row[4] is not LINEAR:
        return
    for quantity in ("mean_v", "probe"):
        a, b = ours["check"][quantity], theirs["check"][quantity]
        if abs(a - b) > 1e-10 * abs(b):
            sys.exit(f"{row[0]}: {quantity} is {a} here and {b} with {theirs['tool']}")


def bandwidth(threads, mebibytes):
    environment = {**os.environ, "OMP_NUM_THREADS": str(threads)}
    return json.loads(output([BUILD / "triad", mebibytes, 10], env=environment))["gb_per_s"]


def compare(row, threads, rounds, python, installed, speed):
    """The lines of the table for a row and a number of threads."""
    others = [tool for tool in row[5] if tool not in PACKAGES or tool in installed]
    if threads > 1:
        others = [tool for tool in others if not tool.startswith("c")]
    runs = {tool: [] for tool in ["tsutsumi", *others]}
    for number in range(rounds):
        ours = run("tsutsumi", python, row, threads)
        runs["tsutsumi"].append(ours)
        # Every other round backwards, so that no program is always the first after ours.
        for tool in others if number % 2 == 0 else others[::-1]:
            theirs = run(tool, python, row, threads)
            if tool != "tsutsumi-linear":
                agree(row, ours, theirs)
            runs[tool].append(theirs)
    wall, cpu = [median(runs["tsutsumi"], of) for of in RATES]
    cells = [row[0], threads, f"{wall / 1e6:.2f}", f"{cpu / 1e6:.2f}", f"{ours['bytes_per_particle']:.0f}"]
    cells.append(f"{100 * ours['bytes_per_step'] * wall / speed / 1e9:.0f} %")
    for tool in others:
        rates = " / ".join(f"{median(runs[tool], of) / 1e6:.2f}" for of in RATES)
        line = [*cells, NAMES.get(tool, tool), rates, *(ratio(runs["tsutsumi"], runs[tool], of) for of in RATES)]
        print("| " + " | ".join(str(cell) for cell in line) + " |", flush=True)
        # Our own numbers stand in the first line only.
        cells = [""] * len(cells)


def compare_columns(columns, rounds, steps, python):
    """The table of the paper's column beside OpenSees, one thread each."""
    print()
    print("| column | ours, µs per step | OpenSees, 20 quadUP elements | theirs / ours |")
    print("|---|---|---|---|")
    for name, cells in columns:
        ours, theirs = [], []
        for _ in range(rounds):
            ours.append(said([targets() / "release" / "column", "--cells", cells, "--steps", steps]))
            theirs.append(said([python, HERE / "column_opensees.py", "--steps", max(steps // 10, 1)]))
            a, b = [run["check"]["settlement"] for run in (ours[-1], theirs[-1])]
            # Large strains against small ones, and coarse cells: 0.4 to 0.5 % seen.
            if abs(a - b) > 0.01 * abs(b):
                sys.exit(f"{name}: the settlement is {a} m here and {b} m with OpenSees")
        of = "us_per_step"
        cells = [name, f"{median(ours, of):.2f}", f"{median(theirs, of):.0f}", ratio(theirs, ours, of)]
        print("| " + " | ".join(cells) + " |", flush=True)


def known(rate):
    return float("nan") if rate is None else rate


def median(runs, of):
    return statistics.median(known(run[of]) for run in runs)


def ratio(ours, theirs, of):
    ratios = [known(a[of]) / known(b[of]) for a, b in zip(ours, theirs)]
    return f"{statistics.median(ratios):.2f} ({min(ratios):.2f}–{max(ratios):.2f})"


def processor():
    try:
        models = [line for line in Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")]
        return models[0].split(":")[1].strip()
    except (OSError, IndexError):
        return platform.processor() or platform.machine()


def compare_blocks(rows, options, python, installed):
    speeds = {threads: bandwidth(threads, 512) for threads in options.threads}
    print("Bandwidth (triad): " + ", ".join(f"{speed:.1f} GB/s with {threads}" for threads, speed in speeds.items()))
    print()
    print("| block | threads | ours, M/s | per core | bytes per particle | of bandwidth | other | M/s / per core | ours / theirs | per core |")
    print("|" + "---|" * 10)
    for row in rows:
        for threads in options.threads:
            compare(row, threads, options.rounds, python, installed, speeds[threads])


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--taichi", action="store_true", help="compare with Taichi, too")
    parser.add_argument("--opensees", action="store_true", help="compare the paper's column with OpenSees, too")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--threads", type=int, nargs="+", default=[1, 4])
    parser.add_argument("--only", default="", help="rows whose name holds this text")
    parser.add_argument("--smoke", action="store_true", help="few particles, one round")
    options = parser.parse_args()
    installed = ["numba"] + ["taichi"] * options.taichi + ["opensees"] * options.opensees
    python = prepare(installed)
    columns = [column for column in COLUMNS if options.opensees and options.only in column[0]]
    rows = [row for row in ROWS if options.only in row[0]]
    if options.smoke:
        options.rounds = 1
        rows = [(name.split(",")[0] + ", smoke", dimension, 1000, 500, *rest) for name, dimension, _, _, *rest in rows]
    print(f"{processor()}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the start; {options.rounds} rounds")
    if rows:
        compare_blocks(rows, options, python, installed)
    if columns:
        compare_columns(columns, options.rounds, 200 if options.smoke else 20_000, python)


if __name__ == "__main__":
    main()
