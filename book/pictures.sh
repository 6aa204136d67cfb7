#!/usr/bin/env bash
# Draws the book's pictures with the program itself: runs the cases and copies their figures into book/src/pictures.
# Usage: book/pictures.sh [TSUTSUMI [MY_LAW]], the paths of the two commands; without them cargo builds and runs both.
# It takes about a minute.
set -euo pipefail

absolute() { (cd "$(dirname "$1")" && printf '%s/%s' "$PWD" "$(basename "$1")"); }
tsutsumi=(cargo run --quiet --)
my_law=(cargo run --quiet -p my-law --)
if [ $# -ge 1 ]; then tsutsumi=("$(absolute "$1")"); fi
if [ $# -ge 2 ]; then my_law=("$(absolute "$2")"); fi

cd "$(dirname "$0")/.."
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT
mkdir -p book/src/pictures

# picture RUN FIGURE NAME
picture() { cp "$results/$1/figures/$2.svg" "book/src/pictures/$3.svg"; }

# The study's variant mpm1 is the paper's case as it stands.
"${tsutsumi[@]}" study paper-cases/poroelastic-column/study.toml --out "$results/paper" --quiet > "$results/table"
for figure in figure-3 figure-4 figure-5; do picture paper "$figure" "paper-$figure"; done
for figure in settlement pressure particles-peak; do picture paper/runs/mpm1 "$figure" "column-$figure"; done

"${tsutsumi[@]}" study book/cases/spacing.toml --out "$results/spacing" --quiet > "$results/table"
picture spacing convergence spacing-convergence

"${tsutsumi[@]}" run book/cases/half-loaded.toml --out "$results/half-loaded" --quiet
picture half-loaded particles half-loaded-particles

"${my_law[@]}" run examples/my-law/case.toml --out "$results/my-law" --quiet
for figure in settlement pressure particles-peak; do picture my-law "$figure" "my-law-$figure"; done
