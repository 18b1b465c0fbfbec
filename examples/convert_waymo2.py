"""convert_waymo2.py FOLDER OUT.tfrecord [SEGMENT]: a segment of the Waymo Open Dataset, Perception version 2 (parquet),
as one of version 1 for `simuli import waymo OUT.tfrecord -o drive.log`.

FOLDER holds a folder per component, as downloaded: camera_image, camera_calibration, lidar, lidar_calibration,
vehicle_pose and, for actors, lidar_box, each with SEGMENT.parquet; without SEGMENT the only one. Needs NumPy and
pyarrow. After the data set's own code (github.com/waymo-research/waymo-open-dataset, src/waymo_open_dataset/v2):
components are columns of what version 1 has in a message per frame, so that this only names them back, value for
value. Of a laser the first return is kept, TOP is what simuli reads; labels of pictures, maps and keypoints are left
out. The records have no checksums, which simuli does not ask for and TensorFlow does.
"""
import collections
import pathlib
import struct
import sys
import zlib

import numpy as np
import pyarrow.parquet as pq

from points_folder import run

TIME, CAMERA, LASER = "key.frame_timestamp_micros", "key.camera_name", "key.laser_name"
LENS = ("f_u", "f_v", "c_u", "c_v", "k1", "k2", "p1", "p2", "k3")
BOX = ("center.x", "center.y", "center.z", "size.y", "size.x", "size.z", "heading")  # fields 1 to 7 of Label.Box


def varint(value):
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes(out) + bytes([value])


def number(field, value):
    return varint(field << 3) + varint(int(value))


def blob(field, value):
    return varint(field << 3 | 2) + varint(len(value)) + value


def real(field, value):
    return varint(field << 3 | 1) + struct.pack("<d", value)


def reals(field, values):
    return b"".join(real(field, v) for v in values)


def transform(field, values):
    return blob(field, reals(1, values))


class Component:
    """Rows of a component's file, by what identifies them; one group of rows at a time is in memory."""

    def __init__(self, folder, component, segment, keys, wanted):
        file = folder / component / f"{segment}.parquet"
        if not file.is_file():
            sys.exit(f"{file}: no such file")
        self.file, self.group, self.rows = pq.ParquetFile(file), None, []
        there = set(self.file.schema_arrow.names)
        lacking = [name for name in [*keys, *wanted] if name not in there]
        if lacking:
            sys.exit(f"{file}: no column {lacking[0]}; it has {', '.join(sorted(there))}")
        self.wanted, self.places = list(wanted), collections.OrderedDict()
        for group in range(self.file.num_row_groups):
            table = self.file.read_row_group(group, columns=list(keys)).to_pydict()
            for row, key in enumerate(zip(*(table[k] for k in keys))):
                self.places.setdefault(key, []).append((group, row))

    def get(self, *key):
        """All rows of that key, as dictionaries of columns without the component's name."""
        out = []
        for group, row in self.places.get(key, []):
            if group != self.group:
                self.table, self.group = self.file.read_row_group(group, columns=self.wanted), group
            out.append({name.split("].", 1)[-1]: self.table[name][row] for name in self.wanted})
        return out


def columns(component, *names):
    return [f"[{component}].{name}" for name in names]


def context(folder, segment):
    """Name, cameras and lasers of a frame's context; and how many of either."""
    name = "CameraCalibrationComponent"
    cameras = Component(folder, "camera_calibration", segment, [CAMERA], columns(
        name, *(f"intrinsic.{k}" for k in LENS), "extrinsic.transform", "width", "height", "rolling_shutter_direction"))
    out = blob(1, segment.encode())
    for (camera,) in cameras.places:
        c = {k: v.as_py() for k, v in cameras.get(camera)[0].items()}
        out += blob(2, number(1, camera) + reals(2, [c[f"intrinsic.{k}"] for k in LENS])
                    + transform(3, c["extrinsic.transform"]) + number(4, c["width"]) + number(5, c["height"])
                    + number(6, c["rolling_shutter_direction"]))
    name = "LiDARCalibrationComponent"
    lasers = Component(folder, "lidar_calibration", segment, [LASER], columns(
        name, "beam_inclination.min", "beam_inclination.max", "beam_inclination.values", "extrinsic.transform"))
    for (laser,) in lasers.places:
        c = {k: v.as_py() for k, v in lasers.get(laser)[0].items()}
        out += blob(3, number(1, laser) + reals(2, c["beam_inclination.values"] or [])
                    + real(3, c["beam_inclination.min"]) + real(4, c["beam_inclination.max"])
                    + transform(5, c["extrinsic.transform"]))
    return out, len(cameras.places), [laser for (laser,) in lasers.places]


