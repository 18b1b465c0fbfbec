"""AlpaSim's geometry module, which is written in Rust, as far as a rollout asks: poses, paths of them, lines.

Single precision where that one has it. Quaternions are x, y, z, w; times are microseconds.
"""
import numpy as np
from scipy.spatial.transform import Rotation


def version():
    return "stand-in"


def _unit(quaternions):
    q = np.asarray(quaternions, np.float64)
    length = np.linalg.norm(q, axis=-1, keepdims=True)
    if (np.abs(length**2 - 1) > 1e-4).any():
        raise ValueError(f"quaternions of length {length.min()} to {length.max()}, allowed is 1")
    return (q / length).astype(np.float32)


def _yaws(q):
    x, y, z, w = np.moveaxis(np.asarray(q, np.float64), -1, 0)
    return np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


def _product(a, b):
    """Of quaternions, which keeps their signs."""
    ax, ay, az, aw = np.moveaxis(np.asarray(a, np.float64), -1, 0)
    bx, by, bz, bw = np.moveaxis(np.asarray(b, np.float64), -1, 0)
    return np.stack([aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
                     aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz], -1)


def _slerp(a, b, share):
    """Between rows of quaternions, the shorter way; share in 0..1, one per row."""
    a, b, share = np.asarray(a, np.float64), np.asarray(b, np.float64), np.asarray(share, np.float64)[:, None]
    cosine = (a * b).sum(1, keepdims=True)
    b, cosine = np.where(cosine < 0, -b, b), np.abs(cosine)
    angle = np.arccos(np.minimum(cosine, 1))
    near = angle < 1e-4
    sine = np.where(near, 1, np.sin(angle))
    mixed = np.where(near, (1 - share) * a + share * b,
                     (np.sin((1 - share) * angle) * a + np.sin(share * angle) * b) / sine)
    return mixed / np.linalg.norm(mixed, axis=1, keepdims=True)


class Pose:
    def __init__(self, position, quaternion):
        self.vec3 = np.array(position, np.float32).reshape(3)
        self.quat = _unit(np.asarray(quaternion).reshape(4))

    @staticmethod
    def identity():
        return Pose([0, 0, 0], [0, 0, 0, 1])

    @staticmethod
    def from_denormalized_quat(position, quaternion):
        q = np.asarray(quaternion, np.float64)
        return Pose(position, q / np.linalg.norm(q))

    @staticmethod
    def from_proto(position, quat_wxyz):
        return Pose(position, np.roll(quat_wxyz, -1))

    @staticmethod
    def from_se3(matrix):
        matrix = np.asarray(matrix, np.float64)
        return Pose(matrix[:3, 3], Rotation.from_matrix(matrix[:3, :3]).as_quat())

    def as_se3(self):
        matrix = np.eye(4, dtype=np.float32)
        matrix[:3, :3], matrix[:3, 3] = Rotation.from_quat(self.quat).as_matrix(), self.vec3
        return matrix

    def __matmul__(self, other):
        turned = Rotation.from_quat(self.quat).apply(other.vec3)
        return Pose.from_denormalized_quat(self.vec3 + turned, _product(self.quat, other.quat))

    def inverse(self):
        back = self.quat * np.array([-1, -1, -1, 1], np.float32)
        return Pose(-Rotation.from_quat(back).apply(self.vec3), back)

    def blend(self, other, alpha):
        share = np.clip([alpha], 0, 1)
        return Pose((1 - share) * self.vec3 + share * other.vec3, _slerp(self.quat[None], other.quat[None], share)[0])

    def yaw(self):
        return float(_yaws(self.quat))

    def to_proto(self):
        return tuple(map(float, self.vec3)), tuple(map(float, np.roll(self.quat, 1)))

    def clone(self):
        return Pose(self.vec3, self.quat)

    def __eq__(self, other):
        return bool(np.linalg.norm(self.vec3 - other.vec3) < 1e-6 and (np.abs(self.quat - other.quat) < 1e-6).all())


