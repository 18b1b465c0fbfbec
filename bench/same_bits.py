#!/usr/bin/env python3
"""Checks whether a program writes the same bits as another program or as before.

  bench/same_bits.py PROGRAM [--against PROGRAM_OR_JSON] [-o HASHES.json] [--only REGEX] [--work FOLDER] [--list]

Runs a list of commands with PROGRAM (simuli), each in an empty folder, and hashes all written files: logs, scenes,
pictures, clouds, reports. -o stores the hashes; --against compares with stored hashes, or with another program that runs
the same commands. Prints one line per command: same, DIFFERS (with files and keys, and whether the input already
differed), MISSING (failed, or wrote fewer files), new, skipped. Exit code 1 if anything differs or is missing. Names that
begin with "repaired/" belong to known defects: their differences are printed but are no failure.

Times, devices and dates are ignored: the date of EXR pictures and JSON keys with times. JSON files are compared by common
keys, other keys are listed; HTML reports by their pictures. Hashes are valid for one OpenCL device: the command "machine"
detects another device. Compiled programs and tuned tiles are not shared with other runs, so tiles are the default.
With SIMULI_DATA the commands on recorded data run, too.
"""
import argparse
import hashlib
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

from same_bits_commands import DATA, LONGEST_S, all_commands

NOT_COMPARED = re.compile(r"seconds|_per_s$|_ms$|^device$")  # JSON keys
RENAMED = {  # setting keys: old name -> new name
    "beside.weight": "off_trajectory.weight",
    "beside.reach_m": "off_trajectory.reach_m",
    "init.off_path_m": "init.off_trajectory_m",
    "stretch.length_m": "chunk.length_m",
    "look.least_share": "appearance.least_share",
    "actors.fill": "actors.inpaint",
    "render.max_instances": "render.max_pairs",
}
OLD_KEY = re.compile(r"(?<![\w.])(" + "|".join(map(re.escape, RENAMED)) + r")(?![\w.])")


class Failed(RuntimeError):
    """A failed command."""


class Run:
    """One command of one program, in its own folder."""

    def __init__(self, program, name):
        self.of, self.folder, self.inputs = program, program.folder_of(name), set()
        self.folder.mkdir()

    def resolve(self, text):
        """Replaces each {NAME} by the folder of that command, which runs first if necessary."""
        def folder(match):
            name = match.group(1)
            self.inputs.add(name)
            if isinstance(self.of.make(name), Failed):
                raise Failed(f"its input {name} is missing")
            return os.path.relpath(self.of.folder_of(name), self.folder)
        return re.sub(r"\{([^{}]+)\}", folder, text)

    def program(self, *arguments):
        """Runs the program and returns its standard output."""
        done = subprocess.run([self.of.path, *arguments], cwd=self.folder, env=self.of.env, capture_output=True,
                              timeout=LONGEST_S, check=False)
        if done.returncode != 0:
            last = done.stderr.decode(errors="replace").strip().splitlines()[-1:] or [""]
            raise Failed(f"exit code {done.returncode}: {last[0]}")
        return done.stdout

    def start(self, text):
        return subprocess.Popen([self.of.path, *shlex.split(self.resolve(text))], cwd=self.folder, env=self.of.env,
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)

    def copy(self, name, what):
        shutil.copytree(self.folder / self.resolve("{" + name + "}") / what, self.folder / what)

    def step(self, step):
        if callable(step):
            step(self)
            return
        text, _, output = step.partition(" > ")
        out = self.program(*shlex.split(self.resolve(text)))
        if output:
            (self.folder / output).write_bytes(out)


class Program:
    def __init__(self, path, root, commands):
        self.path, self.root, self.commands = str(pathlib.Path(path).resolve()), root, commands
        self.root.mkdir(parents=True)
        self.env = dict(os.environ, SIMULI_CACHE_DIR=str(root / "programs"))
        self.env.pop("SIMULI_CL_DIR", None)  # use the program's own kernels
        self.made, self.inputs = {}, {}

    def folder_of(self, name):
        return self.root / name.replace("/", ".")

    def make(self, name):
        """Returns {file: fingerprint} of a command, or its failure."""
        if name not in self.made:
            run = Run(self, name)
            try:
                for step in self.commands[name][0]:
                    run.step(step)
                files = sorted(file for file in run.folder.rglob("*") if file.is_file())
                self.made[name] = {str(file.relative_to(run.folder)): fingerprint(file) for file in files}
            except (RuntimeError, OSError, subprocess.TimeoutExpired, ValueError, KeyError) as error:
                self.made[name] = error if isinstance(error, Failed) else Failed(f"{type(error).__name__}: {error}")
            self.inputs[name] = run.inputs
        return self.made[name]


# Comparison of outputs.

def comparable(value):
    """A JSON value without times, with the new names of settings."""
    if isinstance(value, dict):
        return {with_new_names(key): comparable(item) for key, item in value.items() if not NOT_COMPARED.search(key)}
    if isinstance(value, list):
        return [comparable(item) for item in value]
    return with_new_names(value) if isinstance(value, str) else value


def with_new_names(text):
    return OLD_KEY.sub(lambda match: RENAMED[match.group(1)], text)


