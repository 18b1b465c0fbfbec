"""convert_argoverse2.py LOG OUT: a log of the Argoverse 2 Sensor Dataset for `simuli import points OUT -o drive.log`.

Needs NumPy, pandas and pyarrow. After the data set's public description and devkit (github.com/argoverse/av2-api,
av2/structures/sweep.py), and the converter notes of NVIDIA's NCore (tools/data_converter/argoverse2/README.md):
points are in the vehicle's frame at the sweep's time, the vehicle's motion taken off, with offset_ns after it;
two VLP-32C share the laser numbers, and which half belongs to up_lidar is not documented: here the mounting in
whose frame each laser's points lie at one elevation. Pictures are undistorted, k1 to k3 belong to the raw ones.
Coordinates are stored as float16 in places (3 cm at 50 m), which no conversion brings back.
"""
import pathlib
import sys

import numpy as np
import pandas as pd

from points_folder import Folder, Path, camera, lidar, matrix, run, spin

TABLE, COLUMNS = "velodyne_vlp32c", 1800
# Of the height: 250 rows of the pictures, which evaluations crop (georghess/neurad-studio's parser).
VEHICLE = {"ring_front_center": 250 / 2048, "ring_rear_left": 250 / 1550, "ring_rear_right": 250 / 1550}


def poses_of(table):
    return [matrix(q, t) for q, t in zip(table[["qw", "qx", "qy", "qz"]].to_numpy(float),
                                         table[["tx_m", "ty_m", "tz_m"]].to_numpy(float))]


def elevation_spread(points, laser):
    """Mean standard deviation of the lasers' elevations (rad); far points alone, where float16 tells."""
    flat = np.hypot(points[:, 0], points[:, 1])
    elevation = np.arctan2(points[:, 2], flat)
    spreads = [elevation[(laser == k) & (flat > 5)].std() for k in np.unique(laser)
               if ((laser == k) & (flat > 5)).sum() > 20]
    return float(np.mean(spreads)) if spreads else np.inf


def main(log, out):
    log = pathlib.Path(log)
    table = pd.read_feather(log / "city_SE3_egovehicle.feather").sort_values("timestamp_ns")
    city = poses_of(table)
    world_from_city = np.linalg.inv(city[0])
    path = Path(table["timestamp_ns"], [world_from_city @ m for m in city])
    mounts = pd.read_feather(log / "calibration" / "egovehicle_SE3_sensor.feather")
    rig_from = dict(zip(mounts["sensor_name"], poses_of(mounts)))
    sweeps = sorted(log.glob("sensors/lidar/*.feather"), key=lambda f: int(f.stem))
    sweeps = [f for f in sweeps if path.times_ns[0] <= int(f.stem) <= path.times_ns[-1]]
    folder = Folder(out, log.name, path.times_ns[0])

    halves, turns = None, {}
    for file in sweeps:
        start_ns = int(file.stem)
        points = pd.read_feather(file)
        rig = points[["x", "y", "z"]].to_numpy(float)
        laser = points["laser_number"].to_numpy(int)
        m = path.at(start_ns)
        world = rig @ m[:3, :3].T + m[:3, 3]
        offset_ns = points["offset_ns"].to_numpy(float)
        end_ns = start_ns + 100_000_000
        in_sensor = {}
        for name in ("up_lidar", "down_lidar"):
            for half in (0, 1):
                own = laser // 32 == half
                if own.any():
                    in_sensor[name, half] = path.to_sensor(world[own], start_ns + offset_ns[own], rig_from[name])
        if halves is None:
            def spread(name, half):
                own = laser // 32 == half
                return elevation_spread(in_sensor[name, half], laser[own]) if own.any() else 0.0
            straight = spread("up_lidar", 0) + spread("down_lidar", 1)
            crossed = spread("up_lidar", 1) + spread("down_lidar", 0)
            halves = {"up_lidar": 0, "down_lidar": 1} if straight <= crossed else {"up_lidar": 1, "down_lidar": 0}
        for name, half in halves.items():
            own = laser // 32 == half
            if not own.any():
                continue
            p = in_sensor[name, half]
            turns.setdefault(name, []).append(
                spin(np.arctan2(p[:, 1], p[:, 0]), offset_ns[own] / (end_ns - start_ns)))
            folder.sweep(name, world[own], points["intensity"].to_numpy(float)[own] / 255, offset_ns[own] * 1e-9,
                         start_ns, end_ns)
    for name, all_turns in turns.items():
        sign = 1 if sum(t[0] for t in all_turns) >= 0 else -1
        start = float(np.angle(np.mean([np.exp(1j * t[1]) for t in all_turns if t[0] == sign])))
        print(f"{name}: lasers from {32 * halves[name]}, turns {'counter-' if sign > 0 else ''}clockwise, "
              f"agreement {np.mean([t[2] for t in all_turns]):.3f}")
        folder.json["lidars"].append(lidar(name, TABLE, COLUMNS, rig_from[name], sign, start))

    intrinsics = pd.read_feather(log / "calibration" / "intrinsics.feather")
    for c in intrinsics.to_dict("records"):
        name = c["sensor_name"]
        pictures = [f for f in sorted(log.glob(f"sensors/cameras/{name}/*.jpg"))
                    if path.times_ns[0] <= int(f.stem) <= path.times_ns[-1]]
        if not pictures:
            continue
        folder.json["cameras"].append(camera(name, c["width_px"], c["height_px"], c["fx_px"], c["fy_px"], c["cx_px"],
                                             c["cy_px"], rig_from[name]))
        if name in VEHICLE:
            folder.hide_lowest(name, int(c["width_px"]), int(c["height_px"]), VEHICLE[name])
        for f in pictures:
            folder.image(name, f, int(f.stem))
    if (log / "annotations.feather").exists():
        boxes = pd.read_feather(log / "annotations.feather")
        for b, rig_from_box in zip(boxes.to_dict("records"), poses_of(boxes)):
            if path.times_ns[0] <= b["timestamp_ns"] <= path.times_ns[-1]:
                folder.box(b["track_uuid"], b["category"], (b["length_m"], b["width_m"], b["height_m"]),
                           b["timestamp_ns"], path.at(b["timestamp_ns"]) @ rig_from_box)
    folder.finish(path)


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    run(main, *sys.argv[1:])