class Trajectory:
    def __init__(self, timestamps, positions, quaternions):
        times = np.array(timestamps, np.uint64)
        if (times[1:] <= times[:-1]).any():
            raise ValueError("timestamps must be strictly increasing")
        self.timestamps_us = times
        self.positions = np.array(positions, np.float32).reshape(len(times), 3)
        self.quaternions = _unit(np.asarray(quaternions).reshape(len(times), 4))

    @staticmethod
    def create_empty():
        return Trajectory([], [], [])

    @staticmethod
    def from_poses(timestamps, poses):
        return Trajectory(timestamps, [p.vec3 for p in poses], [p.quat for p in poses])

    def __len__(self):
        return len(self.timestamps_us)

    def is_empty(self):
        return len(self) == 0

    def get_time_range_tuple(self):
        return (int(self.timestamps_us[0]), int(self.timestamps_us[-1]) + 1) if len(self) else (0, 0)

    time_range_us = property(lambda self: range(*self.get_time_range_tuple()))
    first_pose = property(lambda self: self.get_pose(0))
    last_pose = property(lambda self: self.get_pose(-1))
    yaws = property(lambda self: _yaws(self.quaternions).astype(np.float32))

    def get_pose(self, idx):
        return Pose(self.positions[idx], self.quaternions[idx])

    def set_pose(self, idx, pose):
        self.positions[idx], self.quaternions[idx] = pose.vec3, pose.quat

    def rotation_matrices(self):
        return Rotation.from_quat(self.quaternions).as_matrix().astype(np.float32)

    def _rates(self, values, times, method):
        """Differences in time: to the next one ("forward"), else over both neighbours; one-sided at the ends."""
        if len(self) < 2:
            raise ValueError("Not enough poses to compute derivatives")
        seconds = (self.timestamps_us - self.timestamps_us[0]).astype(np.float64) * 1e-6
        for _ in range(times):
            at = np.arange(len(self))
            low = np.minimum(at, len(self) - 2) if method == "forward" else np.maximum(at - 1, 0)
            high = np.minimum(at + 1, len(self) - 1)
            values = ((values[high] - values[low]).T / (seconds[high] - seconds[low])).T
        return values.astype(np.float32)

    def velocities(self, method="centered"):
        return self._rates(self.positions.astype(np.float64), 1, method)

    def accelerations(self, method="centered"):
        return self._rates(self.positions.astype(np.float64), 2, method)

    def jerk(self, method="centered"):
        return self._rates(self.positions.astype(np.float64), 3, method)

    def yaw_rates(self, method="centered"):
        return self._rates(np.unwrap(_yaws(self.quaternions)), 1, method)

    def yaw_accelerations(self, method="centered"):
        return self._rates(np.unwrap(_yaws(self.quaternions)), 2, method)

    def update_absolute(self, timestamp, pose):
        longer = self.concat(Trajectory([timestamp], [pose.vec3], [pose.quat]))
        self.timestamps_us, self.positions, self.quaternions = (longer.timestamps_us, longer.positions,
                                                                longer.quaternions)

    def update_relative(self, timestamp, delta_pose):
        self.update_absolute(timestamp, self.last_pose @ delta_pose)

    def transform(self, transform, is_relative=False):
        poses = [self.get_pose(i) for i in range(len(self))]
        return Trajectory.from_poses(self.timestamps_us,
                                     [p @ transform if is_relative else transform @ p for p in poses])

    def blend(self, other, alpha):
        if not np.array_equal(self.timestamps_us, other.timestamps_us):
            raise ValueError("Cannot blend trajectories with different timestamps")
        shares = np.broadcast_to(alpha, len(self))
        return Trajectory.from_poses(self.timestamps_us, [self.get_pose(i).blend(other.get_pose(i), shares[i])
                                                          for i in range(len(self))])

    def clip(self, start_us, end_us):
        begin, end = self.get_time_range_tuple()
        first, last = max(start_us, begin), min(end_us, end) - 1
        if first > last:
            return Trajectory.create_empty()
        inner = self.timestamps_us[(self.timestamps_us > first) & (self.timestamps_us < last)].astype(np.int64)
        return self.interpolate(np.unique([first, *inner, last]).astype(np.uint64))

    def append(self, other):
        if not len(self) or not len(other) or self.timestamps_us[-1] != other.timestamps_us[0]:
            return self.concat(other)
        if not (np.allclose(self.positions[-1], other.positions[0], rtol=0, atol=1e-5)
                and np.allclose(self.quaternions[-1], other.quaternions[0], rtol=0, atol=1e-5)):
            raise ValueError("trajectories differ where they meet")
        return self.concat(other.slice(1, len(other)))

    def filter(self, mask):
        return Trajectory(self.timestamps_us[mask], self.positions[mask], self.quaternions[mask])

    def slice(self, start, end):
        return self.filter(np.arange(len(self))[start:end])

    def concat(self, other):
        return Trajectory(np.concatenate([self.timestamps_us, other.timestamps_us]),
                          np.concatenate([self.positions, other.positions]),
                          np.concatenate([self.quaternions, other.quaternions]))

    def clone(self):
        return Trajectory(self.timestamps_us, self.positions, self.quaternions)

    clone_storage = clone

    def to_polyline(self):
        return Polyline(self.positions)

    def interpolate(self, target_timestamps):
        at = np.array(target_timestamps, np.uint64)
        begin, end = self.get_time_range_tuple()
        if ((at < begin) | (at >= end)).any():
            raise ValueError(f"Interpolation timestamp {at} outside range [{begin}, {end})")
        low = np.maximum(np.searchsorted(self.timestamps_us, at, "right") - 1, 0)
        high = np.minimum(low + 1, len(self) - 1)
        span = np.maximum(self.timestamps_us[high] - self.timestamps_us[low], 1)
        share = (at - self.timestamps_us[low]) / span
        result = Trajectory.create_empty()  # not by its constructor: the times asked for may be in any order
        result.timestamps_us = at
        low_at, high_at = self.positions[low].astype(np.float64), self.positions[high].astype(np.float64)
        result.positions = (low_at + share[:, None] * (high_at - low_at)).astype(np.float32)
        result.quaternions = _slerp(self.quaternions[low], self.quaternions[high], share).astype(np.float32)
        return result

    def interpolate_poses_list(self, target_timestamps):
        there = self.interpolate(target_timestamps)
        return [there.get_pose(i) for i in range(len(there))]

    def interpolate_pose(self, at_us):
        return self.interpolate([at_us]).get_pose(0)

    def interpolate_delta(self, start_us, end_us):
        return self.interpolate_pose(start_us).inverse() @ self.interpolate_pose(end_us)


