#!/usr/bin/env bash
# Checks a report for people who read it by screen reader, keyboard, phone or in the dark.
#
#   ./scripts/axe.sh REPORT.html
#
# Runs axe-core and some checks of its own in headless Chromium at 400, 800 and 1,200 px, light and dark; prints
# what is violated and ends with status 1 if anything is. Needs node, npm, chromium (or CHROMIUM=path) and the network:
# axe-core and puppeteer-core come from npm into a temporary folder. No part of CI, whose browser tests
# (crates/report/tests/report/browser.rs) need no network.
set -euo pipefail

fail() {
  printf 'axe: %s\n' "$*" >&2
  exit 2
}
[ $# -eq 1 ] || fail "usage: $0 REPORT.html"
[ -f "$1" ] || fail "there is no file '$1'"
for program in node npm; do
  command -v "$program" >/dev/null 2>&1 || fail "$program is not on the path"
done
browser=${CHROMIUM:-$(command -v chromium || command -v chromium-browser || command -v google-chrome || true)}
[ -n "$browser" ] || fail "chromium is not on the path; CHROMIUM=path says where it is"

report=$(realpath "$1")
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
tools=$(mktemp -d)
trap 'rm -rf "$tools"' EXIT
npm install --prefix "$tools" --no-audit --no-fund --loglevel error axe-core@4 puppeteer-core@24 >&2
# Modules are looked for beside the script that asks for them.
cp "$here/axe.mjs" "$tools/axe.mjs"
node "$tools/axe.mjs" "$report" "$browser"
