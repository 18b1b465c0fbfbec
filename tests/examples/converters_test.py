"""Made-up folders of PandaSet and Argoverse 2 through their converters: converters_test.py SIMULI EXAMPLES WORK"""
import json
import pathlib
import subprocess
import sys

import numpy as np
import pandas as pd
from PIL import Image

simuli, examples, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
sys.path.insert(0, str(examples))
import convert_pandaset  # noqa: E402
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


def pandaset():
    root = work / "pandaset" / "001"
    # Their LiDAR looks along its y; the world begins somewhere else.
    axes = pf.matrix([np.sqrt(0.5), 0, 0, -np.sqrt(0.5)], [0, 0, 0])
    path = straight(axes)
    far = pf.matrix([np.cos(0.4), 0, 0, np.sin(0.4)], [100, -50, 3])
    elevations = table("ncore_pandaset_pandar64")
    (root / "lidar").mkdir(parents=True)
    (root / "annotations" / "cuboids").mkdir(parents=True)
    times, poses = [], []
    for i in range(TURNS):
        start_ns = START_NS + i * 100_000_000
        world, _, offset_ns = turn(elevations, RAYS, -1, 2.0, path, start_ns, np.eye(4))
        world = world @ far[:3, :3].T + far[:3, 3]
        t = (start_ns + offset_ns) * 1e-9
        frame = pd.DataFrame({"x": world[:, 0], "y": world[:, 1], "z": world[:, 2], "i": 51.0, "t": t, "d": 0})
        front = frame.iloc[:10].assign(d=1)
        pd.concat([frame, front]).to_pickle(root / "lidar" / f"{i:02}.pkl.gz")
        m = far @ path.at(start_ns + 50_000_000)
        times.append((start_ns + 50_000_000) * 1e-9)
        poses.append(m)
        car = pd.DataFrame([{"uuid": "u", "label": "Car", "yaw": 0.8, "position.x": 100.0 + i, "position.y": -50.0,
                             "position.z": 3.0, "dimensions.x": 1.9, "dimensions.y": 4.5, "dimensions.z": 1.6,
                             "cuboids.sensor_id": -1}])
        car.to_pickle(root / "annotations" / "cuboids" / f"{i:02}.pkl.gz")

    def write(folder, mount):
        folder.mkdir(parents=True, exist_ok=True)
        (folder / "timestamps.json").write_text(json.dumps(times))
        out = []
        for m in poses:
            q, p = pf.quaternion(m @ mount), (m @ mount)[:3, 3]
            out.append({"position": dict(zip("xyz", p)), "heading": dict(zip("wxyz", q))})
        (folder / "poses.json").write_text(json.dumps(out))

    write(root / "lidar", np.eye(4))
    looks_along_y = pf.matrix([np.sqrt(0.5), -np.sqrt(0.5), 0, 0], [0, 0.5, -0.3])
    published = np.linalg.inv(convert_pandaset.CAMERA_FROM_LIDAR)
    assert published[1, 2] < -0.999, published  # that camera looks back along the LiDAR's y
    write(root / "camera" / "front_camera", looks_along_y)
    (root / "camera" / "front_camera" / "intrinsics.json").write_text(json.dumps({"fx": 9, "fy": 9, "cx": 3.5,
                                                                                  "cy": 2.5}))
    for i in range(TURNS):
        jpeg(root / "camera" / "front_camera" / f"{i:02}.jpg")
    (work / "camera_from_lidar.json").write_text(json.dumps(np.linalg.inv(looks_along_y).tolist()))
    for extra in ("lidar", str(work / "camera_from_lidar.json"), ""):
        if not extra:  # a camera where the devkit has it, and poses of the LiDAR that are none
            looks_along_y = published
            write(root / "camera" / "front_camera", published)
            write(root / "lidar", pf.matrix([1, 0, 0, 0], [0, 0, -1.8]))
        name = f"pandaset_{pathlib.Path(extra).stem}"
        out = work / name
        subprocess.run([sys.executable, examples / "convert_pandaset.py", root, out, *filter(None, [extra])], check=True,
                       stdout=subprocess.DEVNULL)
        said = imported(out, work / f"{name}.log")
        assert said["points"] == TURNS * 64 * RAYS, said
        assert said["unplaced"] == 0 and said["returned"] > 0.99 * said["points"], said
        log = json.loads((work / f"{name}.log" / "log.json").read_text())
        assert log["lidars"][0]["spin"] == "clockwise"
        first, last = (np.array(p["position_m"]) for p in (log["world_from_rig"][0], log["world_from_rig"][-1]))
        assert np.allclose(first, 0, atol=1e-6) and np.allclose(last, [2.0, 0, 0], atol=1e-5), last
        mount = log["cameras"][0]["rig_from_camera"]
        place, axis = looks_along_y[:3, 3], looks_along_y[:3, 2]  # the rig's x is the LiDAR's y
        assert np.allclose(mount["position_m"], [place[1], -place[0], place[2]], atol=1e-5), mount
        looks = pf.matrix(mount["rotation_wxyz"], [0, 0, 0])[:3, 2]
        assert np.allclose(looks, [axis[1], -axis[0], axis[2]], atol=1e-5), looks
        assert log["actors"][0]["length_m"] == 4.5 and len(log["actors"][0]["track"]) == TURNS


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


pandaset()
argoverse2()
