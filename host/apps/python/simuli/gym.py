"""A small environment of Gymnasium's: drive the rig through a scene, and get what its sensors see.

    env = simuli.gym.Drive("drive.scene", ["front", "top"])
    seen, info = env.reset()
    seen, reward, terminated, truncated, info = env.step([0.0, 1.0])       # steering rad, acceleration m/s2

Needs gymnasium.
"""
import math

import gymnasium
import numpy as np

import simuli


class Drive(gymnasium.Env):
    """A car (kinematic bicycle about the rig's origin, which is the middle of the rear axle) beside the recorded drive.

    Action: steering angle, rad, and acceleration, m/s2. Observation: "speed_m_per_s" [1], and for each sensor its picture,
    float32 [height, width, 3] in [0, 1], or its ranges, float32 [beams, firings] m, 0 where nothing returned. Reward: metres
    driven along the recorded path, less the metres beside it times the step's seconds. An episode is truncated where the
    recording ends, and terminated more than `farthest_m` beside it, where nobody has seen the street. info:
    "world_from_rig" [4, 4], "time_s", "off_m".
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 10}

    def __init__(self, scene, sensors, step_s=0.1, wheelbase_m=2.8, farthest_m=4.0, device=None, quality="", render_mode=None):
        self.scene = scene if isinstance(scene, simuli.Scene) else simuli.Scene(scene, device, quality)
        known = {**self.scene.cameras, **self.scene.lidars}
        missing = [name for name in sensors if name not in known]
        if missing or not sensors:
            raise simuli.Error(f"sensors: found {', '.join(missing) or 'none'}, allowed {', '.join(known)}")
        if not (step_s > 0 and wheelbase_m > 0 and farthest_m > 0):
            raise simuli.Error(f"step_s, wheelbase_m, farthest_m: found {step_s}, {wheelbase_m}, {farthest_m}, allowed above 0")
        self.sensors = {name: known[name] for name in sensors}
        self.step_s, self.wheelbase_m, self.farthest_m, self.render_mode = step_s, wheelbase_m, farthest_m, render_mode
        longest_s = max(sensor.duration_s for sensor in self.sensors.values())
        self.start_s, self.end_s = self.scene.span[0], self.scene.span[1] - longest_s
        times = np.linspace(*self.scene.span, 1 + max(2, round((self.scene.span[1] - self.scene.span[0]) / 0.05)))
        self.path = np.array([self.scene.world_from_rig(t)[:3, 3] for t in times])
        self.along_m = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.path[:, :2], axis=0), axis=1))])
        box = gymnasium.spaces.Box
        seen = {"speed_m_per_s": box(0.0, np.inf, (1,), np.float32)}
        for name, sensor in self.sensors.items():
            shape = (*sensor.shape, 3) if sensor.is_camera else sensor.shape
            seen[name] = box(0.0, 1.0 if sensor.is_camera else np.inf, shape, np.float32)
        self.observation_space = gymnasium.spaces.Dict(seen)
        self.action_space = box(np.array([-0.6, -8.0], np.float32), np.array([0.6, 4.0], np.float32))

    def reset(self, *, seed=None, options=None):
        """options: "time_s" of the recording where to begin, "speed_m_per_s"; else its beginning, as fast as recorded."""
        super().reset(seed=seed)
        options = options or {}
        self.time_s = float(options.get("time_s", self.start_s))
        self.world_from_rig = np.array(self.scene.world_from_rig(self.time_s))
        later = self.scene.world_from_rig(min(self.time_s + 0.1, self.scene.span[1]))[:3, 3]
        self.speed = float(options.get("speed_m_per_s", np.linalg.norm(later - self.world_from_rig[:3, 3]) / 0.1))
        return self._seen(), self._info()

    def step(self, action):
        steer, acceleration = np.clip(np.asarray(action, float), self.action_space.low, self.action_space.high)
        before_m, _ = self._progress()
        way_m = max(0.0, self.speed * self.step_s + 0.5 * acceleration * self.step_s**2)
        self.speed = max(0.0, self.speed + acceleration * self.step_s)
        turn = way_m * math.tan(steer) / self.wheelbase_m
        c, s = math.cos(turn), math.sin(turn)
        ahead = [way_m * math.cos(0.5 * turn), way_m * math.sin(0.5 * turn)]
        self.world_from_rig = self.world_from_rig @ np.array(
            [[c, -s, 0, ahead[0]], [s, c, 0, ahead[1]], [0, 0, 1, 0], [0, 0, 0, 1.0]])
        self.time_s += self.step_s
        along_m, off_m = self._progress()
        terminated, truncated = off_m > self.farthest_m, self.time_s + self.step_s > self.end_s
        return self._seen(), along_m - before_m - off_m * self.step_s, terminated, truncated, self._info()

    def render(self):
        """uint8 [height, width, 3] of the first camera."""
        camera = next(name for name, sensor in self.sensors.items() if sensor.is_camera)
        return (255.0 * self.last[camera] + 0.5).astype(np.uint8)

    def _progress(self):
        """Metres along the recorded path, and beside it."""
        begin, way, here = self.path[:-1, :2], np.diff(self.path[:, :2], axis=0), self.world_from_rig[:2, 3]
        share = np.clip(((here - begin) * way).sum(1) / np.maximum((way * way).sum(1), 1e-12), 0.0, 1.0)
        apart = np.linalg.norm(begin + share[:, None] * way - here, axis=1)
        nearest = int(apart.argmin())
        return float(self.along_m[nearest] + share[nearest] * np.linalg.norm(way[nearest])), float(apart[nearest])

    def _seen(self):
        frames = {name: self.scene.render(sensor, self.world_from_rig @ sensor.rig_from_sensor, self.time_s)
                  for name, sensor in self.sensors.items()}
        self.last = {name: frame.image if frame.sensor.is_camera else frame.range_m for name, frame in frames.items()}
        return {"speed_m_per_s": np.array([self.speed], np.float32), **self.last}

    def _info(self):
        return {"world_from_rig": self.world_from_rig.copy(), "time_s": self.time_s, "off_m": self._progress()[1]}
