"""A log as NCore, read by NVIDIA's own package, and what its writer makes of it read by simuli.

ncore_test.py SIMULI EXAMPLES WORK
"""
import json
import pathlib
import subprocess
import sys

import numpy as np
from ncore.data import v4
from ncore.impl.common.transformations import HalfClosedInterval
from ncore.impl.data import types
from upath import UPath

simuli, work = sys.argv[1], pathlib.Path(sys.argv[3])


def run(*words):
    subprocess.run([str(w) for w in words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def is_same_folder(a, b):
    files = sorted(p.relative_to(a) for p in a.rglob("*") if p.is_file())
    assert files == sorted(p.relative_to(b) for p in b.rglob("*") if p.is_file())
    return all((a / p).read_bytes() == (b / p).read_bytes() for p in files)


def matrix(pose):
    w, x, y, z = pose["rotation_wxyz"]
    out = np.eye(4)
    out[:3, :3] = [[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                   [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                   [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]]
    out[:3, 3] = pose["position_m"]
    return out


run(simuli, "synth", "street", "-o", work / "street.log", "--frames", 4, "--image-width", 64, "--image-height", 36,
    "--lidar-columns", 90, "--rolling-shutter")
log = json.loads((work / "street.log/log.json").read_text())
SHIFT_US = 1_000_000  # NCore has no times before 1970


def us(time_ns):
    return time_ns // 1000 + SHIFT_US


for name in ("street.ncore4.zarr", "street.ncore4.zarr.itar"):
    run(simuli, "export", work / "street.log", "-o", work / name)
    reader = v4.SequenceComponentGroupsReader([UPath(work / name)])
    assert reader.sequence_id == log["name"]
    # Poses.
    poses, = reader.open_component_readers(v4.PosesComponent.Reader).values()
    path, stamps = poses.get_dynamic_pose("rig", "world")
    assert path.dtype == np.float64 and stamps.tolist() == [us(p["time_ns"]) for p in log["world_from_rig"]]
    assert np.allclose(path, [matrix(p) for p in log["world_from_rig"]], rtol=0, atol=1e-15)
    for sensor in log["cameras"] + log["lidars"]:
        mount = sensor.get("rig_from_camera", sensor.get("rig_from_lidar"))
        assert np.allclose(poses.get_static_pose(sensor["name"], "rig"), matrix(mount), rtol=0, atol=1e-15)
    # Intrinsics.
    intrinsics, = reader.open_component_readers(v4.IntrinsicsComponent.Reader).values()
    camera, lidar = log["cameras"][0], log["lidars"][0]
    model = intrinsics.get_camera_model_parameters("front")
    assert isinstance(model, types.OpenCVPinholeCameraModelParameters)
    assert model.resolution.tolist() == [64, 36] and model.shutter_type == types.ShutterType.ROLLING_TOP_TO_BOTTOM
    assert np.array_equal(model.focal_length, np.float32([camera["fx_px"], camera["fy_px"]]))
    assert np.array_equal(model.principal_point, np.float32([camera["cx_px"], camera["cy_px"]]))
    beams = intrinsics.get_lidar_model_parameters("top")
    assert np.array_equal(beams.row_elevations_rad, np.float32([r["elevation_rad"] for r in lidar["rows"]]))
    assert np.array_equal(beams.row_azimuth_offsets_rad, np.float32([r["azimuth_offset_rad"] for r in lidar["rows"]]))
    assert (beams.n_rows, beams.n_columns, beams.spinning_direction) == (32, 90, "cw")
    # Pictures.
    cameras = reader.open_component_readers(v4.CameraSensorComponent.Reader)
    assert [(us(f["time_start_ns"]), us(f["time_end_ns"])) for f in log["images"]] == [
        tuple(t) for t in cameras["front"].frames_timestamps_us.tolist()]
    for frame, (_, end) in zip(log["images"], cameras["front"].frames_timestamps_us):
        data = cameras["front"].get_frame_data(int(end))
        assert data.get_encoded_image_data() == (work / "street.log" / frame["file"]).read_bytes()
        assert data.get_decoded_image().size == (64, 36)
    # Rays: what is there lies on its beam, as far as beams beside the sensor's centre let it.
    lidars = reader.open_component_readers(v4.LidarSensorComponent.Reader)
    returned = 0
    for start, end in lidars["top"].frames_timestamps_us.tolist():
        rays = {n: lidars["top"].get_frame_ray_bundle_data(end, n) for n in ("direction", "timestamp_us", "model_element")}
        valid = lidars["top"].get_frame_ray_bundle_return_valid_mask(end)[0]
        distance = lidars["top"].get_frame_ray_bundle_return_data(end, "distance_m", 0)
        assert np.array_equal(valid, ~np.isnan(distance)) and 0 < valid.sum() < len(valid)
        row, column = rays["model_element"].T
        azimuth = beams.column_azimuths_rad[column] + beams.row_azimuth_offsets_rad[row]
        elevation = beams.row_elevations_rad[row]
        beam = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], 1)
        off = np.linalg.norm(rays["direction"] - beam, axis=1)
        assert (off[~valid] < 1e-6).all() and (off[valid] * distance[valid] < 0.075).all()
        assert rays["timestamp_us"].min() >= start and rays["timestamp_us"].max() <= end
        returned += valid.sum()
    # Boxes.
    cuboids, = reader.open_component_readers(v4.CuboidsComponent.Reader).values()
    boxes = list(cuboids.get_observations())
    keys = [(a, k) for a in log["actors"] for k in a["track"]]
    assert len(boxes) == len(keys)
    for box, (actor, key) in zip(boxes, keys):
        assert (box.track_id, box.class_id, box.timestamp_us) == (actor["name"], actor["kind"], us(key["time_ns"]))
        assert box.bbox3.centroid == tuple(key["position_m"])
        assert box.bbox3.dim == (actor["length_m"], actor["width_m"], actor["height_m"])

    # Through their writer, with everything that they read; and without what they would not know of.
    for keeps in (True, False):
        for store in ("directory", "itar"):
            base = f"{pathlib.Path(name).suffix[1:]}-{keeps}-{store}"
            writer = v4.SequenceComponentGroupsWriter(
                UPath(work / base), "again", reader.sequence_id, reader.sequence_timestamp_interval_us,
                reader.generic_meta_data if keeps else {}, store_type=store)

            def register(kind, instance, group):
                return writer.register_component_writer(
                    kind.Writer, instance.instance_name, group, dict(instance.generic_meta_data) if keeps else {})

            out = register(v4.PosesComponent, poses, "")
            for (source, target), pose in poses.get_static_poses():
                out.store_static_pose(source, target, pose)
            out.store_dynamic_pose("rig", "world", path, stamps, require_sequence_time_coverage=False)
            out = register(v4.IntrinsicsComponent, intrinsics, "")
            out.store_camera_intrinsics("front", model)
            out.store_lidar_intrinsics("top", beams)
            register(v4.CuboidsComponent, cuboids, "").store_observations(boxes)
            out = register(v4.CameraSensorComponent, cameras["front"], "front")

            def generic(sensor, end):
                if not keeps:
                    return {}, {}
                arrays = {n: sensor.get_frame_generic_data(end, n) for n in sensor.get_frame_generic_data_names(end)}
                return arrays, sensor.get_frame_generic_meta_data(end)

            for times in cameras["front"].frames_timestamps_us:
                data = cameras["front"].get_frame_data(int(times[1]))
                out.store_frame(data.get_encoded_image_data(), data.get_encoded_image_format(), times,
                                *generic(cameras["front"], int(times[1])))
            sensor = lidars["top"]
            out = register(v4.LidarSensorComponent, sensor, "top")
            for times in sensor.frames_timestamps_us:
                end = int(times[1])
                rays = [sensor.get_frame_ray_bundle_data(end, n) for n in ("direction", "timestamp_us", "model_element")]
                returns = [sensor.get_frame_ray_bundle_return_data(end, n, None) for n in ("distance_m", "intensity")]
                out.store_frame(*rays, *returns, times, *generic(sensor, end))
            writer.finalize()
            again = work / f"{base}.log"
            run(simuli, "import", "ncore", work / base, "-o", again)
            if keeps:
                assert is_same_folder(work / "street.log", again), base
                continue
            told = json.loads((again / "log.json").read_text())
            assert [p["file"] for p in told["images"]] == [p["file"] for p in log["images"]]
            assert all((again / p["file"]).read_bytes() == (work / "street.log" / p["file"]).read_bytes()
                       for p in log["images"])
            shift_ns = 1000 * SHIFT_US  # of absolute times
            for a, b in zip(log["world_from_rig"], told["world_from_rig"]):
                assert b["time_ns"] == a["time_ns"] + shift_ns
                assert np.allclose(matrix(a), matrix(b), rtol=0, atol=1e-12)
            for key in ("fx_px", "fy_px", "cx_px", "cy_px"):
                assert told["cameras"][0][key] == float(np.float32(camera[key]))
            for key in ("elevation_rad", "azimuth_offset_rad"):
                assert [r[key] for r in told["lidars"][0]["rows"]] == [float(np.float32(r[key])) for r in lidar["rows"]]
            # What their reader says of a log of ours once more: the same rays, times and distances.
            run(simuli, "export", again, "-o", work / f"{base}.ncore4.zarr")
            twice = v4.SequenceComponentGroupsReader([UPath(work / f"{base}.ncore4.zarr")])
            other = twice.open_component_readers(v4.LidarSensorComponent.Reader)["top"]
            assert np.array_equal(other.frames_timestamps_us, sensor.frames_timestamps_us)
            for end in sensor.frames_timestamps_us[:, 1].tolist():
                a, b = [[r.get_frame_ray_bundle_data(end, n) for n in ("direction", "timestamp_us")] + [
                    r.get_frame_ray_bundle_return_data(end, n, 0) for n in ("distance_m", "intensity")]
                    for r in (sensor, other)]
                assert np.allclose(a[0], b[0], rtol=0, atol=1e-6)
                assert np.abs(a[1].astype(np.int64) - b[1].astype(np.int64)).max() <= 1
                assert np.allclose(a[2], b[2], rtol=1e-6, atol=0, equal_nan=True)
                assert np.array_equal(a[3], b[3], equal_nan=True)
print(returned, "returns of a street in NCore, 8 times through its own package")
