"""A car that drives through a scene by what it sees, as a recording of ROS 2: drive_to_mcap.py SCENE -o DRIVE.mcap [options]

An environment of Gymnasium's (simuli.gym.Drive) in a closed loop: the driver keeps a lane beside the recorded path and brakes
for what the LiDAR has ahead; the poses it has been at then make a log whose path `simuli render` takes, with all sensors of the
scene, their calibrations, /tf and clocks (docs/ROS2.md). Needs gymnasium, numpy.
"""
import argparse
import json
import math
import pathlib
import tempfile

import numpy as np
import simuli
import simuli.gym
from simuli import program

START_NS = 10**9  # of the scene's time 0: paths may begin before it
LOOK_AHEAD_M, FREE_M, COMFORT = 6.0, 3.0, 2.0  # pure pursuit; room that is kept; m/s2
LANE_M, GROUND_M, SPECKS = 1.2, 0.4, 4  # half the width that must be free; above it; returns that are nothing to brake for


def steering(env, world_from_rig, beside_m):
    """Pure pursuit of the recorded path, that far to its left."""
    way = np.gradient(env.path[:, :2], axis=0)
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
    lane = env.path[:, :2] + beside_m * np.stack([-way[:, 1], way[:, 0]], axis=1)
    own = (np.linalg.inv(world_from_rig) @ np.column_stack([lane, np.full(len(lane), world_from_rig[2, 3]), np.ones(len(lane))]).T).T
    apart = np.linalg.norm(own[:, :2], axis=1)
    ahead = np.flatnonzero((own[:, 0] > 0.0) & (apart > LOOK_AHEAD_M))
    x, y = own[ahead[0] if len(ahead) else -1, :2]
    return math.atan(2.0 * env.wheelbase_m * y / max(x * x + y * y, 1.0))


def room_ahead_m(frame_points, world_from_rig):
    """To the nearest thing in the lane, from the rig's origin."""
    points = frame_points.reshape(-1, 3) - world_from_rig[:3, 3]
    own = points @ world_from_rig[:3, :3]
    own = own[(own[:, 0] > 2.0) & (abs(own[:, 1]) < LANE_M) & (own[:, 2] > GROUND_M) & (own[:, 2] < 2.5)]
    return np.sort(own[:, 0])[SPECKS] if len(own) > SPECKS else math.inf


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("scene")
    parser.add_argument("-o", "--output", required=True, help="a new .mcap file")
    parser.add_argument("--beside", type=float, default=0.5, help="m to the left of the recorded path")
    parser.add_argument("--speed", type=float, default=8.0, help="m/s that it drives where there is room")
    parser.add_argument("--images", default="jpeg", choices=("png", "jpeg", "raw"))
    asked = parser.parse_args()

    scene = simuli.Scene(asked.scene)
    if not scene.lidars:
        parser.error("SCENE: found no LiDAR, allowed a scene with one")
    lidar = next(iter(scene.lidars.values()))
    env = simuli.gym.Drive(scene, [lidar.name])
    _, info = env.reset()
    driven = [(info["time_s"], info["world_from_rig"])]
    while True:
        at = info["world_from_rig"]
        room_m = room_ahead_m(scene.render(lidar, at @ lidar.rig_from_sensor, info["time_s"]).cloud()["xyz"], at)
        safe = math.sqrt(2.0 * COMFORT * max(room_m - FREE_M, 0.0)) if math.isfinite(room_m) else asked.speed
        wanted = (min(asked.speed, safe) - env.speed) / env.step_s
        _, _, terminated, truncated, info = env.step([steering(env, at, asked.beside), min(max(wanted, -8.0), COMFORT)])
        driven.append((info["time_s"], info["world_from_rig"]))
        if terminated or truncated:
            break
    # A log that is nothing but the path.
    with tempfile.TemporaryDirectory() as folder:
        poses = [{"time_ns": START_NS + round(1e9 * time_s), "position_m": pose[:3, 3].tolist(), "rotation_wxyz": quaternion(pose)}
                 for time_s, pose in driven]
        log = {"format": "simuli log", "version": 1, "name": "driven", "start_ns": START_NS, "cameras": [], "lidars": [],
               "world_from_rig": poses, "images": [], "sweeps": []}
        (pathlib.Path(folder) / "log.json").write_text(json.dumps(log))
        times = f"{driven[0][0]}:{driven[-1][0] - lidar.duration_s}:{env.step_s}"
        program.run("render", asked.scene, "--trajectory", folder, "--times", times, "--images", asked.images, "-o", asked.output)
    way_m = sum(np.linalg.norm(b[1][:3, 3] - a[1][:3, 3]) for a, b in zip(driven, driven[1:]))
    print(f"{way_m:.1f} m in {driven[-1][0] - driven[0][0]:.1f} s, {len(driven) - 1} steps; {asked.output} written")


def quaternion(pose):
    """(w, x, y, z) of a pose whose rotation is about the world's up and little else."""
    m = pose[:3, :3]
    w = math.sqrt(max(1.0 + m[0, 0] + m[1, 1] + m[2, 2], 1e-12)) / 2.0
    if w > 0.1:
        return [w, (m[2, 1] - m[1, 2]) / (4 * w), (m[0, 2] - m[2, 0]) / (4 * w), (m[1, 0] - m[0, 1]) / (4 * w)]
    z = math.sqrt(max(1.0 - m[0, 0] - m[1, 1] + m[2, 2], 1e-12)) / 2.0
    return [(m[1, 0] - m[0, 1]) / (4 * z), (m[0, 2] + m[2, 0]) / (4 * z), (m[1, 2] + m[2, 1]) / (4 * z), z]


if __name__ == "__main__":
    main()
