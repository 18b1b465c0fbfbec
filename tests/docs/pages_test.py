"""pages_test.py SIMULI SOURCE PAGE WORK: the commands of a page run, on a street of a few pixels.

Its sensors and its actor stand for those of the pages' drives. What asks for a drive of KITTI's or PandaSet's, or for what is made of one, is not here:
such a command must end with the exit code of an input that can't be read, not with that of a wrong usage.
"""
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import zlib

simuli, source, work = (pathlib.Path(text).resolve() for text in (sys.argv[1], sys.argv[2], sys.argv[4]))
page = sys.argv[3]
sys.path.insert(0, str(source / "docs"))
from pages import commands_of  # noqa: E402

INPUT_ERROR, NOT_DETERMINED = 3, 6
SMALL = "--image-width 64 --image-height 36 --lidar-columns 90"
ABSENT = ("2011_09_26", "pandaset/002", "raw.log")
STAND_FOR = {"image_02": "front", "held-out-sensor left": "held-out-sensor top", "velodyne": "top", "car_0": "car", "moving_0": "car"}


def run(command, *allowed):
    print("+", command, flush=True)
    done = subprocess.run(command, shell=True, cwd=work, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if done.returncode not in (allowed or (0,)):
        sys.exit(f"{page}: {command}\nends with {done.returncode}, not {allowed or 0}: {done.stderr.strip()}")


def turned(q):
    """The matrix of a quaternion w, x, y, z."""
    w, x, y, z = q
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]


def photographs():
    """The street's pictures as nerfstudio and COLMAP describe such, from a camera that drives along x."""
    images = sorted((work / "drive.log/images").glob("*.png"))
    lens = json.loads(subprocess.run([simuli, "info", work / "drive.log", "front", "--json"], check=True,
                                     capture_output=True).stdout)
    shutil.copytree(work / "drive.log/images", work / "photos/images")
    frames, lines = [], []
    for i, file in enumerate(images):
        x = 0.8 * i
        right, back, up = (0, -1, 0), (-1, 0, 0), (0, 0, 1)
        matrix = [[right[r], up[r], back[r], (x, -1.75, 1.5)[r]] for r in range(3)] + [[0, 0, 0, 1]]
        frames.append({"file_path": f"images/{file.name}", "transform_matrix": matrix})
        # World to camera of the same pose, as COLMAP has it; camera z is world x.
        rows = turned((0.5, 0.5, -0.5, 0.5))
        centre = (x, -1.75, 1.5)
        moved = [-sum(row[c] * centre[c] for c in range(3)) for row in rows]
        lines += [f"{i + 1} 0.5 0.5 -0.5 0.5 {moved[0]} {moved[1]} {moved[2]} 1 {file.name}", ""]
    (work / "photos/transforms.json").write_text(json.dumps(
        {"w": lens["width_px"], "h": lens["height_px"], "fl_x": lens["fx_px"], "fl_y": lens["fy_px"],
         "cx": lens["cx_px"], "cy": lens["cy_px"], "camera_model": "OPENCV", "frames": frames}))
    model = work / "model"
    model.mkdir()
    (model / "cameras.txt").write_text(
        f"1 PINHOLE {lens['width_px']} {lens['height_px']} {lens['fx_px']} {lens['fy_px']} {lens['cx_px']} {lens['cy_px']}\n")
    (model / "images.txt").write_text("\n".join(lines) + "\n")
    (model / "points3D.txt").write_text("")


def hood():
    """A picture of 64 x 36 pixels, white in its lowest rows."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
    rows = b"".join(b"\0" + bytes([255 if y > 30 else 0] * 64) for y in range(36))
    header = struct.pack(">IIBBBBB", 64, 36, 8, 0, 0, 0, 0)
    (work / "hood.png").write_bytes(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) +
                                    chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


def prepare():
    shutil.rmtree(work, ignore_errors=True)
    (work / "bin").mkdir(parents=True)
    (work / "bin/simuli").symlink_to(simuli)
    os.environ["PATH"] = f"{work / 'bin'}:{os.environ['PATH']}"
    os.environ["EXAMPLES"] = str(source / "examples")
    (work / "demo").mkdir()
    run(f"simuli synth street -o demo/street.log {SMALL}")
    run("simuli train demo/street.log -o demo/street.scene --iterations 2")
    (work / "drive.log").symlink_to("demo/street.log")
    for name in ("drive.scene", "street.scene"):
        (work / name).symlink_to("demo/street.scene")
    run("python3 $EXAMPLES/write_splats.py object.ply && simuli export object.ply -o biker.spz")
    (work / "rig.json").write_text(json.dumps({"format": "simuli rig", "version": 1, "sensors": [
        {"name": "roof", "sensor": "velodyne_vlp16", "mount": {"position_m": [0, 0, 1.9]}}, {"name": "ahead", "sensor": "front"}]}))
    photographs()
    hood()
    run("simuli render drive.scene -o drive.mcap && simuli info drive.log top --json > roof.json")


def smaller(command):
    """The command as this test runs it."""
    command = re.sub(r"--image-width \d+ --image-height \d+", SMALL, command)
    if command.startswith("simuli train"):
        command = re.sub(r"--iterations \d+", "", command) + " --max-seconds 2"
    if command.startswith("simuli import"):
        return command
    return re.sub(r"\b(" + "|".join(STAND_FOR) + r")\b", lambda m: STAND_FOR[m[1]], command)


prepare()
commands = commands_of(source / page)
assert commands, f"{page} has no commands"
for line in commands:
    if line == "simuli demo -o demo":  # as prepared
        continue
    made = re.search(r"^simuli train .*-o (\S+)", line)
    if made and (work / made[1]).is_symlink():
        (work / made[1]).unlink()  # what the page trains here takes the prepared scene's place
    if any(name in line for name in ABSENT):
        run(smaller(line), INPUT_ERROR)
    elif line.startswith("simuli align") and "--camera" in line:  # pictures this small may not tell a mounting
        run(smaller(line), 0, NOT_DETERMINED)
    else:
        run(smaller(line))
