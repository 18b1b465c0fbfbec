"""import simuli, as a user would: python_test.py LOG WORK"""
import os
import subprocess
import sys

import numpy as np
import simuli

log, work = sys.argv[1:3]
folder = os.path.join(work, "python.scene")

seen = []
report = simuli.train(log, folder, iterations=5, image_scale=1.0, progress=lambda i, psnr: seen.append(i))
assert seen == [1, 2, 3, 4, 5], seen
assert np.isfinite(report["psnr_db"])

scene = simuli.Scene(folder)
assert scene.device in simuli.devices()
(name, (height, width)), = scene.cameras.items()
start_s, end_s = scene.span
image = scene.render_camera(name, time_s=start_s)
assert image.shape == (height, width, 3) and image.dtype == np.float32 and image.std() > 0.02
pose = scene.world_from_rig(start_s) @ scene.rig_from_sensor(name)
assert np.array_equal(scene.render_camera(name, pose, start_s), image)
assert np.array_equal(scene.render_camera(name, pose[:3].tolist(), start_s), image)

(lidar, shape), = scene.lidars.items()
sweep = scene.render_lidar(lidar, time_s=start_s)
assert sweep["range_m"].shape == shape and sweep["points_m"].shape == (*shape, 3)
hit = sweep["range_m"] > 0
assert 0.2 < hit.mean() <= 1.0 and np.isfinite(sweep["points_m"]).all()
assert scene.render_lidar("velodyne_vlp16", time_s=start_s)["drop"].shape[0] == 16

particles = scene.particles()
particles[:, 10] = -20.0  # opacity logits: nothing is left but the background
scene.set_particles(particles)
assert scene.render_camera(name, time_s=start_s).std(axis=(0, 1)).max() < 1e-3

for call in (
    lambda: simuli.Scene("/nowhere"),
    lambda: scene.render_camera("rear"),
    lambda: scene.render_camera(name, np.eye(3)),
    lambda: scene.set_particles(particles[:, 1:]),
):
    try:
        call()
    except simuli.Error as error:
        assert "\n" not in str(error), error
    else:
        raise AssertionError("nothing was raised")

example = os.path.join(os.path.dirname(__file__), "..", "..", "examples", "sweep.py")
out = subprocess.run([sys.executable, example, folder, "velodyne_vlp16"], cwd=work, check=True, text=True,
                     capture_output=True).stdout
assert "rays of velodyne_vlp16 returned" in out, out
