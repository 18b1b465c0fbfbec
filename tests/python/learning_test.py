"""simuli.torch and simuli.gym: learning_test.py SCENE WORK. Of torch and gymnasium that are not there as much is made up as they use."""
import importlib.util
import os
import pickle
import sys
import types

import numpy as np


class Tensor(np.ndarray):
    def permute(self, *axes):
        return self.transpose(axes)


def made_up(name, **has):
    sys.modules[name] = types.ModuleType(name)
    vars(sys.modules[name]).update(has)
    return sys.modules[name]


class Env:
    def reset(self, *, seed=None, options=None):
        self.np_random = np.random.default_rng(seed)


class Box:
    def __init__(self, low, high, shape=None, dtype=np.float32):
        self.low, self.high = np.asarray(low, dtype), np.asarray(high, dtype)
        self.shape, self.dtype = shape or self.low.shape, dtype

    def contains(self, x):
        return x.shape == self.shape and x.dtype == self.dtype and (x >= self.low).all() and (x <= self.high).all()


class Dict(dict):
    def contains(self, x):
        return set(x) == set(self) and all(space.contains(x[name]) for name, space in self.items())


if importlib.util.find_spec("torch") is None:
    print("made up: torch")
    data = made_up("torch.utils.data", Dataset=object)
    made_up("torch", from_numpy=lambda a: a.view(Tensor), from_dlpack=lambda a: np.from_dlpack(a).view(Tensor),
            utils=made_up("torch.utils", data=data))
if importlib.util.find_spec("gymnasium") is None:
    print("made up: gymnasium")
    made_up("gymnasium", Env=Env, spaces=made_up("gymnasium.spaces", Box=Box, Dict=Dict))

import simuli
import simuli.gym
import simuli.torch


def refused(call, part):
    try:
        call()
    except simuli.Error as error:
        assert part in str(error), error
    else:
        raise AssertionError("nothing was raised for " + part)


folder = sys.argv[1]
scene = simuli.Scene(folder)
(name, camera), = scene.cameras.items()
(lidar, sensor), = scene.lidars.items()
height, width = camera.shape

# A data set: what render() and labels() give, as tensors.
frames = simuli.torch.Frames(folder, name)
assert len(frames) == len(scene.recorded_frames[name])
for index in (0, len(frames) - 1):
    item = frames[index]
    frame = scene.render(name, time_s=item["time_s"], actors=True)
    assert tuple(item["image"].shape) == (3, height, width)
    assert np.array_equal(np.asarray(item["image"]).transpose(1, 2, 0), frame.image)
    assert np.array_equal(np.asarray(item["depth_m"]), frame.depth_m)
    assert np.array_equal(np.asarray(item["actors"]), frame.actors)
    assert np.allclose(np.asarray(item["world_from_sensor"]), frame.world_from_sensor)
    seen = [label for label in scene.labels(frame) if label["pixels"]]
    assert [label["name"] for label in item["labels"]] == [label["name"] for label in seen]
    assert np.allclose(np.asarray(item["boxes"]), np.reshape([label["visible_px"] for label in seen], (-1, 4)))
again = pickle.loads(pickle.dumps(frames))  # as it goes to another process
assert np.array_equal(np.asarray(again[0]["image"]), np.asarray(frames[0]["image"]))
assert sum(1 for _ in frames) == len(frames)
sweeps = simuli.torch.Frames(folder, sensor, [0.1], arrays=["range_m", "drop"])
assert tuple(sweeps[0]["drop"].shape) == sensor.shape and "boxes" not in sweeps[0] and "image" not in sweeps[0]
poses = np.stack([scene.world_from_rig(0.1) @ camera.rig_from_sensor] * 2)
assert np.allclose(np.asarray(simuli.torch.Frames(folder, name, [0.1, 0.2], poses)[1]["world_from_sensor"]), poses[1])
refused(lambda: simuli.torch.Frames(folder, name, [0.1], poses), "world_from_sensor: found 2")

# An environment: who stands still sees what render() shows; who follows the path gets its metres; who leaves it ends.
env = simuli.gym.Drive(folder, [name, lidar])
seen, info = env.reset(seed=1)
assert env.observation_space.contains(seen)
assert np.array_equal(seen[name], scene.render(name, time_s=info["time_s"]).image)
assert np.allclose(info["world_from_rig"], scene.world_from_rig(env.start_s)) and info["off_m"] < 0.01
begin, driven, truncated = info["world_from_rig"], 0.0, False
while not truncated:
    seen, reward, terminated, truncated, info = env.step(np.zeros(2, np.float32))
    driven += reward
    assert env.observation_space.contains(seen) and not terminated
apart = np.linalg.norm(info["world_from_rig"][:3, 3] - begin[:3, 3])
assert 0.9 * apart < driven < 1.01 * apart, (driven, apart)  # the street's path is hardly bent
assert env.render().shape == (height, width, 3) and env.render().dtype == np.uint8
env.reset()
for _ in range(2):
    seen, reward, terminated, truncated, info = env.step([0.0, -8.0])
env.reset(options={"time_s": env.start_s, "speed_m_per_s": 0.0})
at = env.step([0.3, 0.0])[4]["world_from_rig"]
assert np.allclose(at, begin)  # a car that stands does not turn
env.reset(options={"speed_m_per_s": 20.0})
while True:
    seen, reward, terminated, truncated, info = env.step([0.5, 0.0])
    if terminated or truncated:
        break
assert terminated and info["off_m"] > env.farthest_m
left = env.reset(options={"speed_m_per_s": 5.0})[1]["world_from_rig"]
turned = np.linalg.inv(left) @ env.step([0.3, 0.0])[4]["world_from_rig"]
assert turned[1, 3] > 0 and abs(np.arctan2(turned[1, 0], turned[0, 0]) - 0.5 * np.tan(0.3) / 2.8) < 1e-9
refused(lambda: simuli.gym.Drive(folder, ["rear"]), "sensors: found rear")
refused(lambda: simuli.gym.Drive(folder, []), "sensors: found none")
refused(lambda: simuli.gym.Drive(folder, [name], step_s=0.0), "step_s")

# The example, in a closed loop: a recording with all sensors of the scene.
import runpy

example = os.path.join(os.path.dirname(__file__), "..", "..", "examples", "drive_to_mcap.py")
bag = os.path.join(sys.argv[2], "driven.mcap")
sys.argv = [example, folder, "-o", bag, "--images", "raw"]
runpy.run_path(example, run_name="__main__")
with open(bag, "rb") as file:
    written = file.read()
assert written.startswith(b"\x89MCAP0\r\n")
for topic in (f"/{name}/", f"/{lidar}/", "/tf"):
    assert topic.encode() in written, topic
