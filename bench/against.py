#!/usr/bin/env python3
"""Compares the times of this working tree with those of another commit, in turns on this machine.

  bench/against.py COMMIT [--rounds N] [--worse SHARE] [--work FOLDER] [-- BENCH_ARGUMENTS]

COMMIT   any git revision: a hash, a branch, HEAD~3
--rounds      runs of each of the two (7), one after the other; the order alternates between rounds
--worse       exit code 1 when a frame takes longer by more than this share, after its spread is subtracted (0.05)
--work        build folder of both (build/against); existing builds are updated
BENCH_ARGUMENTS  arguments of `simuli bench` of the complete program: "--training", "--stages --particles 1000000".
              Without arguments only the stages run, for which only the core is built, minutes faster.

Prints for each common number the median of COMMIT, the median of this tree, and the median and half the interquartile
range of their ratio per round. On shared machines the two runs of a round have similar load; tables of different days
do not.
"""
import argparse
import json
import os
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
LONGER_IS_WORSE = ("ms", "s")


def stop(message):
    sys.exit(f"against.py: {message}")


def sources_of(commit, work):
    """Returns the folder with the commit's files, unpacked once."""
    found = subprocess.run(["git", "-C", ROOT, "rev-parse", "--verify", "--quiet", f"{commit}^{{commit}}"],
                           capture_output=True, text=True)
    if found.returncode != 0:
        stop(f'COMMIT: found "{commit}", allowed a commit of {ROOT}')
    name = found.stdout.strip()[:12]
    folder = work / name / "source"
    if not (folder / "CMakeLists.txt").exists():
        folder.mkdir(parents=True, exist_ok=True)
        archive = subprocess.Popen(["git", "-C", ROOT, "archive", name], stdout=subprocess.PIPE)
        subprocess.run(["tar", "-x", "-C", folder], stdin=archive.stdout, check=True)
        if archive.wait() != 0:
            stop(f"git archive {name} failed")
    return folder


def build(source, folder, whole, log):
    """Builds the program and returns its command as words."""
    options = ["-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF", "-DSIMULI_BENCH=ON"]
    options.append("-DSIMULI_CORE_ONLY=" + ("OFF" if whole else "ON"))
    print(f"build {source} in {folder}", file=sys.stderr, flush=True)
    with open(log, "w") as out:
        for command in (["cmake", "-G", "Ninja", "-S", source, "-B", folder, *options],
                        ["cmake", "--build", folder, "--parallel", str(os.cpu_count())]):
            if subprocess.run(command, stdout=out, stderr=out).returncode != 0:
                stop(f"{source} could not be built: see {log}")
    return [folder / "bin" / "simuli", "bench"] if whole else [folder / "bin" / "simuli_bench"]


def rows_of(command, arguments):
    ran = subprocess.run([*command, "--json", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if ran.returncode != 0:
        stop(f"{command[0]}: exit code {ran.returncode}: {ran.stderr.strip().splitlines()[-1:]}")
    return {row["name"]: (row["value"], row["unit"]) for row in json.loads(ran.stdout) if row.get("value") is not None}


def half_quartiles(values):
    if len(values) < 2:
        return 0.0
    quarters = statistics.quantiles(values, n=4, method="inclusive")
    return 0.5 * (quarters[2] - quarters[0])


def main():
    parser = argparse.ArgumentParser(usage=__doc__.split("\n\n")[1].strip())
    parser.add_argument("commit")
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--worse", type=float, default=0.05)
    parser.add_argument("--work", type=pathlib.Path, default=ROOT / "build" / "against")
    mine, given = (sys.argv[1:], []) if "--" not in sys.argv else (
        sys.argv[1:sys.argv.index("--")], sys.argv[sys.argv.index("--") + 1:])
    wanted = parser.parse_args(mine)
    if wanted.rounds < 1:
        stop(f"--rounds: found {wanted.rounds}, allowed 1 or more")
    kind = "whole" if given else "core"
    wanted.work.mkdir(parents=True, exist_ok=True)
    source = sources_of(wanted.commit, wanted.work)
    before = build(source, source.parent / kind, bool(given), source.parent / f"{kind}.log")
    after = build(ROOT, wanted.work / "this" / kind, bool(given), wanted.work / f"this-{kind}.log")

    rounds = []
    for k in range(wanted.rounds):
        both = [("before", before), ("after", after)]
        made = {name: rows_of(command, given) for name, command in (both if k % 2 == 0 else reversed(both))}
        rounds.append((made["before"], made["after"]))
        print(f"round {k + 1} of {wanted.rounds}", file=sys.stderr, flush=True)

    print(f"{'':48} {wanted.commit[:12]:>12} {'this':>12} unit   {'ratio':>7}")
    slower = []
    for name, (_, unit) in rounds[0][1].items():
        pairs = [(a[name][0], b[name][0]) for a, b in rounds if name in a and name in b]
        if not pairs or not all(a > 0 for a, _ in pairs):
            continue
        ratios = [b / a for a, b in pairs]
        ratio, spread = statistics.median(ratios), half_quartiles(ratios)
        medians = [statistics.median(side) for side in zip(*pairs)]
        print(f"{name:48} {medians[0]:12.5g} {medians[1]:12.5g} {unit:6} {ratio:7.3f} +- {spread:.3f}")
        if unit in LONGER_IS_WORSE and name.endswith("/frame") and ratio - spread > 1.0 + wanted.worse:
            slower.append(name)
    if slower:
        stop(f"slower than {wanted.commit} by more than {wanted.worse:g}: {', '.join(slower)}")


if __name__ == "__main__":
    main()