class DynamicTrajectory:
    """With 12 numbers a pose: velocities and accelerations, along the axes and about them."""

    def __init__(self, timestamps, positions, quaternions, dynamics):
        self._path = Trajectory(timestamps, positions, quaternions)
        self.dynamics = np.array(dynamics, np.float64).reshape(len(self._path), 12)

    @staticmethod
    def from_trajectory_and_dynamics(trajectory, dynamics):
        return DynamicTrajectory(trajectory.timestamps_us, trajectory.positions, trajectory.quaternions, dynamics)

    @staticmethod
    def create_empty():
        return DynamicTrajectory([], [], [], [])

    def __len__(self):
        return len(self._path)

    def __getattr__(self, name):  # reading is the path's own: interpolate(), clip(), last_pose and so on
        if name.startswith("__") or name == "_path":
            raise AttributeError(name)
        return getattr(self._path, name)

    def trajectory(self):
        return self._path.clone()

    def interpolate_dynamics(self, target_timestamps):
        at, known = (t.astype(np.float64) for t in (np.asarray(target_timestamps), self.timestamps_us))
        return np.stack([np.interp(at, known, column) for column in self.dynamics.T], 1)

    def update_absolute(self, timestamp, pose, dynamics):
        self._path.update_absolute(timestamp, pose)
        self.dynamics = np.vstack([self.dynamics, dynamics])

    def concat(self, other):
        return self.from_trajectory_and_dynamics(self._path.concat(other._path),
                                                 np.vstack([self.dynamics, other.dynamics]))

    def append(self, other):
        joined = self._path.append(other._path)
        return self.from_trajectory_and_dynamics(
            joined, np.vstack([self.dynamics, other.dynamics[len(self) + len(other) - len(joined):]]))

    def transform(self, transform, is_relative=False):
        return self.from_trajectory_and_dynamics(self._path.transform(transform, is_relative), self.dynamics)

    def clone(self):
        return self.from_trajectory_and_dynamics(self._path, self.dynamics)


