"""A rendered drive as MCAP and back: mcap_test.py SIMULI EXAMPLES WORK"""
import pathlib
import subprocess
import sys

import numpy as np
from mcap.reader import make_reader

simuli, examples, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])


def run(*words):
    subprocess.run([str(w) for w in words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


run(simuli, "synth", "street", "-o", work / "street.log", "--frames", 4, "--image-width", 64, "--image-height", 36,
    "--lidar-columns", 90)
run(simuli, "train", work / "street.log", "-o", work / "street.scene", "--iterations", 2)
for name, extra in (("front", ()), ("top", ("--clouds", "npz"))):
    run(simuli, "render", work / "street.scene", "--sensor", name, "--times", "0:0.2:0.1", "-o", work / name, *extra)
run(sys.executable, examples / "to_mcap.py", work / "street.scene", work / "street.mcap", "0:0.2:0.1", work / "front",
    work / "top")
topics = {}
with open(work / "street.mcap", "rb") as file:
    for schema, channel, message in make_reader(file).iter_messages():
        topics.setdefault((channel.topic, schema.name), []).append(message)
assert len(topics["/front/image", "foxglove.CompressedImage"]) == 3, topics.keys()
assert len(topics["/front/calibration", "foxglove.CameraCalibration"]) == 3
clouds = topics["/top/points", "foxglove.PointCloud"]
assert len(clouds) == 3 and clouds[1].log_time - clouds[0].log_time == 100_000_000
points = np.load(sorted((work / "top").glob("*.npz"))[0])["xyz"]
assert len(clouds[0].data) > 24 * len(points) and points[0].astype("<f4").tobytes() in clouds[0].data
assert len(topics["/actors", "foxglove.SceneUpdate"]) > 2 and len(topics["/tf", "foxglove.FrameTransform"]) > 20
