"""The road of an exported drive as CARLA's own map reads it: export_road_test.py SIMULI EXAMPLES WORK"""
import json
import math
import pathlib
import sys
import zipfile

import carla
from export_scene import run, scene

simuli, work = sys.argv[1], pathlib.Path(sys.argv[3])
drive = scene(simuli, work)
run(simuli, "export", drive, "--drive", "-o", work / "street.usdz")
archive = zipfile.ZipFile(work / "street.usdz")
road = carla.Map("street", archive.read("map.xodr").decode())
rig = json.loads(archive.read("rig_trajectories.json"))["rig_trajectories"][0]["T_rig_worlds"]
off = height = 0.0
for pose in rig:
    x, y, z = (row[3] for row in pose[:3])
    here = road.get_waypoint(carla.Location(x=x, y=-y, z=z))  # left-handed there
    place = here.transform.location
    assert here.lane_id == -1 and abs(here.lane_width - 3.5) < 1e-6, here
    off, height = max(off, math.hypot(place.x - x, place.y + y)), max(height, abs(place.z))
    heading = -math.degrees(math.atan2(pose[1][0], pose[0][0]))
    assert abs((here.transform.rotation.yaw - heading + 180) % 360 - 180) < 5, (here, heading)
ends = {(a.lane_id, b.lane_id) for a, b in road.get_topology()}
print(f"poses up to {100 * off:.2f} cm from the middle of their lane; the street, which lies at 0, at {height:.3f} m")
assert off < 0.05 and height < 0.05 and ends == {(-1, -1), (1, 1)}, ends
