#!/usr/bin/env python3
"""A rendered and labelled drive as a KITTI raw drive, which `simuli import kitti` and others' readers take.

    simuli render SCENE --sensor CAMERA --sensor LIDAR --labels kitti --clouds npz --cloud-frame sensor -o RENDERED
    python3 kitti_drive.py RENDERED DRIVE
    simuli import kitti DRIVE/2011_09_26/2011_09_26_drive_0001_sync -o again.log --beams DRIVE/beams.json \\
      --poses DRIVE/poses.json --tracking DRIVE/label_02.txt

The first camera of RENDERED becomes image_02 and must be a pinhole, frame i belongs to sweep i, and the LiDAR turns
clockwise. Needs NumPy."""
import argparse
import json
import pathlib
import shutil

import numpy as np

import points_folder as pf

MIDNIGHT_OFFSET_S = 3600.0  # of the log's time 0, so that nothing lies on the day before


def stamp(time_s):
    ns = round((MIDNIGHT_OFFSET_S + time_s) * 1e9)
    seconds = ns // 10**9
    return f"2011-09-26 {seconds // 3600:02}:{seconds // 60 % 60:02}:{seconds % 60:02}.{ns % 10**9:09}\n"


def matrix(pose):
    return pf.matrix(pose["rotation_wxyz"], pose["position_m"])


def numbers(key, values):
    return f"{key}: " + " ".join(f"{v:.12e}" for v in np.ravel(values)) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("rendered", type=pathlib.Path)
    parser.add_argument("drive", type=pathlib.Path, help="folder to make")
    args = parser.parse_args()
    records = [(file.parent, json.loads(file.read_text())) for file in sorted(args.rendered.glob("*/frames.json"))]
    cameras = [r for r in records if r[1]["sensor"]["kind"] == "camera"]
    lidars = [r for r in records if r[1]["sensor"]["kind"] == "lidar"]
    if not cameras or not lidars:
        found = f"{len(cameras)} cameras and {len(lidars)} LiDARs"
        parser.error(f"{args.rendered}: found {found}, allowed one or more of each")
    (camera_folder, camera), (lidar_folder, lidar) = cameras[0], lidars[0]
    if lidar.get("clouds", {}).get("frame") != "sensor" or not lidar["frames"][0]["files"][0].endswith(".npz"):
        parser.error(f"{lidar_folder}: found other clouds, allowed --clouds npz --cloud-frame sensor")
    tracking = camera_folder / "kitti" / "label_02.txt"
    if not tracking.exists():
        parser.error(f"{tracking}: found no such file, allowed a drive rendered with --labels kitti")

    args.drive.mkdir()
    date = args.drive / "2011_09_26"
    folder = date / "2011_09_26_drive_0001_sync"
    pictures, sweeps = folder / "image_02" / "data", folder / "velodyne_points" / "data"
    for part in (pictures, sweeps):
        part.mkdir(parents=True)

    # The velodyne is the rig of KITTI's files; pixels are counted from the middle of the first one on.
    model = camera["sensor"]
    camera_from_velo = np.linalg.inv(matrix(camera["rig_from_sensor"])) @ matrix(lidar["rig_from_sensor"])
    projection = np.zeros((3, 4))
    projection[0, :3] = model["fx_px"], 0, model["cx_px"] - 0.5
    projection[1, :3] = 0, model["fy_px"], model["cy_px"] - 0.5
    projection[2, 2] = 1
    (date / "calib_cam_to_cam.txt").write_text(
        "calib_time: 26-Sep-2011 00:00:00\n" + numbers("S_rect_02", [model["width_px"], model["height_px"]]) +
        numbers("R_rect_00", np.eye(3)) + numbers("P_rect_02", projection))
    (date / "calib_velo_to_cam.txt").write_text(
        "calib_time: 26-Sep-2011 00:00:00\n" + numbers("R", camera_from_velo[:3, :3]) +
        numbers("T", camera_from_velo[:3, 3]))

    times = {"start": "", "forward": "", "end": ""}
    picture_times, poses = "", []
    for i, (picture, sweep) in enumerate(zip(camera["frames"], lidar["frames"])):
        shutil.copy(camera_folder / picture["files"][0], pictures / f"{i:010}.png")
        picture_times += stamp(picture["time_start_s"])
        cloud = np.load(lidar_folder / sweep["files"][0])
        points = np.column_stack([cloud["xyz"], cloud["intensity"]]).astype("<f4")
        (sweeps / f"{i:010}.bin").write_bytes(points.tobytes())
        start_s, end_s = sweep["time_start_s"], sweep["time_end_s"]
        forward_s = 0.5 * (start_s + end_s)
        for name, time_s in (("start", start_s), ("forward", forward_s), ("end", end_s)):
            times[name] += stamp(time_s)
        path = pf.Path([0, 2], [matrix(sweep["world_from_sensor_start"]), matrix(sweep["world_from_sensor_end"])])
        poses.append({"index": i, "t_sweep_forward": MIDNIGHT_OFFSET_S + forward_s,
                      "world_from_velo": path.at(1).tolist()})
    (folder / "image_02" / "timestamps.txt").write_text(picture_times)
    for name, file in (("start", "timestamps_start"), ("forward", "timestamps"), ("end", "timestamps_end")):
        (folder / "velodyne_points" / f"{file}.txt").write_text(times[name])
    (args.drive / "poses.json").write_text(json.dumps({"note": "rendered by simuli", "frames": poses}))
    (args.drive / "beams.json").write_text(json.dumps(lidar["sensor"]))
    shutil.copy(tracking, args.drive / "label_02.txt")
    print(f"{len(poses)} frames in {folder}")


if __name__ == "__main__":
    main()
