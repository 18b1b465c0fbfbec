"""A labelled rendering of the street as a KITTI drive, imported and trained on: kitti_test.py SIMULI EXAMPLES WORK"""
import json
import pathlib
import subprocess
import sys

import numpy as np

simuli, examples, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
sys.path.insert(0, str(examples))
import points_folder as pf  # noqa: E402


def run(*args):
    return subprocess.run([simuli, *map(str, args)], cwd=work, check=True, text=True, capture_output=True).stdout


def path_of(poses):
    return pf.Path([p["time_ns"] for p in poses], [pf.matrix(p["rotation_wxyz"], p["position_m"]) for p in poses])


def log_of(name):
    return json.loads((work / name / "log.json").read_text())


quick = ["--scale", 0.5, "--set", "init.voxel_m=0.2"]
run("synth", "street", "-o", "s.log", "--frames", 8)
run("train", "s.log", "-o", "s.scene", "--iterations", 60, *quick)
run("render", "s.scene", "--sensor", "front", "--sensor", "top", "--labels", "kitti", "--clouds", "npz",
    "--cloud-frame", "sensor", "-o", "rendered")
subprocess.run([sys.executable, examples / "kitti_drive.py", work / "rendered", work / "drive"], check=True)
drive = work / "drive"
run("import", "kitti", drive / "2011_09_26" / "2011_09_26_drive_0001_sync", "-o", "again.log", "--beams",
    drive / "beams.json", "--poses", drive / "poses.json", "--tracking", drive / "label_02.txt")

# The boxes are the street's: seen from the LiDAR within what training moved them by.
truth, again = log_of("s.log"), log_of("again.log")
assert [a["kind"] for a in again["actors"]] == ["car"], again["actors"]
(car,), (read,) = truth["actors"], again["actors"]
for side in ("length_m", "width_m", "height_m"):
    assert abs(car[side] - read[side]) < 1e-3, (side, car[side], read[side])
true_path, true_rig = path_of(car["track"]), path_of(truth["world_from_rig"])
rig, velo = path_of(again["world_from_rig"]), pf.matrix([1, 0, 0, 0], [0, 0, 1.9])
errors = []
for key in read["track"]:
    time_ns = key["time_ns"] - again["start_ns"]
    own = np.linalg.inv(rig.at(key["time_ns"])) @ pf.matrix(key["rotation_wxyz"], key["position_m"])
    true = np.linalg.inv(true_rig.at(time_ns) @ velo) @ true_path.at(time_ns)
    errors.append(np.linalg.norm(own[:3, 3] - true[:3, 3]))
print("boxes off by", np.round(errors, 3), "m")
assert len(errors) == 8 and max(errors) < 0.15, errors

# And usable: a training on them is no worse on the car than the first one, whose truth is noisier.
run("train", "again.log", "-o", "again.scene", "--iterations", 60, *quick)
first, second = (json.loads(run("eval", f"{name}.scene", f"{name}.log", "--json")) for name in ("s", "again"))
print("dB of the car", first["actor_psnr_db"], second["actor_psnr_db"])
print("of its returns end there", first["actor_share_met"], second["actor_share_met"])
assert second["actor_psnr_db"] > first["actor_psnr_db"] - 1
assert second["actor_share_met"] > first["actor_share_met"]
