"""import simuli, as a user would: python_test.py LOG WORK PROGRAM"""
import filecmp
import gc
import json
import os
import pickle
import pathlib
import struct
import subprocess
import sys
import threading
import time
import warnings

import numpy as np
import simuli

log, work, program = sys.argv[1:4]
folder = os.path.join(work, "python.scene")
print("NumPy", np.__version__)


def refused(call, part):
    """Whether that is an error of one line that names `part`."""
    try:
        call()
    except simuli.Error as error:
        assert "\n" not in str(error) and part in str(error), error
    else:
        raise AssertionError("nothing was raised for " + part)


# Training is that of the command, and so are the numbers of an evaluation.
seen = []
settings = ["iterations=5", "image_scale=1"]
report = simuli.train(log, folder, settings=settings, progress=lambda i, psnr: seen.append(i))
assert seen == [1, 2, 3, 4, 5], seen
assert np.isfinite(report["train_psnr_db"])
theirs = os.path.join(work, "command.scene")
subprocess.run([program, "train", log, "-o", theirs, "--iterations", "5", "--scale", "1"], check=True,
               capture_output=True)
for file in ("camera.ply", "lidar.ply", "scene.json"):
    assert filecmp.cmp(os.path.join(folder, file), os.path.join(theirs, file), shallow=False), file
said = json.loads(subprocess.run([program, "eval", theirs, log, "--json"], check=True, capture_output=True).stdout)
found = simuli.evaluate(folder, log)
for name in ("psnr_db", "ssim", "distance_median_m", "intensity_rmse", "raydrop_accuracy",
             "raydrop_trivial", "drop_recall", "drop_precision", "chamfer_m"):
    assert found[name] == said[name], (name, found[name], said[name])
assert found["frames"] == said["frames"] == "held_out"


def same_keys(ours, json_value, place, only_json=()):
    """Whether both have the same keys, at every depth."""
    if isinstance(ours, dict) and isinstance(json_value, dict):
        assert ours.keys() == json_value.keys() - set(only_json), (place, ours.keys() ^ json_value.keys())
        for key in ours:
            same_keys(ours[key], json_value[key], f"{place}.{key}")
    elif isinstance(ours, list) and isinstance(json_value, list):
        assert len(ours) == len(json_value), place
        for i, pair in enumerate(zip(ours, json_value)):
            same_keys(*pair, f"{place}[{i}]")


same_keys(found, said, "eval", only_json=["training"])
assert [r["returns"] for r in found["ranges"]] == [r["returns"] for r in said["ranges"]]
assert found["between"] is found["middle"] is found["beyond"] is None  # all that was held out is between training frames
simuli.train(log, os.path.join(work, "end.scene"), settings=settings + ["held_out_every=3", "held_out_last=0.3"])
both = simuli.evaluate(os.path.join(work, "end.scene"), log)
end = simuli.evaluate(os.path.join(work, "end.scene"), log, settings=["held_out_last=0.3"])
assert both["beyond"]["psnr_db"] == end["psnr_db"] and both["between"]["images"] + end["images"] == both["images"]


class Enough(Exception):
    pass


def stop(iteration, psnr):
    raise Enough()


try:
    simuli.train(log, os.path.join(work, "none.scene"), progress=stop)
except Enough:
    assert not os.path.exists(os.path.join(work, "none.scene"))
else:
    raise AssertionError("an exception of the callback was lost")

scene = simuli.Scene(pathlib.Path(folder))
refused(lambda: simuli.evaluate(pathlib.Path(folder), pathlib.Path("no.log")), "no.log")
refused(lambda: simuli.sensor(pathlib.Path("no.json")), "no.json")
refused(lambda: scene.render(pathlib.Path("no.json")), "no.json")
assert scene.device in simuli.devices()
(name, camera), = scene.cameras.items()
height, width = camera.shape
start_s, end_s = scene.span
recorded = scene.recorded_frames[name]
assert len(recorded) == 6 and all(start_s <= start <= end for start, end in recorded), recorded

