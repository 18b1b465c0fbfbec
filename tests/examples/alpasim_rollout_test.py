"""Rollouts of AlpaSim's own runtime with `simuli serve` as its renderer: alpasim_rollout_test.py SIMULI EXAMPLES WORK

SIMULI_ALPASIM names a checkout of AlpaSim. Its traffic and physics are skipped, as its own configuration allows, and so
are driver and controller but in the last rollouts; alpasim_stand_ins has what is not to be had from PyPI.
"""
import asyncio
import io
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tomllib
from concurrent import futures

import grpc
import numpy as np
import yaml
from grpc_tools import protoc
from PIL import Image

simuli, work = sys.argv[1], pathlib.Path(sys.argv[3])
source = pathlib.Path(os.environ.get("SIMULI_ALPASIM", "/nonexistent")) / "src"
if not (source / "runtime/alpasim_runtime/simulate/__main__.py").is_file():
    print("SKIPPED: alpasim_rollout_test.py, SIMULI_ALPASIM names no folder with AlpaSim's src/runtime")
    sys.exit()

# Its messages as its own build makes them, outside of its folder, and what it asks of its installed packages.
python = work / "python"
shutil.copytree(source / "grpc/alpasim_grpc", python / "alpasim_grpc")
protos = [str(p.relative_to(source / "grpc")) for p in (source / "grpc/alpasim_grpc/v0").glob("*.proto")]
assert protoc.main(["protoc", f"-I{source / 'grpc'}", f"--python_out={python}", f"--grpc_python_out={python}",
                    *protos]) == 0
for package in ("grpc", "controller"):
    told = tomllib.loads((source / package / "pyproject.toml").read_text())["project"]
    info = python / f"alpasim_{package}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Name: alpasim_{package}\nVersion: {told['version']}\n")
    (info / "entry_points.txt").write_text("".join(
        f"[{group}]\n" + "".join(f"{name} = {where}\n" for name, where in rows.items())
        for group, rows in told.get("entry-points", {}).items()))
sys.dont_write_bytecode = True
sys.path[:0] = [str(p) for p in (python, pathlib.Path(__file__).parent / "alpasim_stand_ins", source / "runtime",
                                 source / "utils", source / "eval/src", source / "controller", source / "plugins")]
import prometheus_client  # noqa: E402

serve_numbers = prometheus_client.start_http_server  # its telemetry's numbers: on loopback alone
prometheus_client.start_http_server = lambda port, **more: serve_numbers(port, **(more | {"addr": "127.0.0.1"}))
from alpasim_controller.mpc_controller import ControllerConfig  # noqa: E402
from alpasim_controller.server import VDCSimService  # noqa: E402
from alpasim_grpc.v0 import common_pb2, egodriver_pb2, egodriver_pb2_grpc, logging_pb2  # noqa: E402
from alpasim_grpc.v0.controller_pb2_grpc import add_VDCServiceServicer_to_server  # noqa: E402
from alpasim_runtime.simulate import __main__ as simulate  # noqa: E402
from alpasim_utils.artifact import Artifact  # noqa: E402
from alpasim_utils.geometry import Pose, Trajectory, trajectory_to_grpc  # noqa: E402

CAMERAS = ("front", "left", "right")
SIZE = (160, 90)
STEP_US = 100_000
SHUTTER_US = 30_000  # the street's cameras have global ones: they show the world as it is when these open
SHIFT_M = 1.0
NEAR = 1.5  # of 255: poses have single precision on the wire


