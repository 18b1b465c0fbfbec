"""Small valid inputs of every importer, for cases to damage."""

from __future__ import annotations

import base64
import json
import math
import struct
import zlib
from pathlib import Path

from harness import Trial

JPEG = base64.b64decode(
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAgGBgcGBQgHBwcJCQgKDBQNDAsLDBkSEw8UHRofHh0aHBwgJC4nICIsIxwcKDcpLDAxNDQ0Hyc5PTgyPC4z"
    "NDL/wAALCAAGAAgBAREA/8QAHwAAAQUBAQEBAQEAAAAAAAAAAAECAwQFBgcICQoL/8QAtRAAAgEDAwIEAwUFBAQAAAF9AQIDAAQRBRIhMUEGE1FhByJx"
    "FDKBkaEII0KxwRVS0fAkM2JyggkKFhcYGRolJicoKSo0NTY3ODk6Q0RFRkdISUpTVFVWV1hZWmNkZWZnaGlqc3R1dnd4eXqDhIWGh4iJipKTlJWWl5iZ"
    "mqKjpKWmp6ipqrKztLW2t7i5usLDxMXGx8jJytLT1NXW19jZ2uHi4+Tl5ufo6erx8vP09fb3+Pn6/9oACAEBAAA/AP/Z"
)