# Frames: the same wherever the pose comes from; arrays are the frame's own memory and keep it alive.
frame = scene.render(name, time_s=start_s)
image = frame.image
assert image.shape == (height, width, 3) and image.dtype == np.float32 and image.std() > 0.02
assert not image.flags.owndata and not image.flags.writeable
pose = scene.world_from_rig(start_s) @ camera.rig_from_sensor
assert np.array_equal(scene.render(name, pose, start_s).image, image)
assert np.array_equal(scene.render(camera, pose[:3].tolist(), start_s).image, image)
assert np.shares_memory(frame.transmittance, frame.transmittance)  # no copies
kept = frame.transmittance
before = kept.copy()
del frame
gc.collect()
for i in range(3):
    scene.render(name, time_s=end_s - 0.2).wait()
assert np.array_equal(kept, before)
frame = scene.render(name, time_s=start_s)
assert np.allclose(frame.opacity, 1 - kept)
opaque = frame.opacity > 0.9
assert opaque.any() and (frame.distance_m[opaque] > 0.5).all()
assert (frame.median_m[opaque] > 0.5).all() and frame.median_m.shape == (height, width)

(lidar, sensor), = scene.lidars.items()
sweep = scene.render(lidar, time_s=start_s)
assert sweep.range_m.shape == sensor.shape and sweep.points_m.shape == (*sensor.shape, 3)
assert sweep.points_m.dtype == np.float64
hit = sweep.range_m > 0
assert 0.2 < hit.mean() <= 1.0 and np.isfinite(sweep.points_m).all()
assert scene.render("velodyne_vlp16", time_s=start_s).drop.shape[0] == 16

# Where and when, and other libraries' tensors on the same memory.
assert np.allclose(frame.world_from_sensor, pose) and np.allclose(frame.world_from_sensor_end, pose)
assert frame.span == (start_s, start_s) and sweep.span[1] - sweep.span[0] == sensor.duration_s
assert repr(frame) == f'<simuli.Frame: camera "{name}", {width} x {height}, at {start_s:.3f} s>'
for of, at in ((frame, "image"), (frame, "depth_m"), (frame, "normals"), (frame, "median_m"), (sweep, "range_m"), (sweep, "drop")):
    tensor = np.from_dlpack(of.tensor(at))
    assert np.shares_memory(tensor, getattr(of, at)) and np.array_equal(tensor, getattr(of, at)), at
assert np.shares_memory(np.from_dlpack(frame), frame.image) and np.shares_memory(np.from_dlpack(sweep), sweep.range_m)
assert frame.__dlpack_device__() == (1, 0)
for version, kind in ((None, '"dltensor"'), ((0, 8), '"dltensor"'), ((1, 0), '"dltensor_versioned"')):
    assert kind in repr(frame.__dlpack__(max_version=version)), version  # one that nobody takes goes by itself
for wrong in ({"stream": 1}, {"dl_device": (2, 0)}, {"copy": True}):
    try:
        frame.__dlpack__(**wrong)
    except BufferError as error:
        assert "allowed" in str(error), error
    else:
        raise AssertionError(wrong)
refused(lambda: frame.tensor("actors"), 'tensor: found "actors"')
refused(lambda: frame.tensor("range_m"), "")
held = np.from_dlpack(scene.render(name, time_s=start_s).tensor("image"))
gc.collect()
assert np.array_equal(held, image)  # its memory lives as long as it
thread = threading.Thread(target=held.sum)
del held
thread.start()  # the last owner may be another thread's
thread.join()
del thread

