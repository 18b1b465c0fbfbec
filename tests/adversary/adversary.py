#!/usr/bin/env python3
"""Tries what an adversary, a full disk or a power cut would do to a built `simuli`, and tells what did not hold.

adversary.py PROGRAM [--only CASE...] [--quick] [--tries N] [--seed N] [--list] [--json FILE]

Each case works in a temporary folder of its own and starts servers on loopback alone. With the rights of root
disks are small file systems in a mount namespace of their own; else their end is a limit on the size of files.
Exit code 1: something did not hold.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import signal
import sys
import tempfile
import time
import traceback
from pathlib import Path

import disks  # noqa: F401  the cases register themselves
import hostile  # noqa: F401
import interruptions  # noqa: F401
import kernel_caches  # noqa: F401
import numbers_given  # noqa: F401
import readers  # noqa: F401
import surroundings  # noqa: F401
import viewer  # noqa: F401
import viewer_requests  # noqa: F401
from harness import CASES, SMALL, STARTED, STREET, Entry, Options, Result, Skip, Trial

SHOWN_FAILURES = 5


def make_street(options: Options, scratch: Path) -> Path:
    """A log and a scene that all cases begin with."""
    trial = Trial(options, scratch, "street", Path())
    trial.works(*STREET, "-o", "s.log")
    trial.works("train", "s.log", "-o", "s.scene", "--iterations", "20", *SMALL)
    return trial.folder


def try_case(entry: Entry, options: Options, scratch: Path, street: Path) -> Result:
    began = time.monotonic()
    trial = Trial(options, scratch, entry.name, street)
    try:
        entry.run(trial)
    except Skip as skip:
        trial.result.skipped = str(skip)
    except Exception:  # whatever it is, the other cases are tried
        trial.check(False, traceback.format_exc())
    trial.result.seconds = time.monotonic() - began
    return trial.result


def row(name: str, result: Result) -> str:
    tries, failed = result.tries, len(result.failures)
    text = f"| {name} | {tries} | {tries - failed} | "
    if result.skipped:
        text += "not run: " + result.skipped
    elif failed:
        text += result.failures[0].strip().splitlines()[-1]
    text += ", ".join(f"{key} {value:.4g}" for key, value in result.figures.items())
    return text + f" | {result.seconds:.0f} |"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=Path, nargs="?")
    parser.add_argument("--only", nargs="+", default=[], metavar="CASE", choices=sorted(CASES))
    parser.add_argument("--quick", action="store_true", help="the short cases alone, with few tries")
    parser.add_argument("--tries", type=int, default=3, help="of what is random, per case")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--list", action="store_true", help="names of the cases")
    parser.add_argument("--json", type=Path, metavar="FILE", help="writes the table there, too")
    arguments = parser.parse_args()
    chosen = [CASES[name] for name in arguments.only] or [e for e in CASES.values() if e.quick or not arguments.quick]
    if arguments.list:
        for entry in CASES.values():
            print(entry.name, "(quick)" if entry.quick else "")
        return 0
    if arguments.program is None or not os.access(arguments.program, os.X_OK):
        parser.error(f"PROGRAM: found {arguments.program}, allowed a built simuli")
    options = Options(arguments.program.resolve(), arguments.tries, arguments.seed, arguments.quick)
    # In memory where that can be: every file is synced, which a busy disk takes seconds for.
    memory = "/dev/shm" if os.access("/dev/shm", os.W_OK) and "TMPDIR" not in os.environ else None
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))  # and clear up
    scratch = Path(tempfile.mkdtemp(prefix="simuli_adversary_", dir=memory))
    results: dict[str, Result] = {}
    try:
        street = make_street(options, scratch)
        print("| case | tries | held | what failed | s |\n| --- | --- | --- | --- | --- |", flush=True)
        for entry in chosen:
            result = results[entry.name] = try_case(entry, options, scratch, street)
            print(row(entry.name, result), flush=True)
            for failure in result.failures[:SHOWN_FAILURES]:
                print(f"{entry.name}: {failure}", file=sys.stderr)
            shutil.rmtree(scratch / entry.name, ignore_errors=True)
    finally:
        for process in STARTED:
            if process.poll() is None:
                process.kill()
                process.wait()
        shutil.rmtree(scratch, ignore_errors=True)
    if arguments.json:
        arguments.json.write_text(json.dumps({name: vars(r) for name, r in results.items()}, indent=1))
    tries = sum(r.tries for r in results.values())
    failed = sum(len(r.failures) for r in results.values())
    print(f"\n{len(results)} cases, {tries} tries, {tries - failed} held")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
