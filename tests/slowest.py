#!/usr/bin/env python3
"""slowest.py [BUILD] [--most N]: what the last run of the tests took, and which cases did not run.

BUILD: a build folder, build/dev unless given. Cases of GoogleTest programs by their own clocks (tests/times/*.xml), all
else as ctest measured it.
"""
import argparse
import pathlib
import xml.etree.ElementTree

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument("build", type=pathlib.Path, nargs="?", default=pathlib.Path("build/dev"))
parser.add_argument("--most", type=int, default=30, metavar="N", help="rows")
arguments = parser.parse_args()

rows, skipped, programs = [], [], set()
for file in sorted((arguments.build / "tests/times").glob("*.xml")):
    programs.add(file.stem)
    for case in xml.etree.ElementTree.parse(file).iter("testcase"):
        name = f"{case.get('classname')}.{case.get('name')}"
        if (reason := case.find("skipped")) is not None:
            skipped.append(f"{name}: {reason.get('message', '').strip().splitlines()[-1]}")
        rows.append((float(case.get("time", 0)), name, file.stem))
    # What a suite sets up for all of its cases.
    for suite in xml.etree.ElementTree.parse(file).iter("testsuite"):
        own = float(suite.get("time", 0)) - sum(float(case.get("time", 0)) for case in suite.iter("testcase"))
        rows.append((own, f"{suite.get('name')}, set up", file.stem))
for line in (arguments.build / "Testing/Temporary/CTestCostData.txt").read_text().split("---")[0].splitlines():
    name, _, seconds = line.split()
    if name not in programs:
        rows.append((float(seconds), name, "ctest"))
rows.sort(reverse=True)
print(f"| case | s | process |\n| --- | --- | --- |   all: {sum(row[0] for row in rows):.0f} s in {len(rows)} rows")
for seconds, name, process in rows[: arguments.most]:
    print(f"| {name} | {seconds:.2f} | {process} |")
print("\n".join(["not run:"] + sorted(set(skipped))) if skipped else "none was skipped")