# The drive as it was recorded.
drive = simuli.Log(pathlib.Path(log))
assert drive.cameras == {name: camera} and drive.lidars[lidar].shape == sensor.shape and drive.span == scene.span
assert drive.recorded_frames[name] == recorded and len(drive.recorded_frames[lidar]) == 6 and drive.start_ns == 0
assert [actor["name"] for actor in drive.actors] == [actor["name"] for actor in scene.actors]
assert repr(drive) == '<simuli.Log: "street", 6 pictures, 6 sweeps, 1 actors>', repr(drive)
picture, begin_s = drive.image(name, 5), drive.recorded_frames[name][5][0]
assert picture.shape == (height, width, 3) and not np.array_equal(picture, drive.image(name, 4))
assert np.corrcoef(picture.ravel(), scene.render(name, time_s=begin_s).image.ravel())[0, 1] > 0.7
recorded_sweep, seen = drive.sweep(lidar, 5), scene.render(lidar, time_s=drive.recorded_frames[lidar][5][0])
both = (recorded_sweep["range_m"] > 0) & (seen.range_m > 0)
off_m = abs(recorded_sweep["range_m"] - seen.range_m)[both], np.linalg.norm(recorded_sweep["points_m"] - seen.points_m, axis=2)[both]
assert both.mean() > 0.2 and max(np.median(off) for off in off_m) < 0.2, [np.median(off) for off in off_m]
assert np.allclose(recorded_sweep["time_s"], seen.time_s, atol=1e-6) and 0 < recorded_sweep["intensity"].max() <= 1
assert np.allclose(drive.world_from_rig(start_s)[3], [0, 0, 0, 1])
for index in (6, -1):
    refused(lambda: drive.image(name, index), "allowed 0 to 5 of " + name)
refused(lambda: drive.sweep("rear", 0), "rear")
refused(lambda: drive.image(lidar, 0), lidar)
refused(lambda: drive.world_from_rig(float("nan")), "time_s")
refused(lambda: simuli.Log(folder), "found a scene, allowed a log")

# Clouds: the returns, in the frame asked for, with beam and time.
cloud = sweep.cloud()
assert cloud["xyz"].dtype == np.float64 and np.array_equal(cloud["xyz"], sweep.points_m[hit])
assert cloud["ring"].dtype == np.uint16 and np.array_equal(cloud["ring"], np.nonzero(hit)[0])
assert cloud["time"].dtype == np.float32 and np.allclose(cloud["time"], sweep.time_s[hit], atol=1e-7)
assert np.array_equal(cloud["range"], sweep.range_m[hit]) and 0.05 < sweep.time_s.max() < 0.11
own = sweep.cloud("sensor")
# Ranges are as the sensor states them: off by one and the same of each row (its range bias, which training learns).
off_m = np.linalg.norm(own["xyz"], axis=1) - own["range"]
assert all(np.ptp(off_m[own["ring"] == ring]) < 1e-3 for ring in np.unique(own["ring"])) and abs(off_m).max() < 0.1
assert not np.allclose(own["xyz"], sweep.cloud(frame="sensor_start")["xyz"], atol=1e-3)
refused(lambda: sweep.cloud("rig"), "sensor_start")

