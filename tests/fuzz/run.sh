#!/usr/bin/env bash
# Fuzzes the readers: builds them with clang and its sanitizers, runs each target and prints a table.
#   tests/fuzz/run.sh [-n EXECUTIONS] [-s SECONDS] [-o FOLDER] [TARGET...]
# A target ends after EXECUTIONS (default 100000) or SECONDS (default 600), whichever comes first. FOLDER
# (default build/fuzz/run) keeps each target's corpus and log, findings in FOLDER/found/TARGET, and the table as
# table.txt. Exit code 1 when something was found.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
executions=100000 seconds=600 out=build/fuzz/run
while getopts n:s:o: option; do
  case "$option" in
    n) executions="$OPTARG" ;;
    s) seconds="$OPTARG" ;;
    o) out="$OPTARG" ;;
    *) exit 2 ;;
  esac
done
shift $((OPTIND - 1))

cmake -G Ninja -B build/fuzz -DCMAKE_CXX_COMPILER=clang++ -DSIMULI_FUZZ=ON -DSIMULI_CALIBRATION=OFF \
  -DCMAKE_CXX_FLAGS_RELEASE="-O1 -gline-tables-only -DNDEBUG" > /dev/null
cmake --build build/fuzz --target fuzz --parallel "${JOBS:-$(nproc)}"
mkdir -p "$out"
out="$(realpath "$out")"
ASAN_SYMBOLIZER_PATH="$(command -v llvm-symbolizer llvm-symbolizer-14 | head -n 1 || true)"
export ASAN_SYMBOLIZER_PATH
# Where memory was allocated is told of findings that are run again without this; it costs a sixth of the time.
export ASAN_OPTIONS="malloc_context_size=1${ASAN_OPTIONS:+:$ASAN_OPTIONS}"

# Edges that the corpus reaches of the functions in the reader's own sources, in %; not of those that write;
# ways out of an exception are edges, too.
own_coverage() { # own_coverage PATTERN < log of -print_coverage=1
  awk -v pattern="$1" '
    /COVERED_FUNC:/ && match($0, pattern) && !/(to_json|[^m]_json|to_text|text_of|write_[a-z_]*|add_[a-z_]*|copy_[a-z_]*)(\[abi:cxx11\])?\(/ {
      for (i = 1; i < NF; ++i) if ($i == "edges:") { split($(i + 1), n, "/"); hit += n[1]; all += n[2] }
    }
    END { if (all) printf "%.0f %% of %d", 100 * hit / all, all; else printf "-" }'
}

row() { printf '%-16s %11s %12s %7s %9s %16s %9s\n' "$@"; }
row target executions "a second" edges features "own edges" findings | tee "$out/table.txt"
all_found=0 all_executions=0
while read -r target pattern; do
  if (($# > 0)) && [[ " $* " != *" $target "* ]]; then continue; fi
  corpus="$out/corpus/$target" found="$out/found/$target" log="$out/$target.log"
  mkdir -p "$corpus" "$found"
  seeds=("$PWD/tests/fuzz/seeds/$target")
  if [[ -d tests/fuzz/found/$target ]]; then seeds+=("$PWD/tests/fuzz/found/$target"); fi
  # Weighing inputs by how rare their features are takes two thirds of the time of readers with many (ncore).
  limits=(-timeout=10 -rss_limit_mb=2048 -malloc_limit_mb=1024 -entropic=0)
  build/fuzz/bin/fuzz_"$target" "$corpus" "${seeds[@]}" "${limits[@]}" -runs="$executions" \
    -max_total_time="$seconds" -artifact_prefix="$found/" -print_final_stats=1 -print_funcs=0 > "$log" 2>&1 || true
  build/fuzz/bin/fuzz_"$target" "$corpus" "${seeds[@]}" "${limits[@]}" -runs=0 -print_coverage=1 \
    > "$log.coverage" 2>&1 || true
  count="$(find "$found" -type f | wc -l)"
  stat() { sed -n "s/^stat::$1: *//p" "$log" | tail -n 1; }
  last() { sed -n "s/.* $1: \([0-9]*\).*/\1/p" "$log" | tail -n 1; }
  run="$(stat number_of_executed_units)"
  row "$target" "${run:-0}" "$(stat average_exec_per_sec)" "$(last cov)" "$(last ft)" \
    "$(own_coverage "$pattern" < "$log.coverage")" "$count" | tee -a "$out/table.txt"
  all_found=$((all_found + count)) all_executions=$((all_executions + ${run:-0}))
done < <(grep '^[a-z]' tests/fuzz/targets.txt)
row all "$all_executions" "" "" "" "" "$all_found" | tee -a "$out/table.txt"
((all_found == 0))
