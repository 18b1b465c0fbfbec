"""Version 2 of the Waymo Open Dataset through its converter: waymo2_test.py SIMULI EXAMPLES WORK

A segment of version 1 (a seed of the fuzzer, written by the tests of `import waymo`) as columns of version 2, as the data
set's compat_v1 makes them; what comes back has to be the same log, byte for byte."""
import filecmp
import json
import pathlib
import struct
import subprocess
import sys
import zlib

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

simuli, examples, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
seed = pathlib.Path(__file__).parents[1] / "fuzz" / "seeds" / "waymo_records" / "segment"
SEGMENT = "10203656353524179475_7625_000_7645_000"


def fields(data):
    """(number, value) of a message's fields: integers, doubles, bytes."""
    at, out = 0, []

    def varint():
        nonlocal at
        value, shift = 0, 0
        while True:
            byte = data[at]
            at += 1
            value |= (byte & 127) << shift
            shift += 7
            if byte < 128:
                return value

    while at < len(data):
        key = varint()
        if key & 7 == 0:
            out.append((key >> 3, varint()))
        elif key & 7 == 1:
            out.append((key >> 3, struct.unpack_from("<d", data, at)[0]))
            at += 8
        else:
            size = varint()
            out.append((key >> 3, data[at:at + size]))
            at += size
    return out


def of(message, number):
    return [value for field, value in message if field == number]


def one(message, number, other=0):
    return (of(message, number) or [other])[0]


def doubles(message, number):
    """A repeated field, packed or not."""
    values = of(message, number)
    return np.frombuffer(values[0], "<f8").tolist() if values and isinstance(values[0], bytes) else values


def matrix(message, number):
    return doubles(fields(one(message, number)), 1)


def varint(value):
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out) + bytes([value])


def frames(file):
    """The seed's one whole frame, and once more a turn later, as `file` and as fields."""
    data = seed.read_bytes()
    first = data[12:12 + struct.unpack_from("<Q", data)[0]]
    time = one(fields(first), 2)
    second = first.replace(b"\x10" + varint(time), b"\x10" + varint(time + 100_000))
    assert second != first and len(second) == len(first)
    head = struct.pack("<Q", len(first)) + bytes(4)
    file.write_bytes(b"".join(head + frame + bytes(4) for frame in (first, second)))
    return [fields(first), fields(second)]


TRANSFORM = pa.list_(pa.float64(), 16)


def write(folder, component, rows, types):
    """Rows of dictionaries as SEGMENT.parquet, in groups of one row as large files have groups of some."""
    names = {n: n if n.startswith("key.") else f"[{component}].{n}" for n in types}
    schema = pa.schema([(names[n], types[n]) for n in types])
    table = pa.Table.from_pylist([{names[n]: row.get(n) for n in types} for row in rows], schema)
    folder.mkdir(parents=True)
    pq.write_table(table, folder / f"{SEGMENT}.parquet", row_group_size=1)


