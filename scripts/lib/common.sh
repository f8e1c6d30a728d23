# shellcheck shell=bash
# Functions that the scripts share. This file is sourced and never run.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)

say() { printf '\n== %s\n' "$*"; }

die() {
  printf '%s: %s\n' "$(basename "$0")" "$*" >&2
  exit 2
}

# packages_of GROUP...: prints names from packages.txt.
packages_of() {
  local groups=" $* "
  while read -r name group _; do
    case "$name" in '' | '#'*) continue ;; esac
    case "$groups" in *" $group "*) printf '%s\n' "$name" ;; esac
  done <"$root/scripts/packages.txt"
}

missing_packages() {
  local name
  for name in $(packages_of "$@"); do
    dpkg-query -W -f='${Status}' "$name" 2>/dev/null | grep -q '^install ok installed$' || printf '%s\n' "$name"
  done
}

# install_packages GROUP...: installs missing packages; calls apt only if some are missing.
install_packages() {
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    say "no apt on this machine: expecting the counterparts of $(packages_of "$@" | paste -sd' ') to be there"
    return
  fi
  local missing as_root=()
  missing=$(missing_packages "$@" | paste -sd' ')
  if [ -z "$missing" ]; then
    say "packages: all installed"
    return
  fi
  if [ "$(id -u)" != 0 ]; then
    command -v sudo >/dev/null || die "these packages are missing, and there is neither root nor sudo: $missing"
    as_root=(sudo)
  fi
  say "packages: installing $missing"
  export DEBIAN_FRONTEND=noninteractive
  "${as_root[@]}" apt-get update -qq </dev/null || die "apt-get update failed"
  # shellcheck disable=SC2086  # a list of words
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $missing </dev/null ||
    die "apt-get install failed"
}

# A compiler cache is used if there is one; it is not required. With this sloppiness it also stores what is compiled with
# a precompiled header.
use_compiler_cache() {
  if command -v ccache >/dev/null; then
    export CCACHE_SLOPPINESS="${CCACHE_SLOPPINESS:+$CCACHE_SLOPPINESS,}pch_defines,time_macros"
    export CMAKE_C_COMPILER_LAUNCHER=ccache CMAKE_CXX_COMPILER_LAUNCHER=ccache
  fi
}

# configure PRESET [cmake arguments]: prints nothing unless it fails.
configure() {
  local preset=$1 log
  shift
  mkdir -p "$root/build"
  log="$root/build/configure-$preset.log"
  if ! (cd "$root" && cmake --preset "$preset" "$@") >"$log" 2>&1; then
    cat "$log"
    return 1
  fi
}

# build PRESET [targets]: shows progress on a terminal, and only problems in a pipe.
build() {
  local preset=$1 quiet=()
  shift
  [ -t 1 ] || quiet=(-- --quiet)
  (cd "$root" && cmake --build --preset "$preset" ${1:+--target "$@"} "${quiet[@]}")
}
