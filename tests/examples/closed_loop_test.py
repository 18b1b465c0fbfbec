"""closed_loop_test.py PROGRAM EXAMPLES WORK: the example drives through a small street, and brakes for what stands in its way."""
import pathlib
import re
import subprocess
import sys
import time

program, examples, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])


def run(*arguments):
    return subprocess.run([str(a) for a in arguments], cwd=work, check=True, capture_output=True, text=True).stdout


def drive(address, folder, *more):
    """(slowest speed, farthest off the path) of a drive."""
    out = run(sys.executable, examples / "closed_loop.py", address, "-o", folder, "--lidar", "top", *more)
    rows = re.findall(r"^ *(\d+) +([\d.]+) m/s +([\d.]+) m off", out, re.M)
    pictures = sorted((work / folder).glob("*.png"))
    assert len(rows) == len(pictures) > 5, out
    assert all(p.read_bytes().startswith(b"\x89PNG") for p in pictures)
    assert len({p.read_bytes() for p in pictures}) == len(pictures), "pictures of a moving car are alike"
    return min(float(r[1]) for r in rows), max(float(r[2]) for r in rows)


run(program, "synth", "street", "-o", "s.log", "--frames", 20, "--image-width", 96, "--image-height", 54, "--lidar-columns", 180)
run(program, "train", "s.log", "-o", "s.scene", "--iterations", 30)
server = subprocess.Popen([program, "serve", "s.scene", "--port", "0"], cwd=work, stdout=subprocess.PIPE, text=True)
try:
    address = server.stdout.readline().strip()
    free, left = drive(address, "free", "--obstacle", "0")
    assert free > 2.0, free  # for the car that drives there
    assert left > 0.4, left
    braked, _ = drive(address, "braked")
    assert braked < 0.6 * free, (braked, free)
    kept, none = drive(address, "kept", "--left", "0", "--obstacle", "0")
    assert none < 0.1, none
finally:
    server.terminate()
    began = time.monotonic()
    assert server.wait(timeout=60) == 0, server.returncode
    assert time.monotonic() - began < 30
print("closed loop: ok")
