#!/usr/bin/env bash
# Diagnoses the worlds of another hand and scores the answers with that hand's own scorer.
#
#   ./scripts/other-hand.sh FOLDER OUT [SEED [NUMBER]]
#
# FOLDER holds make_worlds.py and score.py (Python 3 with numpy and numba, which this installs from
# PyPI into .tools/ where they are absent). OUT gets worlds/, answers/, labels.json and scores.json;
# an answer that is there already is kept. The posterior that answers never saw that hand. The last lines are the row of this hand, in the columns of the blind
# check's table (`cargo xtask blind-check`).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

fail() {
  printf 'other-hand: %s\n' "$*" >&2
  exit 1
}
[ $# -ge 2 ] || fail "usage: $0 FOLDER OUT [SEED [NUMBER]]"
folder=$1 out=$2 seed=${3:-20251} number=${4:-}
for file in make_worlds.py score.py; do
  [ -f "$folder/$file" ] || fail "there is no $folder/$file"
done

python=python3
if ! "$python" -c 'import numpy, numba' 2>/dev/null; then
  python=.tools/numeric/bin/python
  if ! "$python" -c 'import numpy, numba' 2>/dev/null; then
    printf 'other-hand: installing numpy and numba from PyPI into .tools/numeric\n'
    python3 -m venv .tools/numeric
    .tools/numeric/bin/pip install --quiet --disable-pip-version-check numpy numba
  fi
fi

mkdir -p "$out"
if [ ! -f "$out/labels.json" ]; then
  "$python" "$folder/make_worlds.py" --out "$out/worlds" --labels "$out/labels.json" \
    --seed "$seed" ${number:+--n "$number"}
fi

cargo build --quiet --locked --package xtask
diagnose=$(cargo metadata --format-version 1 --no-deps |
  "$python" -c 'import json, sys; print(json.load(sys.stdin)["target_directory"])')/debug/xtask
for cohort in "$out"/worlds/*/; do
  name=$(basename "$cohort")
  [ -f "$out/answers/$name/diagnosis.json" ] && continue
  "$diagnose" diagnose --quiet --posterior crates/pipeline/posterior/without-another.safetensors --cohort "$cohort" --out "$out/answers/$name" ||
    printf 'other-hand: no answer to %s, which counts as wrong\n' "$name"
done

"$python" "$folder/score.py" --cohorts "$out/worlds" --labels "$out/labels.json" \
  --answers "$out/answers" --out "$out/scores.json"
"$python" - "$out/scores.json" <<'PYTHON'
import json, sys

scores = json.load(open(sys.argv[1]))
single, null, outside = scores["single"], scores["null"]["false_positive"], scores["out_of_library"]
rows = scores["rows"]


def share(counted):
    if not counted or not counted["n"]:
        return "-"
    return f"{counted['rate']:.2f} ({counted['k']}/{counted['n']})"


def of_size(size):
    sized = [row for row in rows if row["kind"] == "single" and row["size"] >= size]
    named = sum(row["right"] for row in sized)
    return f"{named / len(sized):.2f} ({named}/{len(sized)})" if sized else "-"


figure = lambda value: "-" if value is None else f"{value:.2f}"
columns = {
    "hand": "another's",
    "worlds": str(scores["cohorts"]),
    "named": share(single["top1"]),
    "not hard": share(single["top1_not_hard"]),
    "from 5": of_size(5),
    "from 10": of_size(10),
    "another": share(single["wrong_name"]),
    "alarms": share(null["any"]),
    "with name": share(null["named"]),
    "unknown": share(outside["unknown_recall"]),
    "its port": share(outside["port_given_unknown"]),
    "misnamed": share(outside["named_wrongly"]),
    "pairs F1": figure(scores["pair"]["f1"]),
    "calibration": figure(scores["calibration"]["ece"]),
    "where": share(scores["where"]["top3_hit"]),
    "by chance": figure(scores["where"]["chance"]),
}
widths = {name: max(len(name), len(value)) for name, value in columns.items()}
print("  ".join(name.rjust(widths[name]) for name in columns))
print("  ".join(value.rjust(widths[name]) for name, value in columns.items()))
PYTHON
