#!/usr/bin/env bash
# Draws the book's pictures with the program itself: runs the cases and studies and copies their figures into book/src/pictures,
# their tables into book/tables.
# Usage: book/pictures.sh [TSUTSUMI [MY_LAW]], the paths of the two commands; without them cargo builds and runs both.
# It takes some five minutes.
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

# study FILE NAME: runs a study and keeps its table
study() {
  "${tsutsumi[@]}" study "$1" --out "$results/$2" --quiet > "$results/table"
  cp "$results/$2/table.md" "book/tables/$2.md"
}
mkdir -p book/tables
study book/cases/spacing.toml spacing
picture spacing convergence spacing-convergence
study paper-cases/strip-load/study.toml strip-load
picture strip-load strip-load strip-load
study paper-cases/strip-load/study-slow.toml strip-load-slow
study paper-cases/mandel/study.toml mandel
picture mandel mandel mandel
study paper-cases/cryer/study.toml cryer
picture cryer cryer cryer
study paper-cases/saturated-column-waves/step-study.toml wave
picture wave step wave
study paper-cases/saturated-column-waves/harmonic-study.toml harmonic
study paper-cases/pressure-noise/study.toml pressure-noise
for figure in cell stabilised; do picture pressure-noise "$figure" "noise-$figure"; done
study paper-cases/xie-leo/study.toml xie-leo
picture xie-leo xie-leo xie-leo
# Failing runs are results of this one: some variants do not stand some problems.
"${tsutsumi[@]}" study paper-cases/variants/study.toml --out "$results/variants" --quiet > "$results/table" || true
cp "$results/variants/table.md" book/tables/variants.md
for figure in carried heavy-column; do picture variants "$figure" "variants-$figure"; done

"${tsutsumi[@]}" study paper-cases/liquefaction/study.toml --out "$results/liquefaction" --quiet > "$results/table"
picture liquefaction settlement liquefaction-settlement
for figure in pressure-ratio isochrones; do picture liquefaction/runs/sanisand "$figure" "liquefaction-$figure"; done

"${tsutsumi[@]}" run book/cases/half-loaded.toml --out "$results/half-loaded" --quiet
picture half-loaded particles half-loaded-particles

"${tsutsumi[@]}" run paper-cases/slump/case.toml --set method.particle_pressure=gradient --out "$results/slump" --quiet
picture slump particles slump

# element_test NAME FIGURE PICTURE [FIGURE PICTURE]...: runs an element test and keeps pictures of it
element_test() {
  local test=$1
  "${tsutsumi[@]}" element-test "element-tests/$test.toml" --out "$results/$test" --quiet > "$results/table"
  shift
  while [ $# -ge 2 ]; do
    picture "$test" "$1" "$2"
    shift 2
  done
}
element_test oedometer-hencky oedometer oedometer-hencky
element_test oka-cyclic-shear shear-stress-strain oka-stress-strain shear-stress-path oka-stress-path resistance oka-resistance
element_test sanisand-shear shear-stress-strain sanisand-stress-strain shear-stress-path sanisand-stress-path \
  resistance sanisand-resistance
element_test cam-clay-undrained stress-path cam-clay-stress-path
element_test cam-clay-isotropic compression cam-clay-isotropic
element_test pressure-elastic-isotropic pressure pressure-elastic-isotropic
element_test newtonian-shear-rates shear-stress-strain newtonian-shear-rates
element_test bingham-shear-rates shear-stress-strain bingham-shear-rates
element_test mu-i-shear-rates shear-stress-strain mu-i-shear-rates
element_test von-mises-cyclic-shear shear-stress-strain von-mises-shear
element_test drucker-prager-softening stress-strain drucker-prager-softening
element_test mohr-coulomb-drained stress-strain mohr-coulomb-drained
element_test pm4sand-shear path pm4sand-path loops pm4sand-loops

"${tsutsumi[@]}" calibrate element-tests/calibration/calibration.toml --out "$results/calibration" --quiet > "$results/table"
picture calibration oedometer calibration-oedometer

"${my_law[@]}" run examples/my-law/case.toml --out "$results/my-law" --quiet
for figure in settlement pressure particles-peak; do picture my-law "$figure" "my-law-$figure"; done
