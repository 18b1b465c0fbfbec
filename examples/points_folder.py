"""What the converters have in common: poses, the spin of a LiDAR, and the folder for `simuli import points`
(its format: io/import/points/points_log.hpp)."""
import json
import pathlib
import shutil
import struct
import sys
import tempfile
import zlib

import numpy as np

COLUMNS = ["x_m", "y_m", "z_m", "intensity", "time_s"]


def matrix(wxyz, xyz):
    """4 x 4 from a quaternion (w, x, y, z) and a place."""
    w, x, y, z = np.asarray(wxyz, float) / np.linalg.norm(wxyz)
    m = np.eye(4)
    m[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                 [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                 [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    m[:3, 3] = xyz
    return m


def quaternion(m):
    """(w, x, y, z) of the rotation of a matrix: the largest of the four is found first."""
    r = m[:3, :3]
    s = np.array([1 + r[0, 0] + r[1, 1] + r[2, 2], 1 + r[0, 0] - r[1, 1] - r[2, 2],
                  1 - r[0, 0] + r[1, 1] - r[2, 2], 1 - r[0, 0] - r[1, 1] + r[2, 2]])
    d = [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]
    o = [r[1, 0] + r[0, 1], r[0, 2] + r[2, 0], r[2, 1] + r[1, 2]]
    row = [[s[0], d[0], d[1], d[2]], [d[0], s[1], o[0], o[1]], [d[1], o[0], s[2], o[2]], [d[2], o[1], o[2], s[3]]]
    q = np.array(row[int(np.argmax(s))])
    return q / np.linalg.norm(q)


def pose(m):
    return {"position_m": m[:3, 3].tolist(), "rotation_wxyz": quaternion(m).tolist()}


class Path:
    """world_from_rig at rising times (ns)."""

    def __init__(self, times_ns, poses):
        self.times_ns, first = np.unique(np.asarray(times_ns, np.int64), return_index=True)
        self.poses = np.asarray(poses, float)[first]
        self.q = np.array([quaternion(m) for m in self.poses])
        for i in range(1, len(self.q)):  # the shorter way round
            if self.q[i] @ self.q[i - 1] < 0:
                self.q[i] = -self.q[i]

    def at(self, time_ns):
        """One pose; between two the straight line, and a normalised mean of quaternions that are near."""
        i = int(np.clip(np.searchsorted(self.times_ns, time_ns) - 1, 0, max(0, len(self.q) - 2)))
        j = min(i + 1, len(self.q) - 1)
        span = max(1, int(self.times_ns[j] - self.times_ns[i]))
        u = (int(time_ns) - int(self.times_ns[i])) / span
        return matrix((1 - u) * self.q[i] + u * self.q[j],
                      (1 - u) * self.poses[i][:3, 3] + u * self.poses[j][:3, 3])

    def to_sensor(self, world, times_ns, rig_from_sensor):
        """Points (n, 3) of the world as the sensor saw them, each at its own time."""
        out = np.empty((len(world), 3))
        steps = np.linspace(times_ns.min(), times_ns.max(), 101)
        index = np.clip(np.searchsorted(steps, times_ns), 0, 100)
        for k in np.unique(index):
            m = np.linalg.inv(self.at(steps[k]) @ rig_from_sensor)
            out[index == k] = world[index == k] @ m[:3, :3].T + m[:3, 3]
        return out


def spin(azimuth, share):
    """How a LiDAR turns: +1 counter-clockwise or -1, azimuth (rad) at the sweep's start, and how well all
    points agree (1: exactly). `share` is each point's time as a share of the sweep."""
    tries = []
    for sign in (1, -1):
        mean = np.exp(1j * (azimuth - sign * 2 * np.pi * share)).mean()
        tries.append((abs(mean), sign, float(np.angle(mean))))
    agree, sign, start = max(tries)
    return sign, start, agree


def turn_s(azimuth, time_s):
    """Seconds of a turn that explain best when points were measured where (azimuths in rad), and how well they do (1:
    exactly)."""
    span, some = np.ptp(time_s), slice(None, None, len(time_s) // 4096 + 1)
    a, t = azimuth[some], time_s[some] / max(span, 1e-12)

    def agree(rate):
        return max(abs(np.exp(1j * (a - sign * 2 * np.pi * t * rate)).mean()) for sign in (1, -1))

    best, step = max(np.arange(0.02, 1.5, 0.02), key=agree), 0.02
    for _ in range(5):
        step /= 4
        best = max(best + step * np.arange(-4, 5), key=agree)
    return float(span / best), float(agree(best))


def lidar(name, table, columns, rig_from_lidar, sign, start):
    """An entry of "lidars": the table as it was mounted; `start` is where column 0 begins."""
    step = 2 * np.pi / columns
    return {"table": table, "name": name, "columns": columns,
            "azimuth_first_rad": float(np.angle(np.exp(1j * (start + sign * 0.5 * step)))),
            "spin": "counter_clockwise" if sign > 0 else "clockwise", "rig_from_lidar": pose(rig_from_lidar)}


def camera(name, width, height, fx, fy, cx, cy, rig_from_camera):
    """An ideal pinhole; the principal point counts from the centre of the first pixel, as OpenCV's."""
    return {"name": name, "model": "pinhole", "width_px": int(width), "height_px": int(height), "fx_px": float(fx),
            "fy_px": float(fy), "cx_px": float(cx) + 0.5, "cy_px": float(cy) + 0.5, "shutter": "global",
            "rig_from_camera": pose(rig_from_camera)}


def run(main, *arguments):
    """Tells in a line which file or number main() could not read."""
    try:
        main(*arguments)
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {type(error).__name__}: {error}".replace("\n", " "))


class Folder:
    """The folder being written; its name must be new, and nothing has it before finish()."""

    def __init__(self, path, name, start_ns):
        self.whole = pathlib.Path(path)
        if self.whole.exists():
            sys.exit(f"{path}: found something of that name, allowed a folder that is new")
        self.whole.parent.mkdir(parents=True, exist_ok=True)
        self.temporary = tempfile.TemporaryDirectory(prefix=".", dir=self.whole.parent)  # removed at the latest at exit
        self.path = pathlib.Path(self.temporary.name) / "whole"
        (self.path / "points").mkdir(parents=True)
        (self.path / "images").mkdir()
        self.json = {"format": "simuli points", "version": 1, "name": name, "start_ns": int(start_ns),
                     "point_columns": COLUMNS, "points_in": "world", "cameras": [], "lidars": [],
                     "world_from_rig": [], "images": [], "sweeps": [], "actors": []}

    def sweep(self, name, xyz, intensity, time_s, start_ns, end_ns):
        """`time_s` of all sweeps or of none: then None, and no such column."""
        file = f"points/{len(self.json['sweeps']):06}.bin"
        columns = [xyz, np.clip(intensity, 0, 1)] + ([] if time_s is None else [time_s])
        self.json["point_columns"] = COLUMNS if time_s is not None else COLUMNS[:-1]
        np.column_stack(columns).astype("<f4").tofile(self.path / file)
        self.json["sweeps"].append({"lidar": name, "file": file, "time_start_ns": int(start_ns),
                                    "time_end_ns": int(end_ns)})

    def image(self, name, source, time_ns):
        file = f"images/{name}_{int(time_ns)}{pathlib.Path(source).suffix}"
        shutil.copyfile(source, self.path / file)
        self.json["images"].append({"camera": name, "file": file, "time_start_ns": int(time_ns),
                                    "time_end_ns": int(time_ns)})

    def hide_lowest(self, name, width, height, share):
        """That share of the height of a camera's pictures shows the vehicle."""
        def chunk(kind, data):
            return (struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data)))
        image = np.zeros((height, width + 1), np.uint8)  # a byte more for each row's filter: none
        image[height - round(share * height):, 1:] = 255
        (self.path / "masks").mkdir(exist_ok=True)
        file = f"masks/{name}.png"
        (self.path / file).write_bytes(
            b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(image.tobytes())) + chunk(b"IEND", b""))
        self.json.setdefault("masks", []).append({"camera": name, "file": file})

    def box(self, key, kind, size_m, time_ns, world_from_box):
        """`size_m`: length, width, height of the object `key`, its x axis forward."""
        actors = self.json["actors"]
        found = next((a for a in actors if a["key"] == key), None)
        if found is None:
            found = {"key": key, "name": f"{kind}_{len(actors)}".lower().replace(" ", "_"), "kind": kind,
                     "length_m": float(size_m[0]), "width_m": float(size_m[1]), "height_m": float(size_m[2]),
                     "track": []}
            actors.append(found)
        found["track"].append({"time_ns": int(time_ns), **pose(world_from_box)})

    def finish(self, path):
        for actor in self.json["actors"]:
            del actor["key"]
            track = {p["time_ns"]: p for p in actor["track"]}
            actor["track"] = [track[t] for t in sorted(track)]
        for frames in ("images", "sweeps"):
            self.json[frames].sort(key=lambda f: f["time_start_ns"])
        self.json["world_from_rig"] = [{"time_ns": int(t), **pose(m)} for t, m in zip(path.times_ns, path.poses)]
        (self.path / "points.json").write_text(json.dumps(self.json))
        self.path.rename(self.whole)
