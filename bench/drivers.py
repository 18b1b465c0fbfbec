#!/usr/bin/env python3
"""Runs the same tests, times and pictures on several OpenCL implementations and prints one table.

  bench/drivers.py BIN --driver NAME VENDORS [COMMAND] [--driver ...] [--rounds N] [--filter F] [--only PART ...]

BIN      folder of the built programs (build/dev/bin)
NAME     name of the implementation in the table; pictures are compared with the first implementation
VENDORS  folder of .icd files, as for OCL_ICD_VENDORS; "-" for the system's folder
COMMAND  words before each program, in one argument: "env LD_PRELOAD=libtbb.so.12", "chroot FOLDER", "oclgrind"

Oclgrind 21.10 cannot inline: "env OCLGRIND_DATA_RACES=1 'OCLGRIND_BUILD_OPTIONS=-cl-opt-disable -D SIMULI_KEEP_CALLS'",
with --only tests and a --filter of small tests (bench/RESULTS.md). Its reports are in the .err files of the work folder.

Parts: check (simuli devices --check), tests (the tests that run kernels; --filter as --gtest_filter), pictures
(simuli bench --agreement) and times (simuli bench --stages, N rounds, the implementations in turns within each).
Compiled programs are cached in a folder per implementation in --work, so a second run takes less time; the seconds of
tests include compilation in the first run. Exit code 1 on any failure.
"""
import argparse
import json
import os
import pathlib
import resource
import shlex
import statistics
import subprocess
import sys
import tempfile

TESTS = ("simuli_runtime_tests", "simuli_cl_tests")
PARTS = ("check", "tests", "pictures", "times")
CAMERA = "stages/camera_640x360_200k/"
LIDAR = "stages/lidar_64x2650_200k/"


def processor_s():
    """Returns the CPU time of all finished child programs, which other load hardly affects."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


class Driver:
    def __init__(self, words, bin_folder, work):
        if not 2 <= len(words) <= 3:
            sys.exit(f"drivers.py: --driver: found {len(words)} words, allowed NAME VENDORS [COMMAND]")
        self.name, vendors = words[0], words[1]
        self.command = shlex.split(words[2]) if len(words) == 3 else []
        self.bin, self.work = bin_folder, work / self.name
        (self.work / "pocl").mkdir(parents=True, exist_ok=True)
        self.env = dict(os.environ, SIMULI_CACHE_DIR=str(self.work / "programs"), POCL_CACHE_DIR=str(self.work / "pocl"))
        if vendors != "-":
            self.env["OCL_ICD_VENDORS"] = str(pathlib.Path(vendors).resolve())
        self.limit_s = None  # maximum seconds of a program
        self.row = {"driver": self.name}
        self.failures = []

    def run(self, program, *arguments, shard=None):
        """Returns exit code and standard output; both output streams are also written to the work folder. shard: index and
        number of shards of the program's tests."""
        command = [*self.command, str(self.bin / program), *arguments]
        name = f"{program}.{shard[0]}" if shard else program
        env = dict(self.env, GTEST_SHARD_INDEX=str(shard[0]), GTEST_TOTAL_SHARDS=str(shard[1])) if shard else self.env
        out, err = self.work / f"{name}.out", self.work / f"{name}.err"
        with open(out, "w") as out_file, open(err, "w") as err_file:
            try:
                code = subprocess.run(command, env=env, stdout=out_file, stderr=err_file, check=False,
                                      timeout=self.limit_s).returncode
            except subprocess.TimeoutExpired:
                code = 124
        if code != 0:
            last = (err.read_text().strip() or out.read_text().strip()).splitlines()[-1:] or [""]
            self.failures.append(f"{program} {' '.join(arguments)}: exit code {code}: {last[0]}")
        return code, out.read_text(errors="replace")

    def rows(self, *arguments):
        code, out = self.run("simuli", "bench", "--json", *arguments)
        return {row["name"]: row["value"] for row in json.loads(out)} if code == 0 else {}

    def check(self):
        code, out = self.run("simuli", "devices", "--check", "--json")
        if code != 0 and not out.startswith("["):
            return
        device = json.loads(out)[0]
        self.row["version"] = f"{device['platform']}, {device['driver_version']}"
        self.row["check"] = device.get("check", "not usable").split(";")[0]

    def tests(self, test_filter):
        passed = failed = 0
        worst = {}
        begin = processor_s()
        for program in TESTS:
            report = self.work / f"{program}.json"
            report.unlink(missing_ok=True)
            self.run(program, f"--gtest_output=json:{report}", f"--gtest_filter={test_filter}")
            if not report.exists():  # crashed
                failed += 1
                continue
            for suite in json.loads(report.read_text())["testsuites"]:
                for test in suite["testsuite"]:
                    if test.get("failures"):
                        failed += 1
                        self.failures.append(f"{program}: {suite['name']}.{test['name']}")
                    elif test["result"] == "COMPLETED":
                        passed += 1
                    precision = "double" if "_double_" in test["name"] else "float"
                    for key, value in test.items():
                        if key.startswith("worst_"):
                            worst[key, precision] = max(worst.get((key, precision), 0.0), float(value))
        self.row["passed, failed"] = f"{passed}, {failed}"
        self.row["processor s"] = f"{processor_s() - begin:.0f}"
        if worst:
            self.row["worst error, float: of 1; mm"] = "{:.2g}; {:.2g}".format(
                worst["worst_transmittance", "float"], worst["worst_distance", "float"] * 1e3)

    def pictures(self, reference):
        rows = self.rows("--agreement", str(reference))
        if rows:
            a = "agreement/"
            self.row["camera, float: other rays, PSNR dB"] = "{:.2%}, {:.0f}".format(
                rows[a + "camera_float/rays_of_other_bits"], rows[a + "camera_float/psnr"])
            self.row["LiDAR, float: other rays, p99 mm, largest m"] = "{:.2%}, {:.3f}, {:.2g}".format(
                rows[a + "lidar_float/rays_of_other_bits"],
                rows[a + "lidar_float/range_p99"] * 1e3,
                rows[a + "lidar_float/range_largest"])
            if a + "camera_double/psnr" in rows:
                self.row["double: PSNR dB, largest m"] = "{:.0f}, {:.2g}".format(
                    rows[a + "camera_double/psnr"], rows[a + "lidar_double/range_largest"])