def png(width: int, height: int, shade: int = 100) -> bytes:
    def chunk(name: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    rows = b"".join(
        b"\0" + bytes((x * 16 + y * 8 + shade) % 256 for x in range(width) for _ in "rgb") for y in range(height)
    )
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def put(file: Path, data: str | bytes) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_bytes(data.encode() if isinstance(data, str) else data)


def floats(*values: float) -> bytes:
    return struct.pack(f"<{len(values)}f", *values)


def nerfstudio(folder: Path) -> list[str]:
    frames = []
    for i in range(3):
        put(folder / f"images/{i}.png", png(8, 6, 20 * i))
        matrix = [[1, 0, 0, 2 * i], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        frames.append({"file_path": f"images/{i}.png", "transform_matrix": matrix})
    put(
        folder / "transforms.json",
        json.dumps({"w": 8, "h": 6, "fl_x": 8.0, "fl_y": 8.0, "cx": 4.0, "cy": 3.0, "frames": frames}),
    )
    return ["import", "nerfstudio", folder.name, "-o", "out.log"]


def colmap(folder: Path, binary: bool = False) -> list[str]:
    for i in range(4):
        put(folder / f"images/{i}.png", png(8, 6, 20 * i))
    model = folder / "sparse/0"
    if binary:
        parameters = struct.pack("<8d", 9, 10, 4, 3, 0.01, 0, 0.001, 0)
        put(model / "cameras.bin", struct.pack("<QiiQQ", 1, 7, 4, 8, 6) + parameters)
        images = b"".join(
            struct.pack("<i7di", i + 1, 1, 0, 0, 0, -2.0 * i, 0, 0, 7)
            + f"{i}.png\0".encode()
            + struct.pack("<Q", 1)
            + b"\1" * 24
            for i in range(4)
        )
        put(model / "images.bin", struct.pack("<Q", 4) + images)
        points = b"".join(
            struct.pack("<Q3d3BdQ", i, i, 1, 20, 9, 9, 9, 0.5, 3) + struct.pack("<6i", 1, 0, 2, 0, 3, 0)
            for i in range(3)
        )
        put(model / "points3D.bin", struct.pack("<Q", 3) + points)
    else:
        put(model / "cameras.txt", "# comment\n7 OPENCV 8 6 9 10 4 3 0.01 0 0.001 0\n")
        put(model / "images.txt", "".join(f"{i + 1} 1 0 0 0 {-2 * i} 0 0 7 {i}.png\n1 2 -1\n" for i in range(4)))
        put(model / "points3D.txt", "1 0 1 20 9 9 9 0.5 1 0 2 0 3 0\n2 2 0 20 9 9 9 0.5 1 1 2 1 3 1\n")
    return ["import", "colmap", folder.name, "-o", "out.log"]


def colmap_binary(folder: Path) -> list[str]:
    return colmap(folder, binary=True)


def identity(x: float = 0.0) -> dict[str, list[float]]:
    return {"position_m": [x, 0.0, 0.0], "rotation_wxyz": [1.0, 0.0, 0.0, 0.0]}


def points(folder: Path) -> list[str]:
    sweep = b""
    for row in range(16):
        elevation = math.radians(15.0 - 2.0 * row)
        for column in range(36):
            azimuth = 2 * math.pi * (column + 0.5) / 36
            flat = 10 * math.cos(elevation)
            sweep += floats(flat * math.cos(azimuth), flat * math.sin(azimuth), 10 * math.sin(elevation), 0.5)
    for i in range(2):
        put(folder / f"points/{i}.bin", sweep)
    put(
        folder / "points.json",
        json.dumps(
            {
                "format": "simuli points",
                "version": 1,
                "name": "mine",
                "start_ns": 0,
                "point_columns": ["x_m", "y_m", "z_m", "intensity"],
                "points_in": "sensor",
                "cameras": [],
                "lidars": [{"table": "velodyne_vlp16", "name": "top", "columns": 36, "rig_from_lidar": identity()}],
                "world_from_rig": [{"time_ns": 100_000_000 * i, **identity(float(i))} for i in range(4)],
                "images": [],
                "sweeps": [
                    {
                        "lidar": "top",
                        "file": f"points/{i}.bin",
                        "time_start_ns": i * 10**8,
                        "time_end_ns": (i + 1) * 10**8,
                    }
                    for i in range(2)
                ],
            }
        ),
    )
    return ["import", "points", folder.name, "-o", "out.log"]


def kitti_sweep(trial: Trial) -> bytes:
    rows = json.loads(trial.works("info", "kitti_hdl64e", "--json").out)["rows"]
    sweep = b""
    for row in rows[::4]:
        elevation, up = row["elevation_rad"], row["vertical_offset_m"]
        for i in range(300):
            azimuth = 2 * math.pi * (i + 0.5) / 300
            flat = 10 * math.cos(elevation)
            sweep += floats(flat * math.cos(azimuth), flat * math.sin(azimuth), 10 * math.sin(elevation) + up, 0.5)
    return sweep


def kitti(folder: Path, trial: Trial) -> list[str]:
    put(
        folder / "calib_cam_to_cam.txt",
        "calib_time: 09-Jan-2012 13:57:47\nS_rect_02: 12 8\nR_rect_00: 1 0 0 0 1 0 0 0 1\nP_rect_02: 10 0 6 0.5 0 10 4 0 0 0 1 0\n",
    )
    put(folder / "calib_velo_to_cam.txt", "R: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.1 -0.3\n")
    put(folder / "calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n")
    drive = folder / "2011_09_26_drive_0001_sync"
    for name, offset in {
        "image_02/timestamps.txt": 0.06,
        "velodyne_points/timestamps_start.txt": 0.0,
        "velodyne_points/timestamps.txt": 0.05,
        "velodyne_points/timestamps_end.txt": 0.1,
        "oxts/timestamps.txt": 0.055,
    }.items():
        put(drive / name, "".join(f"2011-09-26 23:59:59.{round(1e9 * (offset + 0.1 * i)):09}\n" for i in range(3)))
    sweep = kitti_sweep(trial)
    for i in range(3):
        put(drive / f"oxts/data/{i:010}.txt", f"49.0 {8.4 + 1e-5 * i:.9f} 114.0 0.01 -0.02 0.3" + " 0" * 24 + "\n")
        put(drive / f"velodyne_points/data/{i:010}.bin", sweep)
        put(drive / f"image_02/data/{i:010}.png", png(12, 8, i))
    put(
        folder / "labels.txt",
        "".join(f"{i} 0 Car 0 0 -1.5 1 2 3 4 1.5 1.8 4.2 {1.0 + i} 1.6 12.0 -1.5\n" for i in range(3)),
    )
    return [
        "import",
        "kitti",
        f"{folder.name}/{drive.name}",
        "--tracking",
        f"{folder.name}/labels.txt",
        "-o",
        "out.log",
    ]


def nuscenes(folder: Path, trial: Trial) -> list[str]:
    rows = json.loads(trial.works("info", "nuscenes_lidar_top_hdl32e", "--json").out)["rows"]
    start, firings = 1_532_402_927_600_000, 40
    turn = b""
    for c in range(firings):
        azimuth = math.pi * (1 - (2 * c + 1) / firings)
        for ring in range(32):
            height = 10 * math.tan(rows[31 - ring]["elevation_rad"])
            turn += floats(10 * math.cos(azimuth), 10 * math.sin(azimuth), height, 51, ring)
    quarter = [0.5, -0.5, 0.5, -0.5]
    table: dict[str, list[dict[str, object]]] = {
        "scene": [{"token": "s", "name": "scene-0001"}],
        "sample": [{"token": t, "scene_token": "s", "timestamp": start + 500_000 * i} for i, t in enumerate("ab")],
        "sensor": [
            {"token": "c", "channel": "CAM_FRONT", "modality": "camera"},
            {"token": "l", "channel": "LIDAR_TOP", "modality": "lidar"},
        ],
        "calibrated_sensor": [
            {
                "token": "cc",
                "sensor_token": "c",
                "translation": [1.7, 0, 1.5],
                "rotation": quarter,
                "camera_intrinsic": [[9, 0, 4], [0, 9, 3], [0, 0, 1]],
            },
            {
                "token": "cl",
                "sensor_token": "l",
                "translation": [0.9, 0, 1.8],
                "rotation": [1, 0, 0, 0],
                "camera_intrinsic": [],
            },
        ],
        "sample_data": [],
        "ego_pose": [],
        "category": [{"token": "k", "name": "vehicle.car"}],
        "instance": [{"token": "i", "category_token": "k"}],
        "sample_annotation": [
            {
                "token": t,
                "sample_token": t,
                "instance_token": "i",
                "translation": [20, 5 * i, 0.8],
                "size": [1.9, 4.5, 1.6],
                "rotation": [1, 0, 0, 0],
            }
            for i, t in enumerate("ab")
        ],
    }
    for i, sample in enumerate("ab"):
        for calibration, file, after in (
            ("cc", f"samples/CAM_FRONT/{i}.png", 12_000),
            ("cl", f"samples/LIDAR_TOP/{i}.pcd.bin", 48_000),
        ):
            time = start + 500_000 * i + after
            table["ego_pose"].append(
                {"token": "p" + file, "timestamp": time, "translation": [1000 + i, 0, 0], "rotation": [1, 0, 0, 0]}
            )
            table["sample_data"].append(
                {
                    "token": file,
                    "sample_token": sample,
                    "ego_pose_token": "p" + file,
                    "calibrated_sensor_token": calibration,
                    "timestamp": time,
                    "filename": file,
                    "width": 8,
                    "height": 6,
                }
            )
            put(folder / file, png(8, 6, i) if calibration == "cc" else turn)
    for name, rows_of in table.items():
        put(folder / "v1.0-mini" / f"{name}.json", json.dumps(rows_of))
    return ["import", "nuscenes", folder.name, "-o", "out.log"]


def imports(trial: Trial) -> dict[str, list[str]]:
    """Folders in the trial's own, and the command line that reads each."""
    at = trial.folder
    return {
        "nerfstudio": nerfstudio(at / "nerfstudio"),
        "colmap": colmap(at / "colmap"),
        "colmap_binary": colmap_binary(at / "colmap_binary"),
        "points": points(at / "points"),
        "kitti": kitti(at / "kitti", trial),
        "nuscenes": nuscenes(at / "nuscenes", trial),
    }
