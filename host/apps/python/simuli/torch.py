"""Frames with labels as a data set of PyTorch's, rendered when they are asked for.

    frames = simuli.torch.Frames("drive.scene", "front", times_s)
    loader = torch.utils.data.DataLoader(frames, collate_fn=list, num_workers=2, multiprocessing_context="spawn")

Needs torch.
"""
import numpy as np
import torch
from torch.utils.data import Dataset

import simuli


class Frames(Dataset):
    """A frame for each time: a dict of tensors, and labels.

    scene: a folder, opened by each process that reads; sensor: a Sensor, or a name; times_s: None takes the sensor's
    recorded ones; world_from_sensor: [n, 4, 4], else on the recorded path; arrays: names of Frame's; edits: of each frame.

    An item has "time_s", "world_from_sensor" (float64 [4, 4]), the arrays (float32, pictures [3, height, width] in [0, 1]),
    "actors" (int64 [rows, columns], 0: none's), and "boxes" (float32 [n, 4]: left, top, right, bottom, px, of cameras),
    "labels" (a dict each, as Scene.labels() has them) of the actors that are seen.
    """

    def __init__(self, scene, sensor, times_s=None, world_from_sensor=None, arrays=None, edits=(), device=None, quality=""):
        self.scene, self.sensor, self.edits, self.quality = scene, sensor, list(edits), quality
        self.device, self.arrays, self._open = device, arrays, None
        if times_s is None:
            times_s = [start for start, _ in simuli.Scene(scene, device).recorded_frames[getattr(sensor, "name", sensor)]]
        self.times_s = np.asarray(times_s, float)
        self.poses = None if world_from_sensor is None else np.asarray(world_from_sensor, float)
        if self.poses is not None and len(self.poses) != len(self.times_s):
            raise simuli.Error(f"world_from_sensor: found {len(self.poses)}, allowed one for each of {len(self.times_s)} times")

    def __len__(self):
        return len(self.times_s)

    def __getstate__(self):
        return {**self.__dict__, "_open": None}  # a process has a scene of its own

    def __getitem__(self, index):
        time_s = float(self.times_s[index])  # IndexError ends a loop over the set
        if self._open is None:
            self._open = simuli.Scene(self.scene, self.device, self.quality)
        pose = None if self.poses is None else self.poses[index]
        frame = self._open.render(self.sensor, pose, time_s, edits=self.edits, actors=True)
        is_camera = frame.sensor.is_camera
        item = {"time_s": time_s, "world_from_sensor": torch.from_numpy(np.array(frame.world_from_sensor))}
        for name in self.arrays or (("image", "depth_m") if is_camera else ("range_m", "intensity")):
            values = torch.from_dlpack(frame.tensor(name))
            item[name] = values.permute(2, 0, 1) if values.ndim == 3 else values
        item["actors"] = torch.from_numpy(frame.actors.astype(np.int64))
        seen = [label for label in self._open.labels(frame) if label["pixels" if is_camera else "returns"]]
        item["labels"] = seen
        if is_camera:
            item["boxes"] = torch.from_numpy(np.array([label["visible_px"] for label in seen], np.float32).reshape(-1, 4))
        return item
