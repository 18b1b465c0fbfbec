"""tutorial_test.py SIMULI SOURCE WORK MODULE PYTHON [--full]: docs/TUTORIAL.md as a new user goes through it.

Its commands in their order, in an empty folder, on a street of a few pixels; --full: as they stand there, for the page's
table, which is printed. MODULE: the folder that has the Python module, or "". PYTHON: for examples/closed_loop.py; without
grpcio there, or with a program that can't serve, or without MODULE, what needs it is left out by name.
"""
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import time

simuli, source, work = (pathlib.Path(text).resolve() for text in sys.argv[1:4])
module, python = sys.argv[4:6]
full = "--full" in sys.argv
page = source / "docs/TUTORIAL.md"
sys.path.insert(0, str(source / "docs"))
from pages import commands_of  # noqa: E402

NOT_DETERMINED = 6
SMALL = "--frames 14 --image-width 96 --image-height 54 --lidar-columns 300"
took = []


def smaller(command):
    """The command as this test runs it."""
    if full:
        return command
    command = re.sub(r"^(simuli synth street)", rf"\1 {SMALL}", command)
    return re.sub(r"--iterations \d+", "--iterations 30", command)


def processor_s():
    """Of all commands that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run(command, environment=None):
    """What it prints. A mounting that halves of the drive do not agree on is refused, as the page says."""
    print("+", command, flush=True)
    began, used = time.monotonic(), processor_s()
    done = subprocess.run(command, shell=True, cwd=work, env=environment, capture_output=True, text=True)
    took.append((time.monotonic() - began, processor_s() - used, command))
    if done.returncode not in ((0, NOT_DETERMINED) if "align" in command and "--camera" in command else (0,)):
        sys.exit(f"{page.name}: {command}\nends with {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def serving(command):
    """(the server, its address) of a command line with a port, here any free one."""
    server = subprocess.Popen(re.sub(r"--port \d+", "--port 0", command).replace("simuli", str(simuli), 1).split(),
                              cwd=work, stdout=subprocess.PIPE, text=True)
    address = server.stdout.readline().strip()
    assert address.startswith("127.0.0.1:"), f"{command}: {server.wait(timeout=60)}"
    return server, address


def pictures(folder):
    return [file.read_bytes() for file in sorted((work / folder).glob("*.png"))]


def has(*words):
    return subprocess.run(words, capture_output=True).returncode == 0


shutil.rmtree(work, ignore_errors=True)
(work / "bin").mkdir(parents=True)
(work / "bin/simuli").symlink_to(simuli)
(work / "bin/python3").write_text(f'#!/bin/sh\nexec "{python}" "$@"\n')  # no link: it may be of a virtual environment
(work / "bin/python3").chmod(0o755)
os.environ.update(PATH=f"{work / 'bin'}:{os.environ['PATH']}", EXAMPLES=str(source / "examples"))
left_out = {}
if not module:
    left_out["edited.scene"] = "SIMULI_PYTHON is off"
if "not in this build" in subprocess.run([simuli, "serve", "--help"], capture_output=True, text=True).stdout:
    left_out["simuli serve"] = "this program can't serve"
if not has(python, "-c", "import grpc, grpc_tools, numpy"):
    left_out["closed_loop.py"] = f"{python} has not all of grpc, grpc_tools, numpy"

kept = re.search(r"^```python\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)[1]
said, server, address = {}, None, None
try:
    for line in commands_of(page):
        why = next((f"{what}: {because}" for what, because in left_out.items() if what in line), None)
        if why or ("closed_loop.py" in line and server is None):
            print(f"not run: {line} ({why or 'nothing serves'})")
            continue
        if line.startswith("simuli serve"):
            server, address = serving(line)
            continue
        said[line] = run(smaller(re.sub(r"127\.0\.0\.1:\d+", str(address), line)))
        if "-o edited.mcap" in line and module:
            (work / "keep.py").write_text(kept)
            run(f"{sys.executable} keep.py", {**os.environ, "PYTHONPATH": module})
finally:
    if server is not None:
        server.terminate()
        assert server.wait(timeout=60) == 0, server.returncode

# What the page says of what they made.
assert "moving_0" in said["simuli info drive.scene"], said
plain = pictures("pictures")
assert len(plain) == 6
for folder in ("without", "moved", "twins", "with_cone"):
    assert any(a != b for a, b in zip(plain, pictures(folder), strict=True)), f"{folder}: nothing has changed"
if (work / "braked").exists():
    slowest = {folder: min(float(v) for v in re.findall(r" ([\d.]+) m/s", out))
               for line, out in said.items() for folder in ("free", "braked") if line.endswith(f"-o {folder}")}
    assert slowest["braked"] < 0.6 * slowest["free"], slowest
print("  wall s  processor s")
for seconds, used, command in [*took, (sum(t[0] for t in took), sum(t[1] for t in took), "together")]:
    print(f"{seconds:8.1f}  {used:11.1f}  {command}")
