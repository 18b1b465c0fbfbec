"""A made-up folder of Argoverse 2 through its converter: converters_test.py SIMULI EXAMPLES WORK"""
import json
import pathlib
import subprocess
import sys

import numpy as np
import pandas as pd
from PIL import Image

simuli, examples, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
sys.path.insert(0, str(examples))
import points_folder as pf  # noqa: E402

START_NS, TURNS, ROOM_M, RAYS = 1_600_000_000_000_000_000, 3, 12.0, 600


def jpeg(path):
    path.parent.mkdir(parents=True, exist_ok=True)
    Image.new("RGB", (8, 6)).save(path)


def table(name):
    """Elevations and columns of a built-in LiDAR."""
    text = subprocess.run([simuli, "info", name, "--json"], check=True, text=True, capture_output=True).stdout
    model = json.loads(text)
    return [r["elevation_rad"] for r in model["rows"]]


def turn(elevations, rays, sign, first, path, start_ns, mount):
    """What a LiDAR sees of a round room of the world: points there, beam of each, time after the start (ns)."""
    beam, column = np.meshgrid(np.arange(len(elevations)), np.arange(rays), indexing="ij")
    beam, column = beam.ravel(), column.ravel()
    azimuth = first + sign * 2 * np.pi * (column + 0.5) / rays
    elevation = np.asarray(elevations)[beam]
    direction = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth),
                          np.sin(elevation)], 1)
    offset_ns = (column + 0.5) / rays * 1e8
    world = np.empty((len(beam), 3))
    for c in range(rays):
        m = path.at(start_ns + (c + 0.5) / rays * 1e8) @ mount
        own = column == c
        d, o = direction[own] @ m[:3, :3].T, m[:3, 3]
        a, b = (d[:, :2] ** 2).sum(1), d[:, :2] @ o[:2]
        t = (-b + np.sqrt(b * b + a * (ROOM_M**2 - o[:2] @ o[:2]))) / a
        world[own] = o + t[:, None] * d
    return world, beam, offset_ns


def imported(folder, log):
    """What the importer says of the folder, as numbers; the log's ranges are the room's."""
    run = subprocess.run([simuli, "import", "points", folder, "-o", log], text=True, capture_output=True)
    assert run.returncode == 0, run.stderr
    words = [w for w in run.stderr.replace(",", "").split() if w.isdigit()]
    return dict(zip(("points", "unplaced", "echoes", "returned", "rays"), map(int, words[-5:])))


def straight(axes):
    """10 m/s along the world's x; `axes` turns the sensor on the path."""
    times = [START_NS + i * 50_000_000 for i in range(2 * TURNS + 3)]
    poses = []
    for i, _ in enumerate(times):
        m = axes.copy()
        m[:3, 3] = [-2 + 0.5 * i, 0.3, 0.1]
        poses.append(m)
    return pf.Path(times, poses)


def argoverse2():
    root = work / "av2" / "log"
    (root / "calibration").mkdir(parents=True)
    (root / "sensors" / "lidar").mkdir(parents=True)
    path = straight(np.eye(4))
    far = pf.matrix([np.cos(0.2), 0, 0, np.sin(0.2)], [3000, 1000, 20])

    def rows(poses):
        q = np.array([pf.quaternion(m) for m in poses])
        return {"qw": q[:, 0], "qx": q[:, 1], "qy": q[:, 2], "qz": q[:, 3], "tx_m": [m[0, 3] for m in poses],
                "ty_m": [m[1, 3] for m in poses], "tz_m": [m[2, 3] for m in poses]}

    pd.DataFrame({"timestamp_ns": path.times_ns, **rows([far @ m for m in path.poses])}).to_feather(
        root / "city_SE3_egovehicle.feather")
    mounts = {"up_lidar": pf.matrix([1, 0, 0, 0], [1.3, 0, 1.6]),
              "down_lidar": pf.matrix([0, 0.9990482, 0.0436194, 0], [1.3, 0, 1.5]),  # on its head, tilted
              "ring_front_center": pf.matrix([0.5, -0.5, 0.5, -0.5], [1.6, 0, 1.4])}
    pd.DataFrame({"sensor_name": list(mounts), **rows(list(mounts.values()))}).to_feather(
        root / "calibration" / "egovehicle_SE3_sensor.feather")
    pd.DataFrame([{"sensor_name": "ring_front_center", "fx_px": 9.0, "fy_px": 9.0, "cx_px": 3.5, "cy_px": 2.5,
                   "k1": -0.2, "k2": 0.1, "k3": 0.0, "height_px": 6, "width_px": 8}]).to_feather(
        root / "calibration" / "intrinsics.feather")
    elevations = table("velodyne_vlp32c")
    for i in range(TURNS):
        start_ns = START_NS + i * 100_000_000
        parts = []
        for half, name, sign in ((32, "up_lidar", -1), (0, "down_lidar", 1)):  # the second half is the upper one
            world, beam, offset_ns = turn(elevations, RAYS, sign, 0.3, path, start_ns, mounts[name])
            ego = np.linalg.inv(path.at(start_ns))
            p = world @ ego[:3, :3].T + ego[:3, 3]
            parts.append(pd.DataFrame({"x": p[:, 0], "y": p[:, 1], "z": p[:, 2], "intensity": np.uint8(51),
                                       "laser_number": (beam + half).astype(np.uint8),
                                       "offset_ns": offset_ns.astype(np.int32)}))
        pd.concat(parts, ignore_index=True).to_feather(root / "sensors" / "lidar" / f"{start_ns}.feather")
        jpeg(root / "sensors" / "cameras" / "ring_front_center" / f"{start_ns + 10_000_000}.jpg")
    pd.DataFrame({"timestamp_ns": [START_NS, START_NS + 100_000_000], "track_uuid": ["t", "t"],
                  "category": ["REGULAR_VEHICLE"] * 2, "length_m": 4.5, "width_m": 1.9, "height_m": 1.6,
                  **rows([pf.matrix([1, 0, 0, 0], [9, 2, 1]), pf.matrix([1, 0, 0, 0], [8, 2, 1])])}).to_feather(
        root / "annotations.feather")
    out = work / "av2_points"
    said = subprocess.run([sys.executable, examples / "convert_argoverse2.py", root, out], check=True, text=True,
                          capture_output=True).stdout
    assert "up_lidar: lasers from 32, turns clockwise" in said, said
    assert "down_lidar: lasers from 0, turns counter-clockwise" in said, said
    report = imported(out, work / "av2.log")
    assert report["points"] == TURNS * 64 * RAYS and report["unplaced"] == 0, report
    assert report["returned"] > 0.99 * report["points"], report
    log = json.loads((work / "av2.log" / "log.json").read_text())
    assert {lidar["name"] for lidar in log["lidars"]} == {"up_lidar", "down_lidar"}
    # A box 1 m nearer to a vehicle that has driven 1 m meanwhile stands still.
    track = log["actors"][0]["track"]
    assert np.allclose(track[0]["position_m"], track[1]["position_m"], atol=1e-4), track
    assert len(log["images"]) == TURNS and log["cameras"][0]["cx_px"] == 4.0
    info = json.loads(subprocess.run([simuli, "info", work / "av2.log", "--json"], check=True, text=True,
                                     capture_output=True).stdout)
    assert abs(info["hidden_shares"]["ring_front_center"] - 1 / 6) < 1e-6, info  # 250 of 2048 rows


argoverse2()
