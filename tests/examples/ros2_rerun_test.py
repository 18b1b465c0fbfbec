"""A rendered drive as a recording of ROS 2, as the reader of a viewer, Rerun's, takes it apart.

ros2_rerun_test.py SIMULI EXAMPLES WORK
"""
import collections
import json
import pathlib
import subprocess
import sys

import numpy as np
from PIL import Image
from rerun.chunk import McapReader

simuli, work = sys.argv[1], pathlib.Path(sys.argv[3])


def run(*words):
    return subprocess.run([str(w) for w in words], check=True, capture_output=True, text=True).stdout


def rows_of(recording):
    """(topic, component): [(time in ns since 1970, value)] by time."""
    rows = collections.defaultdict(list)
    for chunk in McapReader(str(recording)).stream().to_chunks():
        batch = chunk.to_record_batch()
        if "message_log_time" not in batch.schema.names:
            continue
        times = batch.column("message_log_time").cast("int64").to_pylist()
        for name in batch.schema.names:
            rows[chunk.entity_path, name] += zip(times, batch.column(name).to_pylist())
    return {key: sorted(values, key=lambda row: row[0]) for key, values in rows.items()}


def seen(rows, topic, component):
    return [value for _, value in rows[topic, component]]


times = ("--times", "0:0.2:0.1")
run(simuli, "synth", "street", "-o", work / "street.log", "--frames", 4, "--image-width", 64, "--image-height", 36,
    "--lidar-columns", 90)
run(simuli, "train", work / "street.log", "-o", work / "street.scene", "--iterations", 2)
run(simuli, "render", work / "street.scene", *times, "-o", work / "street.mcap")
run(simuli, "render", work / "street.scene", *times, "--images", "raw", "-o", work / "raw.mcap")
run(simuli, "render", work / "street.scene", *times, "--sensor", "top", "--clouds", "npz", "--cloud-frame", "sensor",
    "-o", work / "top")
run(simuli, "render", work / "street.scene", *times, "--sensor", "front", "-o", work / "front")
rows, raw = rows_of(work / "street.mcap"), rows_of(work / "raw.mcap")

for k, name in enumerate(sorted((work / "top").glob("*.npz"))):
    cloud = np.load(name)
    points = np.array(seen(rows, "/top/points", "Points3D:positions")[k], np.float32)
    assert np.array_equal(points, cloud["xyz"]) and len(points) > 1000
    assert np.array_equal(seen(rows, "/top/points", "Points3D:ring")[k], cloud["ring"])
    assert np.allclose(seen(rows, "/top/points", "Points3D:intensity")[k], 255 * cloud["intensity"], atol=1e-4)
assert [t - rows["/top/points", "Points3D:ring"][0][0] for t, _ in rows["/top/points", "Points3D:ring"]] == [
    0, 100_000_000, 200_000_000]

pictures = sorted((work / "front").glob("*.png"))
assert len(pictures) == 3
for k, name in enumerate(pictures):
    assert bytes(seen(rows, "/front/image_raw/compressed", "EncodedImage:blob")[k][0]) == name.read_bytes()
    pixels = np.array(seen(raw, "/front/image_raw", "Image:buffer")[k][0], np.uint8)
    assert np.array_equal(pixels.reshape(36, 64, 3), np.asarray(Image.open(name).convert("RGB")))
# A picture lies in the image plane of the pinhole that the calibration makes.
plane, = seen(rows, "/front/camera_info", "Pinhole:child_frame")[0]
assert seen(rows, "/front/image_raw/compressed", "CoordinateFrame:frame") == 3 * [[plane]]
assert seen(rows, "/front/camera_info", "Pinhole:parent_frame")[0] == ["front_optical_frame"]
camera = json.loads(run(simuli, "info", work / "street.log", "front", "--json"))
matrix = np.reshape(seen(rows, "/front/camera_info", "Pinhole:image_from_camera")[0][0], (3, 3)).T
centre = camera["cx_px"] - 0.5, camera["cy_px"] - 0.5  # ROS counts from the first pixel's centre
assert np.allclose(matrix, [[camera["fx_px"], 0, centre[0]], [0, camera["fy_px"], centre[1]], [0, 0, 1]])
assert seen(rows, "/front/camera_info", "Pinhole:resolution")[0] == [[64, 36]]

log = json.loads((work / "street.log" / "log.json").read_text())
mounted = dict(zip((name for name, in seen(rows, "/tf_static", "Transform3D:child_frame")),
                   (place for place, in seen(rows, "/tf_static", "Transform3D:translation"))))
assert np.allclose(mounted["top"], log["lidars"][0]["rig_from_lidar"]["position_m"])
assert np.allclose(mounted["front_optical_frame"], log["cameras"][0]["rig_from_camera"]["position_m"])
assert all(f == ["map"] for f in seen(rows, "/tf", "Transform3D:parent_frame"))
start = rows["/top/points", "Points3D:ring"][0][0]  # time 0 of the log
path = {time - start: place for time, (place,) in rows["/tf", "Transform3D:translation"]}
knots = [pose for pose in log["world_from_rig"] if pose["time_ns"] in path]
assert len(knots) > 20
for pose in knots:
    assert np.allclose(path[pose["time_ns"]], pose["position_m"], atol=1e-5)