# Depth along the axis, normals, who is seen.
assert (frame.depth_m[opaque] <= frame.median_m[opaque]).all()
assert (frame.mean_depth_m[opaque] <= frame.distance_m[opaque]).all()
assert np.allclose(frame.depth_m[height // 2, width // 2], frame.median_m[height // 2, width // 2], rtol=1e-2)
lengths = np.linalg.norm(frame.normals, axis=2)
assert frame.normals.shape == (height, width, 3) and np.allclose(lengths[lengths > 0], 1, atol=1e-5)
refused(lambda: frame.actors, "actors")
for at in (name, lidar):
    who = scene.render(at, time_s=start_s, actors=True).actors
    assert who.dtype == np.uint32 and 0 <= who.max() <= len(scene.actors), at
assert scene.render_batch(lidar, [start_s], actors=True)[0].actors.max() <= len(scene.actors)

# Labels of who is seen, and where what is seen goes to.
now, later = (scene.render(name, time_s=t, actors=True) for t in (start_s, start_s + 0.1))
for label in scene.labels(now):
    assert label["pixels"] == (now.actors == label["actor"]).sum() and label["world_from_actor"].shape == (4, 4)
    assert label["occlusion"] is None or 0 <= label["occlusion"] <= 1
    assert (label["visible_px"] is None) == (label["pixels"] == 0) and 0 <= label["truncation"] <= 1
assert all(label["returns"] >= 0 for label in scene.labels(scene.render(lidar, time_s=start_s, actors=True)))
pixels, points = scene.flow(now, now)
assert pixels.shape == points.shape == (height, width, 3) and pixels.dtype == np.float32
assert abs(pixels[..., :2]).max() < 1e-3 and abs(points).max() < 1e-3  # to itself: nowhere
assert abs(scene.flow(now, later)[0][..., :2]).max() > 0.1
refused(lambda: scene.labels(frame), "actors")
refused(lambda: scene.flow(frame, later), "actors")
refused(lambda: simuli.Scene(folder).labels(now), "another scene")

# Some rays alone: the same there, nothing elsewhere.
for which, whole, quantity in ((name, frame, "distance_m"), (lidar, sweep, "range_m")):
    whole = getattr(whole, quantity)
    some = np.arange(whole.size).reshape(whole.shape) % 3 == 0
    assert (whole[some] > 0).any() and (whole[~some] > 0).any()
    part = getattr(scene.render(which, time_s=start_s, rays=some), quantity)
    assert np.array_equal(part, np.where(some, whole, 0)), which
    part, = scene.render_batch(which, [start_s], rays=some.astype(np.uint8))
    assert np.array_equal(getattr(part, quantity), np.where(some, whole, 0)), which
    refused(lambda: scene.render(which, time_s=start_s, rays=some[1:]), "rays")

# Batches, sensors of one's own, qualities.
times = np.linspace(start_s, start_s + 0.2, 3)
batch = scene.render_batch(name, times)
assert np.array_equal(batch[0].image, image) and not np.array_equal(batch[2].image, image)
poses = np.stack([pose] * 3)
assert np.array_equal(scene.render_batch(name, times, poses)[2].image, scene.render(name, pose, times[2]).image)
own = simuli.camera("own", 32, 18, 20.0, 20.0, 16.0, 9.0)
placed = own.mounted(camera.rig_from_sensor)
assert scene.render(placed, time_s=start_s).image.shape == (18, 32, 3)
# One that was never mounted stands where the first of its kind does.
assert np.array_equal(scene.render(own, time_s=start_s).image, scene.render(placed, time_s=start_s).image)
assert np.array_equal(scene.render_batch(own, times)[2].image, scene.render(placed, time_s=times[2]).image)
assert np.array_equal(scene.render(simuli.sensor("tum_vi_cam0"), time_s=start_s).image,
                      scene.render("tum_vi_cam0", time_s=start_s).image)
assert np.array_equal(scene.render(simuli.sensor("velodyne_vlp16"), time_s=start_s).range_m,
                      scene.render("velodyne_vlp16", time_s=start_s).range_m)
beams = simuli.lidar("two", np.radians([2.0, -2.0]), 90)
assert scene.render(beams, scene.world_from_rig(start_s), start_s).range_m.shape == (2, 90)
scene.add_sensor(own)
assert "own" in scene.cameras and np.allclose(scene.cameras["own"].rig_from_sensor, camera.rig_from_sensor)
draft = simuli.Scene(folder, quality="draft", settings=["render.alpha_cut=0.1"])
assert not np.array_equal(draft.render(name, time_s=start_s).image, image)

# Actors.
actors = [actor["name"] for actor in scene.actors]
assert actors, "the street has a car"
car = actors[0]
when = scene.actors[0]["times_s"][len(scene.actors[0]["times_s"]) // 2]
there = scene.render(lidar, time_s=when).range_m
assert not np.array_equal(scene.render(lidar, time_s=when, edits=[simuli.remove(car)]).range_m, there)
assert np.array_equal(scene.render(lidar, time_s=when).range_m, there)
twins = simuli.Scene(folder)
twins.duplicate_actor(car, "second")
twins.duplicate_actor("second", "third")  # the copy of a copy counts as its original
strangers = simuli.Scene(folder)
strangers.duplicate_actor(car, "third")
strangers.edit(simuli.remove("third"))  # the name is free for an actor without a recording
strangers.add_actor(simuli.Scene(folder), car, "third")
for one, removed in ((twins, "second"), (twins, car), (strangers, car)):
    one.edit(simuli.remove(removed))
twin, stranger = (one.render(lidar, time_s=when) for one in (twins, strangers))
assert np.array_equal(twin.range_m, stranger.range_m)
recorded = strangers.support(stranger, copies={"third": car})
assert np.array_equal(twins.support(twin), recorded)
assert not np.array_equal(strangers.support(stranger), recorded)
scene.duplicate_actor(car, "second")
scene.edit(simuli.move("second", [0, 3, 0]))
scene.edit(simuli.turn("second", 0.5))
scene.edit(simuli.retime("second", 2.0, 0.1))
assert not np.array_equal(scene.render(lidar, time_s=when).range_m, there)
scene.resize_actor("second", 1.5)
assert np.allclose(scene.actors[-1]["size_m"], 1.5 * np.array(scene.actors[0]["size_m"]))
assert scene.mirror_actor("second", recorded=car) in (True, False)
assert scene.mirror_actor("second") in (True, False)  # by default the sides of its original
refused(lambda: scene.mirror_actor("nobody"), "nobody")
refused(lambda: scene.resize_actor("second", 0.0), "resize second")
assert repr(scene).startswith('<simuli.Scene: "street", 2 cameras, 1 LiDARs, 2 actors, on '), repr(scene)
scene.edit(simuli.remove("second"))
assert np.array_equal(scene.render(lidar, time_s=when).range_m, there)
scene.edit(simuli.remove(car))
scene.add_actor(draft, car, "again")
base = np.eye(4)
base[:3, 3] = scene.world_from_rig(start_s)[:3, 3] + [6.0, 0.0, 0.0]
scene.add_object(draft, "statue", base)
scene.resize_actor("statue", 0.01)  # all of the street
statue = scene.actors[-1]
assert statue["kind"] == "object" and np.allclose(np.array(statue["world_from_actor"])[0][:2, 3], base[:2, 3])
refused(lambda: scene.add_object(draft, "statue", base), "statue")
refused(lambda: scene.add_object(draft, "other", base.T), "world_from_base")
edited = os.path.join(work, "edited.scene")
scene.save(edited)
assert [actor["name"] for actor in simuli.Scene(edited).actors] == actors[1:] + ["again", "statue"]

# Gradients by ray, against a difference; zeros for what is not seen.
scene = simuli.Scene(folder)
frame = scene.render(lidar, time_s=start_s)
weights = np.cos(np.arange(frame.transmittance.size)).reshape(frame.transmittance.shape)
gradients = scene.gradients(frame, transmittance=weights)
particles = scene.particles(lidar=True)
assert gradients.shape == particles.shape and gradients.dtype == np.float32
assert (gradients == 0).all(axis=1).any() and np.isfinite(gradients).all()
most = int(np.abs(gradients[:, 10]).argmax())
losses = []
for step in (0.02, -0.02):
    moved = particles.copy()
    moved[most, 10] += step
    scene.set_particles(moved, lidar=True)
    losses.append(float((weights * scene.render(lidar, time_s=start_s).transmittance.astype(float)).sum()))
slope = (losses[0] - losses[1]) / 0.04
assert abs(slope - gradients[most, 10]) < 0.05 * abs(slope), (slope, gradients[most, 10])
scene.set_particles(particles, lidar=True)

# The GIL is free while the device works: another thread counts meanwhile.
counted = [0]
done = threading.Event()


def count():
    while not done.is_set():
        counted[0] += 1
        time.sleep(1e-4)


thread = threading.Thread(target=count)
thread.start()
simuli.train(log, os.path.join(work, "busy.scene"), settings=["iterations=1"])
done.set()
thread.join()
assert counted[0] > 20, counted

particles = scene.particles()
hidden = particles.copy()
hidden[:, 10] = -20.0  # opacity logits: nothing is left but what stands behind
scene.set_particles(hidden)
assert scene.render(name, time_s=start_s).opacity.max() < 1e-3
scene.set_particles(particles)

nan = float("nan")
names = ["x", "y", "z", *(f"f_dc_{i}" for i in range(3)), "opacity", *(f"scale_{i}" for i in range(3)),
         *(f"rot_{i}" for i in range(4))]
pathlib.Path(work, "broken.ply").write_text(
    "ply\nformat ascii 1.0\nelement vertex 2\n" + "".join(f"property float {name}\n" for name in names)
    + "end_header\n" + "1 2 3 4 5 6 7 8 9 10 1 0 0 0\n" + "1 2 nan 4 5 6 7 8 9 10 1 0 0 0\n")
pathlib.Path(work, "flagged.spz").write_bytes(struct.pack("<4s2I4B19x", b"NGSP", 2, 1, 0, 12, 1, 0))
with warnings.catch_warnings(record=True) as told:
    warnings.simplefilter("always")
    assert simuli.Scene(os.path.join(work, "broken.ply")).left_out == 1 and scene.left_out == 0
    simuli.Scene(os.path.join(work, "flagged.spz"))
assert [str(w.message).partition(work + "/")[2] for w in told] == [
    "broken.ply: left out: 1 particles with NaN, Inf or a zero quaternion",
    "flagged.spz: trained antialiased: render.camera_compensation=true renders it so"], told
refused(lambda: simuli.Scene("/nowhere"), "/nowhere")
refused(lambda: simuli.Scene(folder, quality="best"), "quality")
refused(lambda: simuli.Scene(folder, settings=["render.alpha_cut=7"]), "render.alpha_cut")
refused(lambda: simuli.Scene(folder, device="no such device"), "no such device")
refused(lambda: scene.render("rear"), "rear")
refused(lambda: scene.render(name, np.eye(3)), "4 x 4")
refused(lambda: scene.render(name, np.full((4, 4), nan)), "found NaN")
refused(lambda: scene.render(name, pose.astype(complex)), "real numbers")
refused(lambda: scene.render(name, [[1, 2], [3]]), "real numbers")
refused(lambda: scene.render(name, pose, nan), "time_s")
refused(lambda: scene.render(name, time_s=nan), "time_s")
refused(lambda: scene.render(name, pose, 1.0, duration_s=-1.0), "duration_s")
refused(lambda: scene.render(name, pose, 1.0, duration_s=nan), "duration_s")
refused(lambda: scene.render(7), "sensor")
refused(lambda: scene.render_batch(name, times, poses[:2]), "time_s")
refused(lambda: scene.set_particles(particles[:, 1:]), "particles")
refused(lambda: scene.set_particles(np.where(np.arange(particles.shape[1]) == 3, nan, particles)), "particles")
refused(lambda: scene.set_particles(np.zeros(particles.shape, dtype="U1")), "real numbers")
refused(lambda: scene.gradients(frame, transmittance=[1.0]), "transmittance")
refused(lambda: scene.edit(simuli.remove("nobody")), "nobody")
for text in ("a\nb", "\x1b[2J", "\u202egpj", "a\r\0"):
    for call in (lambda: simuli.sensor(text), lambda: scene.render(text), lambda: scene.edit(simuli.remove(text)),
                 lambda: simuli.Scene(folder, quality=text), lambda: simuli.Scene(folder, settings=[text]),
                 lambda: simuli.Device(text), lambda: scene.duplicate_actor(text, "b"), lambda: frame.tensor(text),
                 lambda: simuli.camera("a", 1, 1, 1, 1, 1, 1, lens=text), lambda: simuli.lidar("a", [0.1], 4, spin=text)):
        try:
            call()
        except simuli.Error as error:
            assert str(error).isprintable(), error
        except (TypeError, ValueError):  # what no path holds
            assert "\0" in text
        else:
            raise AssertionError(text)
for call in (lambda: simuli.camera("../x", 1, 1, 1, 1, 1, 1), lambda: simuli.lidar("a\nb", [0.0], 4),
             lambda: camera.named("../y")):
    refused(call, "sensor: name: found")
# Sensors and edits are values: they are equal, have a text, and edits go to other processes.
same = simuli.camera("own", 32, 18, 20.0, 20.0, 16.0, 9.0)
assert same == simuli.camera("own", 32, 18, 20.0, 20.0, 16.0, 9.0) and len({same, same.named("own")}) == 1
assert same != same.named("other") and same != same.with_duration(0.1) and same != 7 and same != simuli.sensor("hesai_xt32")
assert repr(same) == '<simuli.Sensor: camera "own", 32 x 18 px>' and same.K.tolist() == [[20, 0, 16], [0, 20, 9], [0, 0, 1]]
bent = simuli.camera("bent", 64, 36, 30, 31, 32, 18, lens="opencv_fisheye", parameters=[0.01, 0, 0, 0, 1.5],
                     shutter="top_to_bottom", duration_s=0.03)
assert (bent.lens, bent.shutter, bent.lens_parameters["k1"]) == ("opencv_fisheye", "top_to_bottom", 0.01)
assert (same.lens, same.shutter, same.lens_parameters) == ("pinhole", "global", {})
assert np.allclose(sensor.elevation_rad, np.sort(sensor.elevation_rad)[::-1]) and len(sensor.elevation_rad) == sensor.shape[0]
assert np.allclose(same.project([[1, 2, 4], [0, 0, 1]]), [[21, 19], [16, 9]])
assert np.isnan(same.project([[0, 0, -1], [nan, 0, 1]])).all() and same.project(np.zeros((0, 3))).shape == (0, 2)
pixels = np.array([[3.5, 30.0], [60.0, 2.0], [32.0, 18.0]])
rays = bent.unproject(pixels)
assert np.allclose(np.linalg.norm(rays, axis=1), 1) and np.allclose(bent.project(7 * rays), pixels, atol=1e-9)
assert np.isnan(bent.unproject([[1e4, 0]])).all()
refused(lambda: same.project([1, 2, 3]), "points_m")
refused(lambda: same.unproject(np.zeros((2, 3))), "pixels")
for wrong in ("lens", "shutter", "K", "lens_parameters"):
    refused(lambda: getattr(sensor, wrong), "")
refused(lambda: same.elevation_rad, "")
for value in (same, bent, bent.mounted(pose).named("other"), camera, sensor, sensor.with_duration(0.2), simuli.sensor("hesai_xt32@20")):
    again = pickle.loads(pickle.dumps(value))
    assert again == value and hash(again) == hash(value) and again.duration_s == value.duration_s, value
    assert np.array_equal(again.rig_from_sensor, value.rig_from_sensor)
refused(lambda: simuli.Sensor.__new__(simuli.Sensor).__setstate__(("{}", "a", 0.0, [0.0] * 7)), "")
assert "simuli.Device: " in repr(simuli.Device())
edits = [simuli.remove("a"), simuli.move("a", [0.1, 1 / 3, 3]), simuli.turn("a", 0.1), simuli.retime("a", 2.0, 1 / 3),
         simuli.retrack("a", [0.1, 0.2], [np.eye(4), np.eye(4)])]
assert [repr(edit).split()[1] for edit in edits] == ["remove", "move", "turn", "retime", "retrack"]
for edit in edits:
    assert pickle.loads(pickle.dumps(edit)) == edit and sum(edit == other for other in edits) == 1
assert edits[1] != simuli.move("b", [0.1, 1 / 3, 3]) and edits[1].actor == "a"
refused(lambda: simuli.Edit.__new__(simuli.Edit).__setstate__(("a", 1, [0.0])), "state")
for kind, member in ((simuli.Scene, "particles"), (simuli.Frame, "image"), (simuli.Sensor, "name"), (simuli.Device, "name"),
                     (simuli.Log, "name")):
    try:
        getattr(kind.__new__(kind), member)
    except TypeError as error:
        assert "__init__() has not made" in str(error), error
    else:
        raise AssertionError(kind)
refused(lambda: simuli.train(log, folder, settings=["no.such=1"]), "no.such")
refused(lambda: simuli.train(log, folder, settings=["no\0such=1"]), "no\\x00such")
before = os.stat(os.path.join(folder, "camera.ply")).st_ino
refused(lambda: simuli.train(log, folder, settings=["iterations=1"], progress=lambda i, psnr: 1 / 0), "not exist yet")
mine = os.path.join(work, "mine")
os.mkdir(mine)
open(os.path.join(mine, "notes.txt"), "w").close()
for overwrite in (False, True):
    refused(lambda: simuli.train(log, mine, progress=lambda i, psnr: 1 / 0, overwrite=overwrite), "mine")
assert os.listdir(mine) == ["notes.txt"] and os.stat(os.path.join(folder, "camera.ply")).st_ino == before
refused(lambda: simuli.Scene(folder).render(name, np.full((4, 4), nan), 1.0), "found NaN")
refused(lambda: simuli.train(log, folder, settings=["iterations=-1"]), "iterations")

example = os.path.join(os.path.dirname(__file__), "..", "..", "examples", "sweep.py")
out = subprocess.run([sys.executable, example, folder, "velodyne_vlp16"], cwd=work, check=True, text=True,
                     capture_output=True).stdout
assert "rays of velodyne_vlp16 returned" in out, out

# The program, for what has no call of its own.
from simuli import program as command
assert command.run("--version").split()[1] == simuli.__version__
assert command.run("info", pathlib.Path(folder), as_json=True) == json.loads(command.run("--json", "info", folder))
refused(lambda: command.run("info", "nowhere.scene"), "nowhere.scene")
refused(lambda: command.run("no such command"), "")

# What is no pose, and edits that are no list, in words.
eye, edit = np.eye(4), simuli.remove("car")
moved = np.array([[1, 0, 0, 5], [0, 1, 0, -2], [0, 0, 1, 1], [0, 0, 0, 1.0]])
for wrong in (moved.T, np.vstack([eye[:3], [1, 2, 3, 4]]), np.vstack([eye[:3], [0, 0, 0, 2]]), -eye):
    refused(lambda: scene.render(name, world_from_sensor=wrong), "world_from_sensor" if wrong[3, 3] > 0 else "")
    refused(lambda: camera.mounted(wrong), "allowed 0 0 0 1" if wrong[3, 3] > 0 else "")
    refused(lambda: simuli.retrack("car", [0.4, 0.5], [eye, wrong]), "")
    refused(lambda: scene.render_batch(name, [0.1], world_from_sensor=[wrong]), "")
refused(lambda: camera.mounted(np.full((4, 4), np.nan)), "rig_from_sensor: found NaN")
for edits in (edit, (e for e in [edit]), "car", [edit, "car"], None):
    refused(lambda: scene.render(name, time_s=start_s, edits=edits), "allowed a list of Edits")
    refused(lambda: scene.render_batch(name, [start_s], edits=edits), "allowed a list of Edits")
scene.render(name, time_s=start_s, edits=(edit,))