def run(*words):
    subprocess.run([str(w) for w in words], cwd=work, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def settings(ports, simulation, more):
    """What its wizard would write: whose port is not given is skipped."""
    names = ("controller", "driver", "physics", "renderer", "trafficsim")
    cameras = [{"logical_id": name, "width": SIZE[0], "height": SIZE[1], "frame_interval_us": STEP_US,
                "shutter_duration_us": SHUTTER_US} for name in CAMERAS]
    user = {
        "endpoints": {name: {"skip": name not in ports, "n_concurrent_rollouts": 1} for name in names},
        "nr_workers": 1, "max_rollout_retries": 0, "smooth_trajectories": False,
        "prometheus": {"url": None, "worker_ports": [0]},
        "renderer": {"kind": "sensorsim", "video_model_config": None},
        "scene_provider": {"kind": "usdz", "usdz": {"data_dir": str(work / "street.usdz")}},
        "scenes": [{"scene_id": "street"}],
        "simulation_config": {
            "n_sim_steps": 1000, "n_rollouts": 1, "cameras": cameras, "control_timestep_us": STEP_US,
            "pose_reporting_interval_us": 10_000,  # else the rig goes straight between steps, where shutters open
            "force_gt_duration_us": 1000 * STEP_US, "assert_zero_decision_delay": True, "image_format": "png",
            "min_traffic_duration_us": 0, "render_bundling": "NONE", "route_generator_type": "RECORDED",
            "send_recording_ground_truth": True, "vehicle": {}} | simulation} | more
    network = {name: {"endpoints": [{"address": f"127.0.0.1:{ports[name]}", "managed": False}] if name in ports else []}
               for name in names}
    return user, network


def rollout(name, ports, simulation=None, **more):
    """Runs one; what its log holds, by kind."""
    folder = work / name
    folder.mkdir()
    (folder / "run_metadata.yaml").write_text("run_uuid: street\nrun_name: street\n")
    for file, content in zip(("user", "network"), settings(ports, simulation or {}, more)):
        (folder / f"{file}.yaml").write_text(yaml.safe_dump(content))
    words = simulate.create_arg_parser().parse_args([
        f"--user-config={folder / 'user.yaml'}", f"--network-config={folder / 'network.yaml'}", f"--log-dir={folder}",
        f"--eval-config={source / 'runtime/tests/data/mock/eval-config.yaml'}"])
    assert asyncio.run(simulate.run_simulation(words)), f"the rollout {name} failed"
    (log,) = (folder / "rollouts").rglob("rollout.asl")
    data, at, entries = log.read_bytes(), 0, {}
    while at < len(data):
        (length,) = struct.unpack_from(">L", data, at)
        entry = logging_pb2.LogEntry.FromString(data[at + 4:at + 4 + length])
        kind = entry.WhichOneof("log_entry")
        entries.setdefault(kind, []).append(getattr(entry, kind))
        at += 4 + length
    print(name, {kind: len(found) for kind, found in entries.items()})
    return entries


class Driver(egodriver_pb2_grpc.EgodriverServiceServicer):
    """Wants to go beside the recorded path, to its left, ever farther over half a second."""

    def __init__(self, recording, start_us):
        self.pictures, self.plan = {}, Trajectory.from_poses(recording.timestamps_us, [
            recording.get_pose(i) @ Pose(np.array([0, SHIFT_M * np.clip((int(t) - start_us) / 5e5, 0, 1), 0]),
                                         np.array([0.0, 0.0, 0.0, 1.0]))
            for i, t in enumerate(recording.timestamps_us)])

    def get_version(self, request, context):
        return common_pb2.VersionId(version_id="test")

    def start_session(self, request, context):
        self.cameras = {camera.logical_id for camera in request.rollout_spec.vehicle.available_cameras}
        return common_pb2.SessionRequestStatus()

    def submit_image_observation(self, request, context):
        image = request.camera_image
        self.pictures[image.logical_id, image.frame_end_us] = image.image_bytes
        return common_pb2.Empty()

    def nothing(self, request, context):
        return common_pb2.Empty()

    close_session = submit_egomotion_observation = submit_route = submit_recording_ground_truth = nothing

    def drive(self, request, context):
        ahead = self.plan.clip(request.time_now_us, self.plan.time_range_us.stop)
        return egodriver_pb2.DriveResponse(trajectory=trajectory_to_grpc(ahead))


def served(add, servicer):
    """Its server on loopback, and the port of that."""
    service = grpc.server(futures.ThreadPoolExecutor(1))
    add(servicer, service)
    port = service.add_insecure_port("127.0.0.1:0")
    service.start()
    return service, port


def pictures(entries):
    """(camera, frame's end in us): its bytes."""
    images = [image.camera_image for image in entries["driver_camera_image"]]
    return {(image.logical_id, image.frame_end_us): image.image_bytes for image in images}


def decoded(picture):
    return np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).astype(int)


def rendered(camera, end_us, *more):
    """What `simuli render` makes of the camera when the shutter opens that closes then."""
    opens_s = track[0]["time_ns"] * 1e-9 + (end_us - SHUTTER_US - start_us) * 1e-6
    name = f"{camera}_{end_us}{''.join(map(str, more))}"
    shutil.rmtree(work / name, ignore_errors=True)
    run(simuli, "render", "street.scene", "--sensor", camera, "--times", f"{opens_s:.6f}:{opens_s:.6f}:1",
        "--duration", 0, "-o", name, *more)
    (picture,) = (work / name).glob("*.png")
    return np.asarray(Image.open(picture).convert("RGB")).astype(int)


def apart(a, b):
    """Mean difference of two pictures, of 255."""
    return np.abs(a - b).mean()


run(simuli, "synth", "street", "-o", "street.log", "--length", 30, "--cameras", len(CAMERAS), "--frames", 12,
    "--image-width", SIZE[0], "--image-height", SIZE[1], "--lidar-columns", 180)
run(simuli, "train", "street.log", "-o", "street.scene", "--iterations", 30)
run(simuli, "export", "street.scene", "--drive", "-o", "street.usdz")
recorded = json.loads((work / "street.scene/scene.json").read_text())
track = recorded["world_from_rig"]
recording = Artifact(str(work / "street.usdz")).rig.trajectory
start_us = recording.time_range_us.start
closed = {"render_bundling": "BATCH_RENDER_RGB", "force_gt_duration_us": 2 * STEP_US}
driver = Driver(recording, start_us + 3 * STEP_US)
server = subprocess.Popen([simuli, "serve", "street.scene", "--port", "0"], cwd=work, stdout=subprocess.PIPE, text=True)
steering, steering_port = served(egodriver_pb2_grpc.add_EgodriverServiceServicer_to_server, driver)
(work / "controller").mkdir()
wheels, wheels_port = served(add_VDCServiceServicer_to_server,
                             VDCSimService(str(work / "controller"), ControllerConfig()))