class Polyline:
    def __init__(self, points):
        self.points = np.array(points, np.float32)

    @staticmethod
    def create_empty(dimension=3):
        return Polyline(np.zeros((0, dimension)))

    def __len__(self):
        return len(self.points)

    waypoints = property(lambda self: self.points)
    is_empty = property(lambda self: len(self) == 0)
    dimension = property(lambda self: self.points.shape[1])
    segment_lengths = property(lambda self: np.linalg.norm(np.diff(self.points, axis=0), axis=1))
    total_length = property(lambda self: float(self.segment_lengths.sum()))

    def arc_lengths(self):
        return np.concatenate([[0], np.cumsum(self.segment_lengths)]).astype(np.float32)

    def project_point(self, point):
        """The nearest point of it, in which piece, and how far from the beginning of that."""
        begin, along = self.points[:-1], np.diff(self.points, axis=0)
        share = np.clip(((point - begin) * along).sum(1) / np.maximum((along**2).sum(1), 1e-12), 0, 1)
        nearest = begin + share[:, None] * along
        i = int(np.argmin(np.linalg.norm(nearest - point, axis=1)))
        return nearest[i], i, float(share[i] * self.segment_lengths[i])

    def positions_at(self, distances):
        known = self.arc_lengths()
        return np.stack([np.interp(distances, known, column) for column in self.points.T], 1).astype(np.float32)

    def remaining_from_point(self, point):
        """What lies ahead of the point's foot, which is nothing behind the end."""
        found = self.project_point(point)
        end = self.points[-1]
        if (point - end) @ (end - self.points[-2]) > 1e-6 and np.array_equal(found[0], end):
            return Polyline.create_empty(self.dimension), found
        return Polyline(np.vstack([found[0], self.points[found[1] + 1:]])), found

    def resample_from_point(self, start_point, spacing, n_points):
        rest, _ = self.remaining_from_point(start_point)
        if rest.is_empty:
            return rest
        distances = np.arange(n_points) * spacing
        return Polyline(rest.positions_at(distances[distances <= rest.total_length]))

    def get_cumulative_distances_from_point(self, point):
        rest, found = self.remaining_from_point(point)
        return rest.arc_lengths()[:len(rest)], float(self.arc_lengths()[found[1]] + found[2])

    def clip(self, start=None, end=None):
        return Polyline(self.points[start:end])

    def append(self, other):
        return Polyline(np.vstack([self.points, other.points]))

    def downsample_with_min_distance(self, min_distance):
        kept = []
        for i in range(len(self)):
            if not kept or np.linalg.norm(self.points[i] - self.points[kept[-1]]) >= min_distance:
                kept.append(i)
        self.points = self.points[kept]

    def zero_out_z(self):
        return Polyline(self.points * np.array([1, 1, 0], np.float32))

    def transform(self, transform_pose):
        return Polyline(Rotation.from_quat(transform_pose.quat).apply(self.points) + transform_pose.vec3)

    def clone(self):
        return Polyline(self.points)