def fingerprint(file):
    """Returns the part of a file that must be equal: a hash, or for JSON the value."""
    content = file.read_bytes()
    if file.suffix == ".json":
        return {"json": comparable(json.loads(content))}
    if file.suffix == ".html":
        content = b"\n".join(re.findall(rb"base64,[^\"']*", content))
    if file.suffix == ".exr":
        content = re.sub(rb"(capDate\0string\0.{4}).{19}", rb"\1", content, count=1, flags=re.DOTALL)
    return hashlib.sha256(content).hexdigest()


def walk(before, now, place, different, unshared):
    """Adds the paths of differing JSON values, and paths in only one of the two."""
    if isinstance(before, dict) and isinstance(now, dict):
        for key in sorted(before.keys() | now.keys()):
            at = f"{place}.{key}" if place else key
            if key in before and key in now:
                walk(before[key], now[key], at, different, unshared)
            else:
                unshared.append(("lost " if key in before else "new ") + at)
    elif isinstance(before, list) and isinstance(now, list) and len(before) == len(now):
        for i, pair in enumerate(zip(before, now)):
            walk(*pair, f"{place}[{i}]", different, unshared)
    elif before != now:
        different.append(place)


def some(words):
    return ", ".join(words[:4]) + (f" and {len(words) - 4} more" if len(words) > 4 else "")


def compare(before, now):
    """Returns (status, message) for two results of one command."""
    if isinstance(now, Failed):
        return "MISSING", str(now)
    different, notes = [], [f"new file {file}" for file in now if file not in before]
    missing = [file for file in before if file not in now]
    for file in before.keys() & now.keys():
        if isinstance(before[file], dict) and isinstance(now[file], dict):
            keys, unshared = [], []
            walk(before[file]["json"], now[file]["json"], "", keys, unshared)
            notes += [f"{file}: {text}" for text in unshared]
            different += [f"{file}: {some(keys)}"] if keys else []
        elif before[file] != now[file]:
            different.append(file)
    told = some(sorted(different)) + (f" (not compared: {some(sorted(notes))})" if notes else "")
    if missing:
        return "MISSING", f"files {some(missing)}"
    return ("DIFFERS" if different else "same"), told


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", help="simuli")
    parser.add_argument("--against", help="another program, or hashes that -o wrote")
    parser.add_argument("-o", "--output", type=pathlib.Path, help="JSON file to write: command -> file -> hash")
    parser.add_argument("--only", default="", help="commands with matching names, and their inputs")
    parser.add_argument("--work", type=pathlib.Path, help="folder to write, which is kept; default: a temporary folder")
    parser.add_argument("--list", action="store_true", help="names alone, nothing is run")
    arguments = parser.parse_args()
    commands = all_commands()
    chosen = [name for name in commands if re.search(arguments.only, name)]
    if arguments.list:
        print("\n".join(chosen))
        return 0
    with tempfile.TemporaryDirectory() as temporary:
        work = (arguments.work or pathlib.Path(temporary) / "work").resolve()
        program = Program(arguments.program, work / "now", commands)
        kept, other = {}, None
        if arguments.against and arguments.against.endswith(".json"):
            kept = json.loads(pathlib.Path(arguments.against).read_text())
        elif arguments.against:
            other = Program(arguments.against, work / "before", commands)
        begin, counts, statuses = time.time(), {}, {}

        def tell(name, status, text=""):
            statuses[name] = status
            counts[status] = counts.get(status, 0) + 1
            print(f"{status:<9} {name:<34} {text}".rstrip(), flush=True)

        for name in chosen:
            if name.startswith("data/") and not DATA:
                tell(name, "skipped", "needs SIMULI_DATA")
                continue
            before, start = other.make(name) if other else kept.get(name), time.time()
            now, twin = program.make(name), commands[name][1]
            if isinstance(before, Failed):
                status, text = "MISSING", f"before: {before}"
            elif isinstance(now, Failed):
                status, text = "MISSING", str(now)
            elif before is None:
                status, text = ("new" if arguments.against else "made"), f"{len(now)} files, {time.time() - start:.1f} s"
            else:
                status, text = compare(before, now)
            if twin and status in ("same", "made", "new") and compare(program.make(twin), now)[0] != "same":
                status, text = "DIFFERS", f"from {twin}: {compare(program.make(twin), now)[1]}"
            changed = sorted(other_name for other_name in program.inputs[name] if statuses.get(other_name) == "DIFFERS")
            if status == "DIFFERS" and changed:
                text += f"; its input {some(changed)} differs already"
            if status == "DIFFERS" and name.startswith("repaired/"):
                status = "repaired"
            tell(name, status, text)
        for name in kept:
            if name not in commands and re.search(arguments.only, name):
                tell(name, "MISSING", "no such command any more")
        if arguments.output:
            made = {name: files for name, files in program.made.items() if name in chosen and not isinstance(files, Failed)}
            lines = [f"{json.dumps(name)}: {json.dumps(files, separators=(',', ':'))}" for name, files in made.items()]
            arguments.output.write_text("{\n" + ",\n".join(lines) + "\n}\n")
        print(", ".join(f"{count} {status}" for status, count in counts.items()) + f"; {time.time() - begin:.0f} s")
        return 1 if counts.get("DIFFERS") or counts.get("MISSING") else 0


if __name__ == "__main__":
    sys.exit(main())
