#!/usr/bin/env bash
# Makes the tables that a posterior is trained on, and trains it: the seeds of decision 0054.
#
#   ./scripts/posterior.sh OUT [FOLDER]
#
# FOLDER holds make_worlds.py of another hand (Python 3 with numpy and numba); without it that hand
# trains nothing. OUT gets tables/, another/ and posterior/; a table that is there already is kept, so
# a run that was ended goes on. The last lines say how the six files come into use.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

fail() {
  printf 'posterior: %s\n' "$*" >&2
  exit 1
}
[ $# -ge 1 ] && [ $# -le 2 ] || fail "usage: $0 OUT [FOLDER]"
out=$1 folder=${2:-}
[ -z "$folder" ] || [ -f "$folder/make_worlds.py" ] || fail "there is no $folder/make_worlds.py"

xtask() { cargo run --quiet --locked --package xtask -- "$@"; }
mkdir -p "$out/tables" "$out/another"

# Whether the table of a name is there, and that it belongs to the others.
tables=()
is_there() {
  tables+=(--table "$out/tables/$1")
  [ -f "$out/tables/$1/manifest.json" ]
}
# A table of our hands: its seed, and settings of `evidence`.
table() {
  is_there "$1" || xtask evidence --quiet --seed "$1" "${@:2}" --out "$out/tables/$1"
}

for seed in $(seq 101 128); do table "$seed" --worlds 251 --nulls 149; done
for seed in $(seq 201 208); do table "$seed" --worlds 251 --nulls 149 --narrow; done
# The worlds that the other hand can make of a seed: some ask for more real people than it has.
is_made='
import sys
sys.path.insert(0, sys.argv[1])
import make_worlds as hand
seed = int(sys.argv[2])
def is_made(row):
    try:
        return row["world"] != "W3" or bool(hand.build_people(row, seed))
    except IndexError:
        return False
print(",".join(row["id"] for row in hand.plan() if is_made(row)))
'
if [ -n "$folder" ]; then
  for seed in $(seq 30001 30014); do
    worlds=$out/another/$seed
    if [ ! -f "$worlds/labels.json" ]; then
      python3 "$folder/make_worlds.py" --out "$worlds/worlds" --labels "$worlds/labels.json" \
        --seed "$seed" --only "$(python3 -c "$is_made" "$folder" "$seed")" >/dev/null
    fi
    is_there "$seed" ||
      xtask evidence --quiet --labelled "$worlds" --seed "$seed" --out "$out/tables/$seed"
  done
fi

xtask train-posterior --quiet "${tables[@]}" --seed 1 --out "$out/posterior"
printf '%s\n' "cp $out/posterior/working.safetensors crates/gap/posterior/" \
  "cp $out/posterior/without-*.safetensors crates/pipeline/posterior/"
