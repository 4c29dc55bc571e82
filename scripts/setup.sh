#!/usr/bin/env bash
# Finds or installs what compiling HiGHS needs: a C++ compiler, cmake and libclang.
#
#   ./scripts/setup.sh           find, install what is missing, say what was done
#   ./scripts/setup.sh --check   only say what is missing; exit status 1 if anything is
#
# As root (or with a password-less sudo) the missing ones come from Debian's packages. Without root,
# cmake and libclang come from PyPI into .tools/ and .cargo/local.toml points cargo at them; a C++
# compiler cannot be had that way. Running it again changes nothing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

say() { printf 'setup: %s\n' "$*"; }
fail() {
  printf 'setup: %s\n' "$*" >&2
  exit 1
}

have_compiler() { command -v c++ >/dev/null 2>&1 || command -v g++ >/dev/null 2>&1; }
have_cmake() { .tools/python/bin/cmake --version >/dev/null 2>&1 || cmake --version >/dev/null 2>&1; }

# The folder of libclang.so, where bindgen would find it; empty if nowhere.
libclang_folder() {
  local candidate
  for candidate in "${LIBCLANG_PATH:-}" .tools/python/lib/python3*/site-packages/clang/native \
    /usr/lib/llvm-*/lib /usr/lib/*-linux-gnu /usr/lib64 /usr/lib /usr/local/lib; do
    [ -n "$candidate" ] || continue
    if [ -n "$(find -L "$candidate" -maxdepth 1 -type f \
      \( -name 'libclang.so*' -o -name 'libclang-[0-9]*.so*' \) 2>/dev/null | head -n 1)" ]; then
      printf '%s\n' "$candidate"
      return 0
    fi
  done
  return 1
}
have_libclang() { libclang_folder >/dev/null; }

missing() {
  have_compiler || printf 'compiler '
  have_cmake || printf 'cmake '
  have_libclang || printf 'libclang '
}

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi
}
can_be_root() {
  [ "$(id -u)" = 0 ] || { command -v sudo >/dev/null 2>&1 && sudo -n true 2>/dev/null; }
}

install_with_apt() {
  local packages=()
  have_compiler || packages+=(g++)
  have_cmake || packages+=(cmake)
  have_libclang || packages+=(libclang-dev)
  say "installing Debian packages: ${packages[*]}"
  as_root apt-get update -qq
  as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends "${packages[@]}" >/dev/null
}

install_with_pip() {
  have_compiler || fail "no C++ compiler and no root to install one; ask for the package g++, then run this again"
  command -v python3 >/dev/null 2>&1 || fail "no root and no python3; install cmake and libclang by hand, then run this again"
  say "no root: installing cmake and libclang from PyPI into .tools/python"
  mkdir -p .tools
  python3 -m venv .tools/python 2>/dev/null || {
    # Debian splits ensurepip into python3-venv; --target needs neither.
    rm -rf .tools/python
    fail "python3 cannot make a virtual environment; install the package python3-venv, then run this again"
  }
  .tools/python/bin/pip install --quiet --disable-pip-version-check cmake libclang
  local headers
  headers=$(cc -print-file-name=include 2>/dev/null || gcc -print-file-name=include)
  cat >.cargo/local.toml <<TOML
# Written by scripts/setup.sh. Delete this file and .tools/ to go back to the system's cmake and libclang.
[env]
CMAKE = { value = "$PWD/.tools/python/bin/cmake" }
LIBCLANG_PATH = { value = "$(cd "$(libclang_folder)" && pwd)" }
BINDGEN_EXTRA_CLANG_ARGS = { value = "-I$headers" }
TOML
  say "wrote .cargo/local.toml"
}

command -v cargo >/dev/null 2>&1 || fail "no cargo; install Rust from your distribution or rustup first"

lacking=$(missing)
if [ "${1:-}" = --check ]; then
  [ -z "$lacking" ] && { say "nothing is missing"; exit 0; }
  fail "missing: $lacking"
fi
if [ -n "$lacking" ]; then
  say "missing: $lacking"
  if command -v apt-get >/dev/null 2>&1 && can_be_root; then install_with_apt; else install_with_pip; fi
fi
lacking=$(missing)
[ -z "$lacking" ] || fail "still missing after the installation: $lacking"
say "C++ compiler, cmake and libclang are there (libclang in $(libclang_folder))"
