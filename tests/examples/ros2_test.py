"""A rendered drive as a recording of ROS 2, read by the packages of others, and their recording read by simuli.

ros2_test.py SIMULI EXAMPLES WORK
"""
import collections
import json
import pathlib
import subprocess
import sys

import numpy as np
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer as McapWriter
from mcap_ros2.decoder import DecoderFactory
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

simuli, work = sys.argv[1], pathlib.Path(sys.argv[3])
store = get_typestore(Stores.ROS2_HUMBLE)


def run(*words):
    return subprocess.run([str(w) for w in words], check=True, capture_output=True, text=True).stdout


def sweeps_of(recording, log):
    run(simuli, "import", "mcap", recording, "-o", log, "--lidar", f"/top/points={work / 'top.json'}")
    told = json.loads((log / "log.json").read_text())
    assert len(told["images"]) == 3 and len(told["sweeps"]) == 3
    return b"".join((log / s["file"]).read_bytes() for s in told["sweeps"])


run(simuli, "synth", "street", "-o", work / "street.log", "--frames", 4, "--image-width", 64, "--image-height", 36,
    "--lidar-columns", 90)
run(simuli, "train", work / "street.log", "-o", work / "street.scene", "--iterations", 2)
run(simuli, "render", work / "street.scene", "--times", "0:0.2:0.1", "-o", work / "street.mcap")
run(simuli, "render", work / "street.scene", "--sensor", "top", "--times", "0:0.2:0.1", "--clouds", "npz",
    "--cloud-frame", "sensor", "-o", work / "top")
run(simuli, "render", work / "street.scene", "--sensor", "front", "--times", "0:0.2:0.1", "--images", "raw", "-o",
    work / "raw.mcap")

# Decoded by the schemas in the file; and by a table of message types that is not ours, to bytes that are the same.
topics, messages = collections.defaultdict(list), []
for name in ("street.mcap", "raw.mcap"):
    with open(work / name, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        assert reader.get_header().profile == "ros2"
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            topics[channel.topic, schema.name].append((message, decoded))
            known = store.deserialize_cdr(message.data, schema.name)
            assert bytes(store.serialize_cdr(known, schema.name)) == message.data, schema.name
            if name == "street.mcap":
                messages.append((channel.topic, schema.name, message.log_time, message.data))
        counts = reader.get_summary().statistics.channel_message_counts
        assert sum(counts.values()) == reader.get_summary().statistics.message_count > 0
clouds = topics["/top/points", "sensor_msgs/msg/PointCloud2"]
assert len(clouds) == 3 and clouds[1][0].log_time - clouds[0][0].log_time == 100_000_000
cloud, expected = clouds[0][1], np.load(sorted((work / "top").glob("*.npz"))[0])
layout = np.dtype({"names": [f.name for f in cloud.fields], "offsets": [f.offset for f in cloud.fields],
                   "formats": [{4: "<u2", 7: "<f4"}[f.datatype] for f in cloud.fields], "itemsize": cloud.point_step})
points = np.frombuffer(bytes(cloud.data), layout)
assert layout.names == ("x", "y", "z", "intensity", "ring", "time") and len(points) == len(expected["xyz"])
assert np.allclose(np.stack([points[n] for n in "xyz"], 1), expected["xyz"], atol=1e-5)
assert np.array_equal(points["ring"], expected["ring"]) and np.allclose(points["intensity"], 255 * expected["intensity"])
assert len(topics["/front/image_raw/compressed", "sensor_msgs/msg/CompressedImage"]) == 3
assert len(topics["/front/image_raw", "sensor_msgs/msg/Image"]) == 3
info = topics["/front/camera_info", "sensor_msgs/msg/CameraInfo"][0][1]
assert (info.width, info.height, info.distortion_model) == (64, 36, "plumb_bob")
(static, fixed), = topics["/tf_static", "tf2_msgs/msg/TFMessage"][:1]
assert {t.child_frame_id for t in fixed.transforms} == {"front_optical_frame", "top"}
assert len(topics["/tf", "tf2_msgs/msg/TFMessage"]) > 20
assert len(topics["/actors", "visualization_msgs/msg/MarkerArray"]) == 3 + 3

# Recorded by a writer that is not ours, in either container; from both the same log.
(work / "top.json").write_text(run(simuli, "info", work / "street.log", "top", "--json"))
hashes = set()
for plugin in (StoragePlugin.MCAP, StoragePlugin.SQLITE3):
    folder = work / plugin.name
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        connections = {topic: writer.add_connection(topic, kind, typestore=store)
                       for topic, kind in {(m[0], m[1]) for m in messages}}
        for topic, _, time_ns, data in messages:
            writer.write(connections[topic], time_ns, data)
    hashes.add(sweeps_of(folder, work / f"{plugin.name}.log"))
# The same from mcap's own writer, with either compression and without chunks.
for name, options in (("lz4", {"compression": CompressionType.LZ4}), ("zstd", {"compression": CompressionType.ZSTD}),
                      ("flat", {"use_chunking": False})):
    with open(work / f"{name}.mcap", "wb") as file:
        writer = McapWriter(file, enable_data_crcs=True, **options)
        writer.start("ros2", "test")
        channels = {topic: writer.register_channel(topic, "cdr", writer.register_schema(kind, "ros2msg", b""))
                    for topic, kind in {(m[0], m[1]) for m in messages}}
        for topic, _, time_ns, data in messages:
            writer.add_message(channels[topic], time_ns, data, time_ns)
        writer.finish()
    hashes.add(sweeps_of(work / f"{name}.mcap", work / f"{name}.log"))
assert len(hashes) == 1
