"""to_mcap.py SCENE OUT.mcap T0:T1:DT FOLDER...: what `simuli render` has written, for Foxglove.

Needs PyPI's foxglove-sdk and NumPy. FOLDERs are those of
    simuli render SCENE --sensor NAME --times T0:T1:DT --clouds npz -o FOLDER
with the same times: pictures become CompressedImage with the camera's CameraCalibration, clouds PointCloud, the
scene's path, mountings and boxes FrameTransform and SceneUpdate. Times count from the Unix epoch's start.
"""
import json
import pathlib
import re
import sys

import foxglove
import numpy as np
from foxglove import channels, messages as m

FIELDS = ("x", "y", "z", "intensity", "range", "drop")
# Names and parameters as Foxglove's CameraCalibration has them; other lenses get K alone.
MODELS = {"opencv_pinhole": ("rational_polynomial", ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6")),
          "opencv_fisheye": ("kannala_brandt", ("k1", "k2", "k3", "k4"))}


def vector(v):
    return m.Vector3(x=v[0], y=v[1], z=v[2])


def turn(wxyz):
    return m.Quaternion(w=wxyz[0], x=wxyz[1], y=wxyz[2], z=wxyz[3])


def stamp(ns):
    return m.Timestamp(sec=int(ns // 10**9), nsec=int(ns % 10**9))


def frame(ns, parent, child, pose):
    return m.FrameTransform(timestamp=stamp(ns), parent_frame_id=parent, child_frame_id=child,
                            translation=vector(pose["position_m"]), rotation=turn(pose["rotation_wxyz"]))


def calibration(ns, c, scale):
    k = [c["fx_px"] * scale, 0, c["cx_px"] * scale, 0, c["fy_px"] * scale, c["cy_px"] * scale, 0, 0, 1]
    model, names = MODELS.get(c.get("model", "pinhole"), ("", ()))
    return m.CameraCalibration(timestamp=stamp(ns), frame_id=c["name"], width=round(c["width_px"] * scale),
                               height=round(c["height_px"] * scale), distortion_model=model,
                               D=[c[n] for n in names], K=k, R=[1, 0, 0, 0, 1, 0, 0, 0, 1],
                               P=[*k[:3], 0, *k[3:6], 0, *k[6:], 0])


def png_width(data):
    return int.from_bytes(data[16:20], "big")


def cloud(ns, file):
    values = np.load(file)
    columns = {**dict(zip("xyz", values["xyz"].T)), **{n: values[n] for n in FIELDS[3:]}}
    packed = np.column_stack([columns[n] for n in FIELDS]).astype("<f4")
    fields = [m.PackedElementField(name=n, offset=4 * i, type=m.PackedElementFieldNumericType.Float32)
              for i, n in enumerate(FIELDS)]
    here = m.Pose(position=vector((0, 0, 0)), orientation=turn((1, 0, 0, 0)))
    return m.PointCloud(timestamp=stamp(ns), frame_id="world", pose=here, point_stride=4 * len(FIELDS), fields=fields,
                        data=packed.tobytes())


def box(ns, actor, key):
    pose = m.Pose(position=vector(key["position_m"]), orientation=turn(key["rotation_wxyz"]))
    size = vector((actor["length_m"], actor["width_m"], actor["height_m"]))
    cube = m.CubePrimitive(pose=pose, size=size, color=m.Color(r=1, g=0.6, b=0.1, a=0.4))
    return m.SceneUpdate(entities=[m.SceneEntity(timestamp=stamp(ns), frame_id="world", id=actor["name"],
                                                 cubes=[cube])])


def main(scene, out, times, *folders):
    scene = json.loads((pathlib.Path(scene) / "scene.json").read_text())
    start_s, _, step_s = (float(t) for t in times.split(":"))
    cameras = {c["name"]: c for c in scene["cameras"]}
    transforms = channels.FrameTransformChannel("/tf")
    boxes = channels.SceneUpdateChannel("/actors")
    with foxglove.open_mcap(out):
        epoch = -min(0, scene["world_from_rig"][0]["time_ns"])  # of the log's start: no time before 1970
        for p in scene["world_from_rig"]:
            ns = epoch + p["time_ns"]
            transforms.log(frame(ns, "world", "rig", p), log_time=ns)
        for sensor, mount in [(s, s["rig_from_camera"]) for s in scene["cameras"]] + [
                (s, s["rig_from_lidar"]) for s in scene["lidars"]]:
            transforms.log(frame(0, "rig", sensor["name"], mount), log_time=0)
        for actor in scene.get("actors", []):
            for key in actor["track"]:
                ns = epoch + key["time_ns"]
                boxes.log(box(ns, actor, key), log_time=ns)
        for folder in folders:
            open_channels = {}
            for file in sorted(pathlib.Path(folder).iterdir()):
                found = re.fullmatch(r"(.+)_(\d{6})(_range)?\.(png|npz)", file.name)
                if not found or found[3]:
                    continue
                name, ns = found[1], epoch + round((start_s + int(found[2]) * step_s) * 1e9)
                if file.suffix == ".npz":
                    if name not in open_channels:
                        open_channels[name] = channels.PointCloudChannel(f"/{name}/points")
                    open_channels[name].log(cloud(ns, file), log_time=ns)
                    continue
                if name not in open_channels:
                    open_channels[name] = (channels.CompressedImageChannel(f"/{name}/image"),
                                           channels.CameraCalibrationChannel(f"/{name}/calibration"))
                picture, lens = open_channels[name]
                data = file.read_bytes()
                picture.log(m.CompressedImage(timestamp=stamp(ns), frame_id=name, format="png", data=data), log_time=ns)
                if name in cameras:
                    scale = png_width(data) / cameras[name]["width_px"]
                    lens.log(calibration(ns, cameras[name], scale), log_time=ns)


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    main(*sys.argv[1:])
