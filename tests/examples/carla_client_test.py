"""CARLA's NuRec client as it is, on an exported drive and `simuli serve`: carla_client_test.py SIMULI EXAMPLES WORK

SIMULI_CARLA_NUREC names its folder, PythonAPI/examples/nvidia/nurec of carla-simulator/carla. In the place of CARLA
itself stands a world without physics, and in that of the container that the client would start, the server here.
"""
import json
import os
import pathlib
import subprocess
import sys
import types
import xml.etree.ElementTree

import numpy as np
from PIL import Image

simuli, work = sys.argv[1], pathlib.Path(sys.argv[3])
nurec = pathlib.Path(os.environ.get("SIMULI_CARLA_NUREC", "/nonexistent"))
if not (nurec / "nurec_integration.py").is_file():
    print("SKIPPED: carla_client_test.py, SIMULI_CARLA_NUREC names no folder with CARLA's nurec_integration.py")
    sys.exit()
sys.dont_write_bytecode = True
sys.path[:0] = [str(pathlib.Path(__file__).parent / "carla_stand_ins"), str(nurec)]
if not (nurec / "simple_trajectory_follower.py").is_file():  # a replay imports it, and does not use it
    sys.modules["simple_trajectory_follower"] = types.SimpleNamespace(SimpleTrajectoryFollower=object)
import carla  # noqa: E402

carla.Client.get_server_version = lambda self: None  # else the client keeps the sizes of blueprints in its own folder
import nurec_integration  # noqa: E402
from nre.grpc.protos import common_pb2, sensorsim_pb2  # noqa: E402
from scenario import Scenario  # noqa: E402
from utils import mat_to_carla_transform, undo_carla_coordinate_transform  # noqa: E402

NEAR = 1.5  # of 255: poses have single precision on the wire


def run(*words):
    subprocess.run([str(w) for w in words], cwd=work, check=True, stdout=subprocess.DEVNULL)


def rendered(time_s, name, *more):
    """What `simuli render` makes of the front camera then."""
    run(simuli, "render", "street.scene", "--sensor", "front", "--times", f"{time_s:.6f}:{time_s:.6f}:1", "--duration", 0,
        "-o", name, *more)
    (picture,) = (work / name).glob("*.png")
    return np.asarray(Image.open(picture).convert("RGB")).astype(int)


def apart(a, b):
    """Mean difference of two pictures, of 255."""
    return np.abs(a.astype(int) - b.astype(int)).mean()


def pitched_ones_come_back():
    pose = np.eye(4)
    pose[:3, :3] = [[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]] @ np.array(
        [[0.96, 0.0, 0.28], [0.0, 1.0, 0.0], [-0.28, 0.0, 0.96]])
    pose[:3, 3] = 1, 2, 3
    back = undo_carla_coordinate_transform(np.array(mat_to_carla_transform(pose).get_matrix()))
    return np.allclose(back, pose, atol=1e-9)


if not pitched_ones_come_back():
    carla.Transform.sign = -1.0
assert pitched_ones_come_back(), "the client's poses don't come back from the stand-in's transforms"

run(simuli, "synth", "street", "-o", "street.log", "--frames", 8, "--image-width", 96, "--image-height", 54,
    "--lidar-columns", 180)
run(simuli, "train", "street.log", "-o", "street.scene", "--iterations", 30)
run(simuli, "export", "street.scene", "--drive", "-o", "street.usdz")
server = subprocess.Popen([simuli, "serve", "street.scene", "--port", "0", "--enable-editing-actors"], cwd=work,
                          stdout=subprocess.PIPE, text=True)
