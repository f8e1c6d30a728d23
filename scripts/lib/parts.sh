# shellcheck shell=bash
# Parts of scripts/test and .ci/nightly: each prints its time and its result, and counts its checks. Sourced, never
# run.

# shellcheck source=scripts/lib/common.sh
. "$(dirname "${BASH_SOURCE[0]}")/common.sh"

passed=0 failed=0 skipped=0
table=''
start=$SECONDS

# part NAME COMMAND...: runs the command and notes its time. A failure counts as one failed check unless the command
# counts its own.
part() {
  local name=$1 begin=$SECONDS before=$failed result=ok
  shift
  say "$name"
  if ! "$@"; then
    result=FAILED
    [ "$failed" -gt "$before" ] || failed=$((failed + 1))
  fi
  table+=$(printf '%-44s %5d s  %s' "$name" $((SECONDS - begin)) "$result")$'\n'
  [ "$result" = ok ]
}

finish() {
  say "time"
  printf '%s%-44s %5d s\n\n' "$table" total $((SECONDS - start))
  printf '%d passed, %d failed, %d skipped\n' "$passed" "$failed" "$skipped"
  [ "$failed" = 0 ]
  exit
}

# Lines of a ctest run that contain no new information.
# shellcheck disable=SC2317  # called by `part`
shorten() { if [ -t 1 ]; then cat; else grep -vE '^ *(Start +[0-9]+:|[0-9]+/[0-9]+ Test.* Passed )' || true; fi; }

# run_ctest PRESET [ctest arguments]: adds to the counts. Fails if a test failed or none ran.
# shellcheck disable=SC2317  # called by `part`
run_ctest() {
  local preset=$1 report="$root/build/$1/junit.xml" code counts
  shift
  rm -f "$report"
  (cd "$root/build/$preset" && ctest --output-on-failure --no-tests=error -j "$(nproc)" --output-junit "$report" "$@") |
    shorten
  code=${PIPESTATUS[0]}
  counts=$(python3 - "$report" <<'PYTHON'
import sys
import xml.etree.ElementTree as tree
suite = tree.parse(sys.argv[1]).getroot()
tests, failures, skipped = (int(suite.get(key, 0)) for key in ("tests", "failures", "skipped"))
skipped += int(suite.get("disabled", 0))
print(tests - failures - skipped, failures, skipped)
PYTHON
  ) || return 1
  read -r p f s <<<"$counts"
  passed=$((passed + p)) failed=$((failed + f)) skipped=$((skipped + s))
  return "$code"
}

# fuzz_one TARGET SECONDS: starts from the committed corpus; inputs that it finds are stored in build/asan/found/TARGET.
# shellcheck disable=SC2317  # called through `part`
fuzz_one() {
  local target=$1 seconds=$2 program="$root/build/asan/tests/fuzz/fuzz_$1" folder="$root/build/asan/found/$1" input
  local options=()
  # The bookkeeping of libFuzzer's entropic schedule would take half of the time. Meshes differ in their geometry more
  # than in the code that they reach, so that all inputs of the corpus are kept.
  [ "$target" = pipeline ] && options=(-entropic=0 -use_counters=0 -keep_seed=1)
  rm -rf "$folder"
  mkdir -p "$folder/corpus"
  if "$program" -seed=1 -max_total_time="$seconds" -max_len=1024 -len_control=0 -timeout=60 -rss_limit_mb=4096 \
    -malloc_limit_mb=1000000 -print_final_stats=1 "${options[@]}" "-artifact_prefix=$folder/" "$folder/corpus" \
    "$root/tests/fuzz/corpus/$target" >"$folder/log" 2>&1; then
    printf '%s: %s runs, nothing found\n' "$target" "$(sed -n 's/^stat::number_of_executed_units: *//p' "$folder/log")"
    return
  fi
  tail -n 40 "$folder/log"
  input=$(find "$folder" -maxdepth 1 -type f ! -name log | head -n 1)
  printf 'fuzz_%s FAILED on %s\nto see it again: %s %s\n' "$target" "${input:-no input}" "$program" "${input:-}"
  return 1
}

# run_fuzzers SECONDS TARGET...: runs two targets at a time; each counts as one check.
# shellcheck disable=SC2317  # called by `part`
run_fuzzers() {
  local seconds=$1 jobs=() job good=0
  shift
  local all=$#
  while [ $# -gt 0 ]; do
    jobs=()
    for target in "${@:1:2}"; do
      fuzz_one "$target" "$seconds" &
      jobs+=($!)
    done
    for job in "${jobs[@]}"; do
      if wait "$job"; then good=$((good + 1)); fi
    done
    shift $(($# < 2 ? $# : 2))
  done
  passed=$((passed + good)) failed=$((failed + all - good))
  [ "$good" = "$all" ]
}