try:
    ports = {"renderer": int(server.stdout.readline().rsplit(":", 1)[1])}
    single = rollout("single", ports)
    batch = rollout("batch", ports, {"render_bundling": "BATCH_RENDER_RGB"}, scene_affine_dispatch={"enabled": True})
    jpeg = rollout("jpeg", ports, {"image_format": "jpeg"})
    hidden = rollout("hidden", ports, {"min_traffic_duration_us": 3_000_000})  # its default, and the drive is shorter
    driven = rollout("driven", ports | {"driver": steering_port}, closed)
    seen = dict(driver.pictures)
    controlled = rollout("controlled", ports | {"driver": steering_port, "controller": wheels_port}, closed)
finally:
    steering.stop(None)
    wheels.stop(None)
    server.terminate()
    assert server.wait(timeout=60) == 0, server.returncode

(metadata,) = single["rollout_metadata"]
assert metadata.version_ids.sensorsim_version.version_id and metadata.session_metadata.scene_id == "street"
assert metadata.session_metadata.start_timestamp_us == start_us
steps = metadata.session_metadata.n_sim_steps
shown = pictures(single)
ends = sorted({end for _, end in shown})
assert steps >= 10 and len(ends) == steps + 1 and (np.diff(ends) == STEP_US).all()
assert set(shown) == {(name, end) for name in CAMERAS for end in ends}, "not all cameras at all times"
assert len(single["render_request"]) == len(shown) and len(batch["batch_render_request"]) == len(ends)
assert shown == pictures(batch), "a batch's pictures are others than single ones"
assert set(pictures(jpeg)) == set(shown) and all(p.startswith(b"\xff\xd8") for p in pictures(jpeg).values())
names = {actor["name"] for actor in recorded["actors"]}
assert {actor.track_id for request in single["render_request"] for actor in request.dynamic_objects} == names

# The rig is where it was recorded, and so are the actors; who is there too briefly for AlpaSim is out of sight.
gone = [word for name in sorted(names) for word in ("--remove", name)]
for end in (ends[0], ends[len(ends) // 2], ends[-1]):
    for camera in CAMERAS:
        picture, same = decoded(shown[camera, end]), rendered(camera, end)
        Image.fromarray(np.hstack([picture, same]).astype(np.uint8)).save(work / f"{camera}_{end}.png")
        without = rendered(camera, end, *gone) if camera == "front" else None
        coded = apart(decoded(pictures(jpeg)[camera, end]), picture)
        print(f"{camera}, {end} us: {apart(picture, same):.3f} of 255 from `simuli render`, as JPEG {coded:.3f}")
        assert picture.shape == (SIZE[1], SIZE[0], 3) and apart(picture, same) < NEAR and coded < NEAR + 3
        if camera == "front":
            empty = decoded(pictures(hidden)[camera, end])
            print(f"  its actors are {apart(same, without):.3f} of it; without them {apart(empty, without):.3f} apart")
            assert apart(empty, without) < 0.1 < apart(same, without) > 3 * apart(picture, same)

# The driver saw what is in the log, and leads the rig beside the recorded path.
assert driver.cameras == set(CAMERAS) and seen == pictures(driven)
last = ends[-1]
same, beside = rendered("front", last), rendered("front", last, "--lane-shift", SHIFT_M)
picture = decoded(seen["front", last])
Image.fromarray(np.hstack([picture, beside, same]).astype(np.uint8)).save(work / "driven.png")
print(f"driven: {apart(picture, beside):.3f} of 255 from `simuli render --lane-shift`, {apart(picture, same):.3f} from "
      "the recorded path")
assert apart(picture, beside) < NEAR and apart(picture, same) > 3 * apart(picture, beside)

# Its controller has inertia: the rig leaves the recorded path later and less far, and the pictures go with it.
sides = {}
for name, entries in (("recorded", single), ("driven", driven), ("controlled", controlled)):
    (request,) = [one for one in entries.get("render_request", []) + [item.request for bundle in entries.get(
        "batch_render_request", []) for item in bundle.items]
        if one.camera_intrinsics.logical_id == "front" and one.frame_end_us == last]
    sides[name] = request.sensor_pose.end_pose.vec.y
print("y of the front camera at the end:", {name: round(y, 3) for name, y in sides.items()})
assert abs(sides["driven"] - sides["recorded"] - SHIFT_M) < 0.05, sides
assert sides["recorded"] + 0.1 < sides["controlled"] < sides["driven"] + 0.5, sides
assert apart(decoded(pictures(controlled)["front", last]), same) > 3 * apart(picture, beside)
print(f"AlpaSim's rollouts: {steps} steps, {len(shown)} pictures each, ok")