try:
    port = int(server.stdout.readline().rsplit(":", 1)[1])
    recorded = json.loads((work / "street.scene/scene.json").read_text())

    scenario = Scenario(str(work / "street.usdz"))
    renderer = nurec_integration.NurecRenderer(scenario, "localhost", port)
    assert set(renderer.available_cameras) == set(scenario.camera_calibrations) == {"front"}
    mounted = np.array(scenario.camera_calibrations["front"].T_sensor_rig)
    first = scenario.ego_poses.poses[0]
    nobody = nurec_integration.MockWorldSnapshot()
    start_s = recorded["world_from_rig"][0]["time_ns"] * 1e-9
    picture = renderer.render(nobody, renderer.get_camera_spec("front"), first @ mounted, 1.0)
    empty = rendered(start_s, "empty", *(word for actor in recorded["actors"] for word in ("--remove", actor["name"])))
    print(f"a picture without actors: {apart(picture, empty):.3f} of 255 from that of `simuli render`")
    assert apart(picture, empty) < NEAR
    requests = [(name, renderer.build_request(nobody, renderer.get_camera_spec("front"), first @ mounted, 0.25))
                for name in ("a", "b")]
    batch = renderer.render_batch(requests)
    assert set(batch) == {"a", "b"} and batch["a"].shape == (13, 24, 3) and np.array_equal(batch["a"], batch["b"])
    points, intensities = renderer.render_lidar(nobody, first)
    assert len(points) == len(intensities) > 1000 and np.isfinite(points).all()
    assert renderer.get_external_asset_objects() == []
    tracks = {track.id: track for track in renderer.get_dynamic_objects()}
    assert set(tracks) == {actor["name"] for actor in recorded["actors"]} == scenario.controllable_tracks
    for track in scenario.tracks.track_data:
        served = tracks[track.track_id].trajectory.poses
        assert [p.timestamp_us for p in served] == list(track.timestamps)
        assert np.allclose([[p.pose.vec.x, p.pose.vec.y, p.pose.vec.z] for p in served],
                           [pose[:3, 3] for pose in track.poses], atol=1e-3)

    # The road, as the client turns it: where the rig drove, in CARLA's axes.
    client = carla.Client()
    times, pictures, sweeps = [], [], []
    with nurec_integration.NurecScenario(client, str(work / "street.usdz"), port) as replay:
        assert np.array_equal(replay.t_scenario_carla, np.eye(4))
        road = xml.etree.ElementTree.fromstring(client.world.opendrive).find("road")
        assert len(road.findall("planView/geometry")) > 0
        replay.add_camera("front", lambda image: (times.append(replay.get_sim_time()), pictures.append(image)), framerate=20)
        replay.add_lidar(lambda points, intensities: sweeps.append(points))
        replay.start_replay()
        for _ in range(200):
            replay.tick()
            if replay.is_done():
                break
        assert replay.is_done()
        ego = replay.actor_mapping["ego"].actor_inst.pending
        last = recorded["world_from_rig"][-1]["position_m"]
        where = np.array([ego.location.x, -ego.location.y, ego.location.z]) + recorded["origin_m"]
        assert np.abs(where - last).max() < 1e-3, (where, last)
    assert len(pictures) >= 5 and len(sweeps) >= 2 and all(len(points) > 1000 for points in sweeps)
    names = {track_id for track_id in tracks}
    zero_us, zero_s = scenario.tracks.zero_time, start_s
    for i in (0, len(pictures) // 2, len(pictures) - 1):
        time_s = zero_s + (times[i] - zero_us) * 1e-6
        same = rendered(time_s, f"at_{i}")
        without = rendered(time_s, f"without_{i}", *(word for name in names for word in ("--remove", name)))
        print(f"{time_s:.3f} s: {apart(pictures[i], same):.3f} of 255 from that of `simuli render`, "
              f"{apart(same, without):.3f} of them its actors")
        assert apart(pictures[i], same) < NEAR and apart(same, without) > 2 * apart(pictures[i], same)
        Image.fromarray(pictures[i]).save(work / f"client_{i}.png")

    # A second car, and a car in the place of the person, if there is one.
    car = next(t for t in tracks.values() if t.semantic_class == "car")
    more = sensorsim_pb2.DynamicObjectTrack(id="another", asset_id=car.id, semantic_class="car",
                                            trajectory=car.trajectory, object_size=car.object_size)
    renderer.edit_assets(insert=[more])
    assert renderer.get_external_asset_objects() == ["another"]
    try:
        renderer.edit_assets(replace=[sensorsim_pb2.ReplaceAssetAction(original_id="nobody", replacement_id=car.id)])
        raise AssertionError("who is not there was replaced")
    except RuntimeError as error:
        assert "nobody" in str(error), error
    assert renderer.client_service.get_version(common_pb2.Empty()).version_id
finally:
    server.terminate()
    assert server.wait(timeout=60) == 0, server.returncode
print("CARLA's client: ok")