def as_version_2(all_frames, root):
    key = {"key.segment_context_name": pa.string()}
    frame_key = {**key, "key.frame_timestamp_micros": pa.int64()}
    tables = {name: [] for name in ("camera_image", "camera_calibration", "lidar", "lidar_calibration",
                                    "vehicle_pose", "lidar_box")}
    for i, frame in enumerate(all_frames):
        own = {"key.segment_context_name": SEGMENT, "key.frame_timestamp_micros": one(frame, 2)}
        context = fields(one(frame, 1))
        for c in map(fields, of(context, 2) if i == 0 else []):
            k = dict(zip(("f_u", "f_v", "c_u", "c_v", "k1", "k2", "p1", "p2", "k3"), doubles(c, 2)))
            tables["camera_calibration"].append({
                "key.segment_context_name": SEGMENT, "key.camera_name": one(c, 1),
                **{f"intrinsic.{name}": value for name, value in k.items()}, "extrinsic.transform": matrix(c, 3),
                "width": one(c, 4), "height": one(c, 5), "rolling_shutter_direction": one(c, 6)})
        for c in map(fields, of(context, 3) if i == 0 else []):
            tables["lidar_calibration"].append({
                "key.segment_context_name": SEGMENT, "key.laser_name": one(c, 1),
                "beam_inclination.min": one(c, 3, 0.0), "beam_inclination.max": one(c, 4, 0.0),
                "beam_inclination.values": doubles(c, 2) or None,
                "extrinsic.transform": matrix(c, 5) if of(c, 5) else list(np.eye(4).ravel())})
        tables["vehicle_pose"].append({**own, "world_from_vehicle.transform": matrix(frame, 3)})
        for p in map(fields, of(frame, 4)):
            tables["camera_image"].append({
                **own, "key.camera_name": one(p, 1), "image": one(p, 2), "pose.transform": matrix(p, 3),
                "velocity.linear_velocity.x": 0.0, "pose_timestamp": one(p, 5),
                "rolling_shutter_params.shutter": one(p, 6), "rolling_shutter_params.camera_trigger_time": one(p, 7),
                "rolling_shutter_params.camera_readout_done_time": one(p, 8)})
        for laser in map(fields, of(frame, 5)):
            packed = one(fields(one(laser, 2)), 2)
            image = fields(zlib.decompress(packed, 15 + 32))
            tables["lidar"].append({
                **own, "key.laser_name": one(laser, 1),
                "range_image_return1.values": np.frombuffer(one(image, 1), "<f4").tolist(),
                "range_image_return1.shape": of(fields(one(image, 2)), 1)})
        # One without a first return, as compat_v1 leaves them.
        tables["lidar"].append({**own, "key.laser_name": 5})
        for b in map(fields, of(frame, 6)):
            box = fields(one(b, 1))
            tables["lidar_box"].append({
                **own, "key.laser_object_id": one(b, 4).decode(), "box.center.x": one(box, 1),
                "box.center.y": one(box, 2), "box.center.z": one(box, 3), "box.size.y": one(box, 4),
                "box.size.x": one(box, 5), "box.size.z": one(box, 6), "box.heading": one(box, 7), "type": one(b, 3)})
    real = pa.float64()
    write(root / "camera_calibration", "CameraCalibrationComponent", tables["camera_calibration"], {
        **key, "key.camera_name": pa.int8(),
        **{f"intrinsic.{n}": real for n in ("f_u", "f_v", "c_u", "c_v", "k1", "k2", "p1", "p2", "k3")},
        "extrinsic.transform": TRANSFORM, "width": pa.int32(), "height": pa.int32(),
        "rolling_shutter_direction": pa.int8()})
    write(root / "lidar_calibration", "LiDARCalibrationComponent", tables["lidar_calibration"], {
        **key, "key.laser_name": pa.int8(), "beam_inclination.min": real, "beam_inclination.max": real,
        "beam_inclination.values": pa.list_(real), "extrinsic.transform": TRANSFORM})
    # As in the published file of the repository, in which poses are float.
    write(root / "vehicle_pose", "VehiclePoseComponent", tables["vehicle_pose"], {
        **frame_key, "world_from_vehicle.transform": pa.list_(pa.float32(), 16)})
    write(root / "camera_image", "CameraImageComponent", tables["camera_image"], {
        **frame_key, "key.camera_name": pa.int8(), "image": pa.binary(), "pose.transform": TRANSFORM,
        "velocity.linear_velocity.x": pa.float32(), "pose_timestamp": real,
        **{f"rolling_shutter_params.{n}": real for n in ("shutter", "camera_trigger_time",
                                                         "camera_readout_done_time")}})
    write(root / "lidar", "LiDARComponent", tables["lidar"], {
        **frame_key, "key.laser_name": pa.int8(), "range_image_return1.values": pa.list_(pa.float32()),
        "range_image_return1.shape": pa.list_(pa.int32(), 3)})
    write(root / "lidar_box", "LiDARBoxComponent", tables["lidar_box"], {
        **frame_key, "key.laser_object_id": pa.string(),
        **{f"box.{n}": real for n in ("center.x", "center.y", "center.z", "size.x", "size.y", "size.z", "heading")},
        "type": pa.int8()})


def convert(*arguments):
    return subprocess.run([sys.executable, examples / "convert_waymo2.py", *map(str, arguments)], text=True,
                          capture_output=True)


def imported(segment, log):
    run = subprocess.run([simuli, "import", "waymo", segment, "-o", log], text=True, capture_output=True)
    assert run.returncode == 0, run.stderr
    return json.loads((log / "log.json").read_text())


root = work / "v2"
there = frames(work / "v1.tfrecord")
as_version_2(there, root)
said = convert(root, work / "back.tfrecord")
assert said.returncode == 0, said.stderr
assert f"{SEGMENT}: {len(there)} frames, 1 camera," in said.stdout and "2 boxes" in said.stdout, said.stdout
first, second = imported(work / "v1.tfrecord", work / "v1.log"), imported(work / "back.tfrecord", work / "v2.log")
assert second["name"] == SEGMENT.replace("-", "_"), second["name"]
assert {**first, "name": ""} == {**second, "name": ""}, (first, second)
for folder in ("images", "sweeps"):
    names = sorted(f.name for f in (work / "v1.log" / folder).iterdir())
    assert names and names == sorted(f.name for f in (work / "v2.log" / folder).iterdir())
    same, other, failed = filecmp.cmpfiles(work / "v1.log" / folder, work / "v2.log" / folder, names, shallow=False)
    assert not other and not failed, other

# What is not there is said: boxes, a component, a column; and nothing is overwritten.
(root / "lidar_box" / f"{SEGMENT}.parquet").unlink()
assert "no boxes: lidar_box is not there" in convert(root, work / "bare.tfrecord", SEGMENT).stdout
assert "actors" not in (bare := imported(work / "bare.tfrecord", work / "bare.log")) or not bare["actors"]
assert "FileExistsError" in convert(root, work / "bare.tfrecord").stderr
pq.write_table(pq.read_table(root / "lidar" / f"{SEGMENT}.parquet").drop_columns(
    ["[LiDARComponent].range_image_return1.shape"]), root / "lidar" / f"{SEGMENT}.parquet")
run = convert(root, work / "x.tfrecord")
assert run.returncode == 1 and "no column [LiDARComponent].range_image_return1.shape" in run.stderr, run.stderr
(root / "lidar" / f"{SEGMENT}.parquet").unlink()
run = convert(root, work / "x.tfrecord")
assert run.returncode == 1 and "lidar" in run.stderr and "no such file" in run.stderr, run.stderr