def picture(camera, row):
    value = {k: v.as_py() for k, v in row.items()}
    shutter = "rolling_shutter_params."
    return blob(4, number(1, camera) + blob(2, value["image"]) + transform(3, value["pose.transform"])
                + real(5, value["pose_timestamp"]) + real(6, value[shutter + "shutter"])
                + real(7, value[shutter + "camera_trigger_time"])
                + real(8, value[shutter + "camera_readout_done_time"]))


def sweep(laser, row):
    """The first return, compressed as version 1 has it; nothing where there is none."""
    values, shape = row["range_image_return1.values"], row["range_image_return1.shape"]
    if not values.is_valid:
        return b""
    data = np.asarray(values.values.to_numpy(zero_copy_only=False), "<f4").tobytes()
    dims = b"".join(number(1, n) for n in shape.as_py())
    return blob(5, number(1, laser) + blob(2, blob(2, zlib.compress(blob(1, data) + blob(2, dims), 1))))


def label(key, row):
    value = {k: v.as_py() for k, v in row.items()}
    box = b"".join(real(i + 1, value["box." + name]) for i, name in enumerate(BOX))
    return blob(6, blob(1, box) + number(3, value["type"]) + blob(4, key.encode()))


def main(folder, out, segment=None):
    folder = pathlib.Path(folder)
    if segment is None:
        there = sorted(f.stem for f in (folder / "vehicle_pose").glob("*.parquet"))
        if len(there) != 1:
            sys.exit(f"{folder / 'vehicle_pose'}: {len(there)} segments; SEGMENT says which: {', '.join(there[:5])}")
        segment = there[0]
    head, camera_count, lasers = context(folder, segment)
    poses = Component(folder, "vehicle_pose", segment, [TIME],
                      columns("VehiclePoseComponent", "world_from_vehicle.transform"))
    images = Component(folder, "camera_image", segment, [TIME, CAMERA], columns(
        "CameraImageComponent", "image", "pose.transform", "pose_timestamp", "rolling_shutter_params.shutter",
        "rolling_shutter_params.camera_trigger_time", "rolling_shutter_params.camera_readout_done_time"))
    sweeps = Component(folder, "lidar", segment, [TIME, LASER],
                       columns("LiDARComponent", "range_image_return1.values", "range_image_return1.shape"))
    boxes = None
    if (folder / "lidar_box" / f"{segment}.parquet").is_file():
        boxes = Component(folder, "lidar_box", segment, [TIME, "key.laser_object_id"],
                          columns("LiDARBoxComponent", *(f"box.{name}" for name in BOX), "type"))
    times = sorted(t for (t,) in poses.places)
    ids, cameras = collections.defaultdict(list), collections.defaultdict(list)
    for t, key in boxes.places if boxes else ():
        ids[t].append(key)
    for t, camera in images.places:
        cameras[t].append(camera)
    lost_pictures = lost_sweeps = 0
    with open(out, "xb") as file:
        for t in times:
            frame = blob(1, head) + number(2, t)
            frame += transform(3, poses.get(t)[0]["world_from_vehicle.transform"].as_py())
            for camera in sorted(cameras[t]):
                frame += picture(camera, images.get(t, camera)[0])
            lost_pictures += camera_count - len(cameras[t])
            for laser in lasers:
                found = b"".join(sweep(laser, row) for row in sweeps.get(t, laser)[:1])
                frame += found
                lost_sweeps += laser == 1 and not found
            for key in ids[t]:
                frame += b"".join(label(key, row) for row in boxes.get(t, key)[:1])
            file.write(struct.pack("<Q", len(frame)) + bytes(4) + frame + bytes(4))
    posed = set(times)
    beside = sum(k[0] not in posed for c in (images, sweeps) for k in c.places)
    print(f"{segment}: {len(times)} frames, {camera_count} camera{'s' * (camera_count != 1)}, lasers {', '.join(map(str, sorted(lasers)))} "
          f"(1: TOP), {'no boxes: lidar_box is not there' if boxes is None else f'{len(boxes.places)} boxes'}")
    for count, what in ((lost_pictures, "pictures are not there"), (lost_sweeps, "sweeps of TOP are not there"),
                        (beside, "pictures and sweeps have no pose of the vehicle and are left out")):
        if count:
            print(f"{count} {what}")


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    run(main, *sys.argv[1:])
