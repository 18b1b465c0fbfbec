"""A drive as AlpaSim and CARLA read it: export_alpasim_test.py SIMULI EXAMPLES WORK

What AlpaSim's runtime asks of each file, checked with other readers than ours.
"""
import json
import pathlib
import struct
import sys
import zipfile

import numpy as np
import yaml
from export_scene import run, scene

simuli, work = sys.argv[1], pathlib.Path(sys.argv[3])
drive = scene(simuli, work)
run(simuli, "export", drive, "--drive", "-o", work / "street.usdz")
archive = zipfile.ZipFile(work / "street.usdz")
assert archive.testzip() is None
data = (work / "street.usdz").read_bytes()
for entry in archive.infolist():
    assert entry.compress_type == zipfile.ZIP_STORED
    name, extra = struct.unpack_from("<HH", data, entry.header_offset + 26)
    assert (entry.header_offset + 30 + name + extra) % 64 == 0, entry.filename
assert archive.namelist()[0].endswith(".usda")

metadata = yaml.safe_load(archive.read("metadata.yaml"))
for key, kind in (("scene_id", str), ("version_string", str), ("training_date", str), ("dataset_hash", str),
                  ("uuid", str), ("is_resumable", bool), ("sensors", dict), ("logger", dict), ("time_range", dict),
                  ("training_step_outputs", dict)):
    assert isinstance(metadata[key], kind), key
assert metadata["scene_id"] == "street" and metadata["sensors"] == {"camera_ids": ["front"], "lidar_ids": ["top"]}

rig = json.loads(archive.read("rig_trajectories.json"))
(path,) = rig["rig_trajectories"]
poses, times = np.array(path["T_rig_worlds"]), np.array(path["T_rig_world_timestamps_us"])
recorded = json.loads((work / "street.scene/scene.json").read_text())
track = recorded["world_from_rig"]
origin = np.array(recorded["origin_m"])
assert poses.shape == (len(track), 4, 4) and (np.diff(times) > 0).all()
assert np.allclose(poses[:, :3, 3] + origin, [p["position_m"] for p in track], atol=1e-9)
assert np.allclose(poses[:, :3, :3] @ poses[:, :3, :3].transpose(0, 2, 1), np.eye(3), atol=1e-9)
assert [metadata["time_range"]["start"], metadata["time_range"]["end"]] == [times[0], times[-1]]
assert np.array_equal(rig["world_to_nre"]["matrix"], np.eye(4)) and path["rig_bbox"] is None
assert set(path["cameras_frame_timestamps_us"]) == set(rig["camera_calibrations"])
for frames in path["cameras_frame_timestamps_us"].values():
    assert frames and all(isinstance(t, int) for instance in frames for t in pair) and all(b > a for a, b in frames)

(tracks,) = json.loads(archive.read("sequence_tracks.json")).values()
actors = tracks["tracks_data"]
counts = {len(actors[key]) for key in actors} | {len(tracks["cuboidtracks_data"]["cuboids_dims"])}
assert counts == {len(recorded["actors"])} and actors["tracks_id"] == [a["name"] for a in recorded["actors"]]
for flags, actor_times, actor_poses in zip(actors["tracks_flags"], actors["tracks_timestamps_us"],
                                           actors["tracks_poses"]):
    assert "CONTROLLABLE" in flags and (np.diff(actor_times) > 0).all() and len(actor_times) >= 2
    assert np.allclose(np.linalg.norm(np.array(actor_poses)[:, 3:], axis=1), 1)

head, body = archive.read("mesh_ground.ply").split(b"end_header\n", 1)
vertices, faces = (int(line.split()[2]) for line in head.splitlines() if line.startswith(b"element"))
place = np.frombuffer(body, "<f4", 3 * vertices).reshape(-1, 3)
face = np.frombuffer(body, [("n", "u1"), ("v", "<i4", 3)], faces, 12 * vertices)
assert (face["n"] == 3).all() and face["v"].min() >= 0 and face["v"].max() < vertices
height = place[:, 2] + origin[2]  # the street is flat, at 0
below = np.array([np.abs(place[:, :2] - p[:2, 3]).max(1).min() for p in poses])
print(f"{len(actors['tracks_id'])} actors, {faces} triangles; ground off by {np.abs(height).mean():.3f} m, at most "
      f"{np.abs(height).max():.3f} m; {below.max():.2f} m from the path")
near = np.abs(place[:, None, :2] - poses[None, :, :2, 3]).max(2).min(1) < 5
assert near.sum() > 20 and np.median(np.abs(height[near])) < 0.01 and np.abs(height[near]).max() < 0.5