def measure_times(drivers, rounds, frames):
    samples = {driver.name: [] for driver in drivers}
    for _ in range(rounds):
        for driver in drivers:
            rows = driver.rows("--stages", "--frames", str(frames))
            if rows:
                samples[driver.name].append(rows)
    for driver in drivers:
        found = samples[driver.name]
        if not found:
            continue
        for column, sensor in (("camera", CAMERA), ("LiDAR", LIDAR)):
            for label, stage in (("frame", "frame"), ("blend", "blend"), ("scalar blend", "blend_one_ray_per_item")):
                median = statistics.median(rows[sensor + stage] for rows in found)
                driver.row[f"{column} {label}, ms"] = f"{median:.1f}"


def table(drivers):
    columns = list(dict.fromkeys(column for driver in drivers for column in driver.row))
    lines = ["| " + " | ".join(columns) + " |", "|" + " --- |" * len(columns)]
    lines += ["| " + " | ".join(driver.row.get(column, "") for column in columns) + " |" for driver in drivers]
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("--driver", nargs="+", action="append", required=True, metavar="NAME VENDORS [COMMAND]")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--frames", type=int, default=11)
    parser.add_argument("--filter", default="*")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--work", type=pathlib.Path, help="folder for compiled programs; default: a temporary one")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        work = (arguments.work or pathlib.Path(temporary)).resolve()
        drivers = [Driver(words, arguments.bin.resolve(), work) for words in arguments.driver]
        for driver in drivers:
            print(driver.name, file=sys.stderr, flush=True)
            if "check" in arguments.only:
                driver.check()
            if "tests" in arguments.only:
                driver.tests(arguments.filter)
            if "pictures" in arguments.only:
                driver.pictures(work / "pictures")
        if "times" in arguments.only:
            measure_times(drivers, arguments.rounds, arguments.frames)
        print(table(drivers))
        for driver in drivers:
            for failure in driver.failures:
                print(f"{driver.name}: {failure}")
        sys.exit(any(driver.failures for driver in drivers))


if __name__ == "__main__":
    main()
