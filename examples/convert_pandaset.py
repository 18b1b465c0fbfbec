"""convert_pandaset.py SEQUENCE OUT [EXTRINSICS.json | lidar]: PandaSet for `simuli import points OUT -o drive.log`.

Needs NumPy and pandas. After the data set's devkit (github.com/scaleapi/pandaset-devkit, README): points stand in
the world, the vehicle's motion taken off, with their own times t; d is 0 for the Pandar64, which is converted, and 1
for the PandarGT, which is not. Boxes: dimensions x is the width, y the length. lidar/poses.json holds no poses of the
LiDAR (of sequence 002 a point 1.8 m below it), so that they come from the front camera's and the mounting that the
devkit publishes; EXTRINSICS.json, the 4 x 4 matrix camera_from_lidar as rows: another one; "lidar" believes the file.
The rig stands where the LiDAR does, turned about z by the multiple of 90 degrees that makes it drive forward.
"""
import json
import pathlib
import sys

import numpy as np
import pandas as pd

from points_folder import Folder, Path, camera, lidar, matrix, spin

TABLE, COLUMNS = "ncore_pandaset_pandar64", 1800
# The devkit's docs/static_extrinsic_calibration.yaml, front_camera: the camera from the Pandar64.
CAMERA_FROM_LIDAR = matrix([0.016213200031258722, 0.0030578899383849464, 0.7114721800418571, -0.7025205466606356],
                           [0.0002585796504896516, -0.03907777167811011, -0.0440125762408362])


def read_poses(folder):
    poses = [matrix([p["heading"][k] for k in "wxyz"], [p["position"][k] for k in "xyz"])
             for p in json.loads((folder / "poses.json").read_text())]
    times_ns = [round(1e9 * t) for t in json.loads((folder / "timestamps.json").read_text())]
    return times_ns, poses


def about_z(angle):
    m = np.eye(4)
    m[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return m


def forward(poses):
    """sensor_from_rig: the quarter turn that brings the drive's motion to +x."""
    moved = poses[-1][:3, 3] - poses[0][:3, 3]
    seen = poses[len(poses) // 2][:3, :3].T @ moved
    return about_z(np.round(np.arctan2(seen[1], seen[0]) / (np.pi / 2)) * np.pi / 2)


def main(sequence, out, extrinsics=None):
    sequence = pathlib.Path(sequence)
    if extrinsics == "lidar":
        times_ns, poses = read_poses(sequence / "lidar")
    else:
        camera_from_lidar = CAMERA_FROM_LIDAR
        if extrinsics is not None:
            camera_from_lidar = np.array(json.loads(pathlib.Path(extrinsics).read_text()), float)
        times_ns, poses = read_poses(sequence / "camera" / "front_camera")
        poses = [m @ camera_from_lidar for m in poses]
    sensor_from_rig = forward(poses)
    world_from_theirs = np.linalg.inv(poses[0] @ sensor_from_rig)
    path = Path(times_ns, [world_from_theirs @ m @ sensor_from_rig for m in poses])
    rig_from_sensor = np.linalg.inv(sensor_from_rig)
    folder = Folder(out, sequence.name, path.times_ns[0])

    turns = []
    for file in sorted((sequence / "lidar").glob("[0-9]*.pkl*")):
        points = pd.read_pickle(file)
        points = points[points["d"] == 0]
        theirs = points[["x", "y", "z"]].to_numpy(float)
        world = theirs @ world_from_theirs[:3, :3].T + world_from_theirs[:3, 3]
        t_ns = np.round(1e9 * points["t"].to_numpy(float)).astype(np.int64)
        start_ns = int(t_ns.min())
        end_ns = max(int(t_ns.max()) + 1, start_ns + 100_000_000)
        p = path.to_sensor(world, t_ns, rig_from_sensor)
        turns.append(spin(np.arctan2(p[:, 1], p[:, 0]), (t_ns - start_ns) / (end_ns - start_ns)))
        folder.sweep("pandar64", world, points["i"].to_numpy(float) / 255, (t_ns - start_ns) * 1e-9, start_ns, end_ns)
    sign = 1 if sum(t[0] for t in turns) >= 0 else -1
    start = float(np.angle(np.mean([np.exp(1j * t[1]) for t in turns if t[0] == sign])))
    print(f"pandar64: turns {'counter-' if sign > 0 else ''}clockwise, agreement {np.mean([t[2] for t in turns]):.3f}")
    folder.json["lidars"].append(lidar("pandar64", TABLE, COLUMNS, rig_from_sensor, sign, start))

    for cameras in sorted((sequence / "camera").iterdir()):
        pictures = sorted(cameras.glob("*.jpg"))
        camera_ns, camera_poses = read_poses(cameras)
        k = json.loads((cameras / "intrinsics.json").read_text())
        # A mounting does not move: that of the picture in the middle of the drive.
        middle = len(camera_poses) // 2
        rig_from_camera = np.linalg.inv(path.at(camera_ns[middle])) @ world_from_theirs @ camera_poses[middle]
        width, height = jpeg_size(pictures[0])
        folder.json["cameras"].append(camera(cameras.name, width, height, k["fx"], k["fy"], k["cx"], k["cy"],
                                             rig_from_camera))
        for f in pictures:
            folder.image(cameras.name, f, camera_ns[int(f.stem)])
    for file in sorted((sequence / "annotations" / "cuboids").glob("[0-9]*.pkl*")):
        for b in pd.read_pickle(file).to_dict("records"):
            if b.get("cuboids.sensor_id", -1) == 1:  # the same object as the PandarGT saw it
                continue
            theirs = about_z(b["yaw"] + np.pi / 2)  # their y is along the object
            theirs[:3, 3] = b["position.x"], b["position.y"], b["position.z"]
            folder.box(b["uuid"], b["label"], (b["dimensions.y"], b["dimensions.x"], b["dimensions.z"]),
                       times_ns[int(file.name.split(".")[0])], world_from_theirs @ theirs)
    folder.finish(path)


def jpeg_size(file):
    """Width and height from a JPEG's own start-of-frame."""
    data = pathlib.Path(file).read_bytes()
    at = 2
    while data[at + 1] not in (0xC0, 0xC1, 0xC2):
        at += 2 + int.from_bytes(data[at + 2:at + 4], "big")
    return int.from_bytes(data[at + 7:at + 9], "big"), int.from_bytes(data[at + 5:at + 7], "big")


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    main(*sys.argv[1:])
