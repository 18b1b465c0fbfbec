#!/usr/bin/env bash
# Runs the tests of the kernels on Oclgrind, an interpreter of OpenCL that reports races between work-items, accesses
# out of bounds and wrong calls of the API.
#   tests/oclgrind/run.sh [-j JOBS] [-t SECONDS] [-o FOLDER] [FILTER]
# FILTER is one of GoogleTest's (default *). Each test is a process of its own and has SECONDS (default 45). FOLDER
# (default build/oclgrind/run) keeps a log of each test and the table as table.txt; tests that ask for explicit
# vectors are "no vectors": the interpreter has none. Exit code 1 when a test failed, something was reported, or, of
# all tests, a kernel was run by none that passed. Needs build/dev (./run test) and, on Debian, apt-get and dpkg:
# Oclgrind is unpacked beside the build, so that the machine gets no further OpenCL device.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."
jobs="$(nproc)" seconds=45 out=build/oclgrind/run
while getopts j:t:o: option; do
  case "$option" in
    j) jobs="$OPTARG" ;;
    t) seconds="$OPTARG" ;;
    o) out="$OPTARG" ;;
    *) exit 2 ;;
  esac
done
shift $((OPTIND - 1))
filter="${1:-*}"

root="$PWD/build/oclgrind/root"
if [[ ! -e $root/usr/bin/oclgrind ]]; then
  mkdir -p build/oclgrind/packages
  (cd build/oclgrind/packages && apt-get download oclgrind liboclgrind-21.10)
  for package in build/oclgrind/packages/*.deb; do dpkg -x "$package" "$root"; done
fi
mkdir -p build/oclgrind/vendors "$out"
echo "$root/usr/lib/oclgrind/liboclgrind-rt-icd.so" > build/oclgrind/vendors/oclgrind.icd
libraries="$(dirname "$(find "$root" -name 'liboclgrind-21.10.so*' | head -n 1)")"
export LD_LIBRARY_PATH="$libraries" OCLGRIND_PCH_DIR="$libraries/oclgrind/21.10" OCL_ICD_VENDORS="$PWD/build/oclgrind/vendors/"
# Kernels as they are written: what a compiler takes away can't be reported. The interpreter can't inline calls.
export OCLGRIND_BUILD_OPTIONS="-cl-opt-disable -D SIMULI_KEEP_CALLS" OCLGRIND_DATA_RACES=1 OCLGRIND_CHECK_API=1
export OCLGRIND_INST_COUNTS=1  # names the kernels that are run
export seconds out

run_test() { # run_test PROGRAM TEST: one line of the table
  local log="$out/${2//\//_}.log" start end what
  rm -f "$log.reports" "$log.kernels"
  start="$(date +%s.%N)"
  local code=0
  OCLGRIND_LOG="$log.reports" timeout "$seconds" "build/dev/bin/$1" --gtest_filter="$2" > "$log" 2>&1 || code=$?
  end="$(date +%s.%N)"
  if [[ -s $log.reports ]]; then what=reported
  elif ((code == 124)); then what="out of time"
  elif grep -q 'Undefined external function: llvm.vector.reduce' "$log"; then what="no vectors"
  elif ((code != 0)); then what=failed
  elif grep -q '^\[  SKIPPED \]' "$log"; then what=skipped
  else what=passed
  fi
  if [[ $what == passed ]]; then
    sed -n "s/^Instructions executed for kernel '\(.*\)':$/\1/p" "$log" | sort -u > "$log.kernels"
  fi
  printf '%-12s %7.1f  %s %s\n' "$what" "$(echo "$end - $start" | bc)" "$1" "$2"
}
export -f run_test

for program in simuli_cl_tests simuli_render_tests simuli_scene_tests; do
  "build/dev/bin/$program" --gtest_filter="$filter" --gtest_list_tests | awk -v program="$program" '
    /^[^ ].*\.$/ { suite = $1 } /^  / { print program, suite $1 }'
done | xargs -P "$jobs" -L 1 bash -c 'run_test "$@"' run_test | tee "$out/table.txt"
awk '
  match($0, / +[0-9.]+  /) {
    what = substr($0, 1, RSTART - 1); sub(/ +$/, "", what)
    count[what]++; seconds += substr($0, RSTART, RLENGTH)
  }
  END { printf "%d tests in %.0f s:", NR, seconds; for (what in count) printf " %d %s", count[what], what; print "" }
' "$out/table.txt" | tee -a "$out/table.txt"

sed -n 's/^__kernel .*void \([a-z_0-9]*\)(.*/\1/p' cl/kernels/*.cl | sort -u > "$out/kernels.txt"
find "$out" -name '*.log.kernels' -exec cat {} + | sort -u | comm -23 "$out/kernels.txt" - > "$out/kernels_not_run.txt"
echo "$(wc -l < "$out/kernels.txt") kernels, run by no test that passed: $(paste -sd ' ' "$out/kernels_not_run.txt")" |
  tee -a "$out/table.txt"
if [[ $filter == "*" && -s $out/kernels_not_run.txt ]]; then exit 1; fi
! grep -q -E '^(reported|failed)' "$out/table.txt"
