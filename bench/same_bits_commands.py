"""Commands of same_bits.py, and their inputs that no command generates.

all_commands() maps a name to (steps, name of a command with the same expected files). A step is a function of the run
(its folder and its program), or a list of program arguments: {NAME} is replaced by the folder of another command,
"> FILE" stores the standard output. Commands on recorded data are named data/..., those of known defects repaired/...
"""
import json
import math
import os
import pathlib
import struct
import time
import urllib.error
import urllib.request

DATA = os.environ.get("SIMULI_DATA")
LONGEST_S = 900  # maximum time of a command


def write_json(file, value):
    file.write_text(json.dumps(value))


def write_lidars(run):
    """Writes a beam table with values other than all built-in tables, and a ray list."""
    rows = json.loads(run.program("info", "hesai_xt16", "--json"))
    del rows["modes"]
    rows.update(name="changed", columns=700, spin="counter_clockwise", azimuth_first_rad=-3.0, beam_divergence_rad=0.003)
    for i, row in enumerate(rows["rows"]):
        row.update(vertical_offset_m=0.002 * i, horizontal_offset_m=0.03, radial_offset_m=0.04, time_offset_s=1e-6 * i,
                   range_bias_m=0.001 * i, azimuth_offset_rad=0.01 * (i % 3))
    write_json(run.folder / "rows.json", rows)
    n = 4000
    rays = {"kind": "ray_list", "name": "rosette", "range_min_m": 0.5, "range_max_m": 100, "beam_divergence_rad": 0.001,
            "divergence_variance": 0.25, "azimuth_rad": [(i * 37 % n) / n - 0.5 for i in range(n)],
            "elevation_rad": [(i * 101 % n) / n * 0.6 - 0.4 for i in range(n)], "time_fraction": [i / n for i in range(n)]}
    write_json(run.folder / "rays.json", rays)
    rays["origin_m"] = [value for i in range(n) for value in (0.1 * (i % 2), -0.05, 0.02)]
    write_json(run.folder / "origins.json", rays)


def add_cameras(run):
    """Adds cameras with each lens that no built-in camera uses, and each shutter."""
    run.copy("train/default", "out.scene")
    file = run.folder / "out.scene" / "scene.json"
    scene = json.loads(file.read_text())
    front = scene["cameras"][0]
    ftheta = {"c": 1.01, "d": 0.002, "e": -0.001, "max_angle_rad": 1.0}
    lenses = {
        "mei": {"k1": -0.18, "k2": 0.02, "p1": 1e-3, "p2": -1e-3, "xi": 1.4, "max_angle_rad": 1.5},
        "opencv_pinhole": dict({f"k{i}": 0.0 for i in range(1, 7)}, k1=-0.3, k2=0.1, p1=1e-3, p2=1e-3, s1=1e-3, s2=0.0,
                               s3=1e-3, s4=0.0, max_angle_rad=1.0),
        "ftheta_radius_to_angle": dict({f"b{i}": 0.0 for i in range(2, 6)}, b1=1.0, b3=0.02, **ftheta),
        "equirectangular": {}}
    for name, parameters in lenses.items():
        camera = dict(front, name=name, model=name, shutter="global", **parameters)
        if name == "mei":
            camera.update(fx_px=200.0, fy_px=200.0)
        if name == "equirectangular":
            camera.update(width_px=180, height_px=90, fx_px=90 / math.pi, fy_px=90 / math.pi, cx_px=90.0, cy_px=45.0)
        scene["cameras"].append(camera)
    for shutter in SHUTTERS:
        scene["cameras"].append(dict(front, name=shutter, shutter=shutter))
    write_json(file, scene)


def write_points(run):
    """Writes a drive as lists of points: a LiDAR moves between two synthetic walls."""
    (run.folder / "points").mkdir()
    at = {"rotation_wxyz": [1.0, 0.0, 0.0, 0.0]}
    sweeps = []
    for s in range(3):
        floats = []
        for i in range(16 * 500):
            elevation, azimuth = math.radians(15 - 2 * (i % 16)), 2 * math.pi * (i // 16) / 500
            distance = 8 + 4 * math.sin(3 * azimuth) + s
            floats += [distance * math.cos(elevation) * math.cos(azimuth), distance * math.cos(elevation) * math.sin(azimuth),
                       distance * math.sin(elevation), (i % 100) / 100]
        (run.folder / "points" / f"{s}.bin").write_bytes(struct.pack(f"<{len(floats)}f", *floats))
        sweeps.append({"lidar": "top", "file": f"points/{s}.bin", "time_start_ns": s * 10**8, "time_end_ns": (s + 1) * 10**8})
    write_json(run.folder / "points.json", {
        "format": "simuli points", "version": 1, "name": "walls", "start_ns": 0, "cameras": [], "images": [], "actors": [],
        "point_columns": ["x_m", "y_m", "z_m", "intensity"], "points_in": "sensor", "sweeps": sweeps,
        "lidars": [{"table": "hesai_xt16", "name": "top", "rig_from_lidar": dict(at, position_m=[0.0, 0.0, 2.0])}],
        "world_from_rig": [dict(at, time_ns=i * 10**8, position_m=[0.5 * i, 0.0, 0.0]) for i in range(4)]})


def cut_drive(run):
    """Copies the first frames of drive 0013."""
    frames, source = 30, pathlib.Path(DATA) / "kitti/2011_09_26"
    for file in source.rglob("*"):
        to = run.folder / "2011_09_26" / file.relative_to(source)
        if not file.is_file() or (file.stem.isdigit() and int(file.stem) >= frames):
            continue
        to.parent.mkdir(parents=True, exist_ok=True)
        if file.name.startswith("timestamps"):
            to.write_text("".join(file.read_text().splitlines(True)[:frames]))
        else:
            to.symlink_to(file.resolve())
    poses = json.loads((source.parent / "poses_0013.json").read_text())
    write_json(run.folder / "poses.json", dict(poses, frames=poses["frames"][:frames]))
    labels = (source.parent / "tracking_label_02_0003.txt").read_text().splitlines(True)
    (run.folder / "labels.txt").write_text("".join(line for line in labels if int(line.split()[0]) < frames))


def kill_at_checkpoint(run):
    """Starts the training and kills it after its first checkpoint."""
    with run.start(f"train {{street}}/out.log -o out.scene {CHECKPOINTS}") as training:
        while not (run.folder / "out.scene.checkpoint").exists():
            if training.poll() is not None:
                raise RuntimeError("the training ended before it could be killed")
            time.sleep(0.002)
        training.kill()
    if (run.folder / "out.scene").exists():
        raise RuntimeError("the training ended before it could be killed")


def ask_viewer(run):
    """Requests pictures and sweeps as the browser does."""
    ask = {"sensor": "front", "quality": "balanced", "time_s": 0.4, "width": 160, "forward_m": 0.5, "left_m": 0.3, "up_m": 0.1,
           "yaw_rad": 0.1, "pitch_rad": 0.05, "removed": [], "moved": {}}
    free = {"t": [0.0, 0.0, 8.0], "q": [0.0, 1.0, 0.0, 0.0]}
    asked = {"front": {}, "draft": {"quality": "draft"}, "removed": {"removed": ["car"]},
             "moved": {"moved": {"car": [1, 2, 0]}}, "free": {"scene_from_camera": free}, "other": {"sensor": "tum_vi_cam0"},
             "top": {"sensor": "top"}, "vlp16": {"sensor": "velodyne_vlp16"}}
    with run.start("view {train/default}/out.scene --port 0") as viewer:
        try:
            url = viewer.stdout.readline().decode().strip()
            for name, change in asked.items():
                is_sweep = name in ("top", "vlp16")
                body = json.dumps({**ask, **change})
                place = url + ("api/sweep" if is_sweep else "api/picture")
                try:
                    reply = urllib.request.urlopen(place, body.encode(), LONGEST_S).read()
                except urllib.error.HTTPError:  # the key's name in programs before sensor_rig.hpp
                    body = body.replace("scene_from_camera", "world_from_camera")
                    reply = urllib.request.urlopen(place, body.encode(), LONGEST_S).read()
                payload = 4 + (struct.unpack("<I", reply[:4])[0] + 3) // 4 * 4  # after the times
                (run.folder / (name + (".points" if is_sweep else ".jpg"))).write_bytes(reply[payload:])
        finally:
            viewer.kill()


def name_machine(run):
    device = json.loads(run.program("devices", "--json"))[0]
    keys = ("platform", "name", "device_version", "driver_version")
    write_json(run.folder / "machine.json", {key: device[key] for key in keys})


def describe_sensors(run):
    for line in run.program("info", "sensors").decode().splitlines():
        name = line.split()[1]
        (run.folder / f"{name}.json").write_bytes(run.program("info", name, "--json"))


SHUTTERS = ("top_to_bottom", "bottom_to_top", "left_to_right", "right_to_left")
SMALL = "--frames 10 --image-width 160 --image-height 90 --lidar-columns 400"
CHECKPOINTS = "--iterations 45 --checkpoint-every 5 --set densify.epochs=1.25 anchor.weight=0.01"
TIMES = "--times 0.3:0.4:0.1"
TRAININGS = {
    "half_size": "--scale 0.5 --held-out 3 --seed 7",
    "no_held_out": "--held-out 0 --seed 2",
    "draft": "--quality draft",
    "exact": "--quality exact",
    "color_grids": "--set color_grids=pictures",
    "environment": "--set init.environment_width=64",
    "densify": "--set densify.epochs=0.75",
    "densify_full": "--set densify.epochs=0.75 densify.cap=68000",
    "anchors": "--set anchor.weight=0.01",
    "actor_rates": "--set actors.track.learn=true",
    "no_actors": "--set init.actors=false",
    "actor_init": "--set actors.least_travel_m=0.5",
    "believed_tracks": "--set init.register_tracks=false",
    "init_sizes": "--set init.voxel_m=0.2",
    "init_caps": "--set init.max_camera=5000 init.max_lidar=8000",
    "init_off": "--set init.sweep_depth=false sensors.learn=false init.dark_surfaces=false",
    "sh_none": "--set init.camera_sh_degree=0",
    "sh_most": "--set init.camera_sh_degree=3",
    "losses": "--set loss.ssim=0.5 loss.drop=0.1",
    "no_ssim": "--set loss.ssim=0",
    "lidar_each": "--set lidar_every=1 cache_bytes=300000",
    "linearized": "--set render.projection=linearized render.extent=unscented",
    "unscented_extent": "--set render.extent=unscented render.shutter_iterations=3",
    "compensation": "--set render.camera_compensation=true render.lidar_compensation=true",
    "cuts": "--set render.alpha_cut=0.01 render.transmittance_cut=0.01 render.camera_filter_px2=0.1",
    "everything": "--set color_grids=pictures init.environment_width=64 densify.epochs=0.75 anchor.weight=0.01 "
                  "lidar_every=1 actors.track.learn=true",
}
OPTIONS = {
    "draft": "--quality draft", "balanced": "--quality balanced", "exact": "--quality exact",
    "reference": "--quality reference --scale 0.6",
    "linearized": "--set render.projection=linearized render.extent=unscented",
    "monte_carlo": "--set render.projection=monte_carlo render.extent=unscented",
    "unscented_extent": "--set render.extent=unscented", "per_ray": "--set render.order=per_ray",
    "window": "--set render.order=window", "window_8": "--set render.order=window render.window=8",
    "sh_along_rays": "--set render.sh_direction=ray", "sh_0": "--set render.sh_degree=0", "sh_1": "--set render.sh_degree=1",
    "sh_half": "--set render.sh_storage=half",
    "double": "--set render.precision=double --scale 0.6",
    "shutter": "--set render.shutter_iterations=4 --duration 0.04",
    "cuts": "--set render.alpha_cut=0.02 render.transmittance_cut=0.01 render.camera_filter_px2=0.1",
    "compensation": "--set render.camera_compensation=true render.lidar_compensation=true",
    "no_culling": "--set render.culling=off",
}
CAMERAS = {
    "dgp_scene01_CAMERA_05": "--scale 0.15", "pandaset_front_camera": "--scale 0.15 --duration 0.03",
    "pandaset_left_camera": "--scale 0.15 --duration 0", "tum_vi_cam0": "--scale 0.5",
    "basalt_euroc_ds_calib_cam0": "--scale 0.4", "basalt_euroc_eucm_calib_cam0": "--scale 0.4", "gsplat_camera_front_wide_120fov": "--scale 0.08 --duration 0.03",
    "gsplat_camera_rear_left_70fov": "--scale 0.08 --duration 0.03",
    "gsplat_camera_front_fisheye_140fov": "--scale 0.08 --duration 0.03",
}
LIDARS = ("hesai_pandar64", "hesai_pandar128", "hesai_xt32", "velodyne_vlp16", "velodyne_hdl64e_s2_sztaki", "velodyne_vls128",
          "kitti_hdl64e", "ouster_os1_128", "ouster_os1_128@2048x10", "robosense_bpearl", "robosense_ruby_lite80",
          "ncore_hesai_at128", "ncore_waymo_top", "nuscenes_lidar_top_hdl32e", "gsplat_generic128", "generic64")
EDITS = {
    "remove": "--remove car", "move": "--move car:1,2,0.1", "duplicate": "--duplicate car:twin --move twin:-2,-3.2,0",
    "retime": "--retime car:0.5:0.2",
    "add": "--add {train/actor_init}/out.scene:car:guest --track guest:{street/long}/out.log:car",
    "all": "--duplicate car:twin --retime twin:1.5:-0.1 --move twin:-3,-3,0 --remove car",
    "lane_shift": "--lane-shift 1.5", "speed": "--speed 1.7", "shift_and_speed": "--lane-shift -1 --speed 0.5",
}


def all_commands():
    found = {}

    def add(name, *steps, same_as=None):
        found[name] = (steps, same_as)

    def render(name, sensor, options, scene="{train/default}/out.scene", times=TIMES, images="--images exr"):
        add(name, f"render {scene} --sensor {sensor} {times} {images} {options} -o out")

    add("machine", name_machine)
    add("street", f"synth street -o out.log {SMALL}")
    add("street/long", "synth street -o out.log --frames 14 --seed 3 --speed 5 --image-width 96 --image-height 54 "
                       "--lidar-columns 200")
    add("street/rolling", f"synth street -o out.log {SMALL} --rolling-shutter --no-moving-car --seed 2")
    add("train/default", "train {street}/out.log -o out.scene --iterations 60 --scale 1 --json > train.json")
    for name, options in TRAININGS.items():
        size = "" if "--scale" in options else "--scale 1"
        add(f"train/{name}", f"train {{street}}/out.log -o out.scene --iterations 30 {size} {options} --json > train.json")
    add("train/rolling", "train {street/rolling}/out.log -o out.scene --iterations 30 --scale 1")
    add("train/report", "train {street}/out.log -o out.scene --iterations 20 --report report.html")
    add("train/whole", f"train {{street}}/out.log -o out.scene {CHECKPOINTS}")
    add("train/killed_and_resumed", kill_at_checkpoint, f"train {{street}}/out.log -o out.scene {CHECKPOINTS} --resume",
        same_as="train/whole")

    for name, options in OPTIONS.items():
        render(f"camera/{name}", "front", options)
        render(f"lidar/{name}", "top", options)
    for name, options in CAMERAS.items():
        render(f"cameras/{name}", name, options)
    add("cameras/scene", add_cameras)
    for name in ("mei", "opencv_pinhole", "ftheta_radius_to_angle", "equirectangular"):
        render(f"cameras/{name}", name, "", scene="{cameras/scene}/out.scene")
    for name in SHUTTERS:
        render(f"cameras/{name}", name, "--duration 0.05", scene="{cameras/scene}/out.scene")
        render(f"cameras/exact/{name}", name, "--duration 0.05 --quality exact", scene="{cameras/scene}/out.scene")
    render("cameras/rolling", "front", "--duration 0.02", scene="{train/rolling}/out.scene")
    for name in LIDARS:
        render(f"lidars/{name}", name, "", times="--times 0.3:0.3:1")
    for name in ("hesai_xt32@20", "ouster_os1_128@512x20"):
        render(f"repaired/{name}", name, "", times="--times 0.3:0.3:1")  # a revolution takes 0.05 s, not 0.1 s
    add("lidars/files", write_lidars)
    for name in ("rows", "rays", "origins"):
        render(f"lidars/{name}", f"{{lidars/files}}/{name}.json", "")
        render(f"lidars/exact/{name}", f"{{lidars/files}}/{name}.json", "--quality exact")
    render("lidars/at_rest", "velodyne_vlp16", "--duration 0")
    render("lidars/slow", "velodyne_vlp16", "--duration 0.2")
    for name, options in EDITS.items():
        render(f"edits/camera/{name}", "front", options)
        render(f"edits/lidar/{name}", "top", options)
    render("path/frames", "front", "", times="--frames 2:4")
    render("path/log", "front", "--trajectory {street/long}/out.log", times="--frames 2:3")
    render("path/log_lidar", "top", "--trajectory {street/long}/out.log", times="--frames 2:3")
    render("files/png", "front", "", images="")
    render("files/pcd", "top", "--clouds pcd")
    render("files/npz", "top", "--clouds npz")
    for name in ("environment", "color_grids", "everything", "sh_most"):
        render(f"scenes/{name}/camera", "front", "", scene=f"{{train/{name}}}/out.scene")
        render(f"scenes/{name}/lidar", "top", "", scene=f"{{train/{name}}}/out.scene")
    add("view", ask_viewer)

    def evaluate(name, options, train="default", log="street"):
        add(f"eval/{name}", f"eval {{train/{train}}}/out.scene {{{log}}}/out.log --json --repeats 1 {options} > eval.json")

    evaluate("default", "")
    evaluate("report", "--report report.html")
    evaluate("exact", "--quality exact")
    evaluate("half_size", "--scale 0.5 --held-out 3", train="half_size")
    evaluate("edited", "--remove car")
    evaluate("moved", "--move car:0,1,0")
    evaluate("color_grids", "", train="color_grids")
    evaluate("environment", "", train="environment")
    evaluate("everything", "--set render.order=per_ray", train="everything")
    evaluate("rolling", "", train="rolling", log="street/rolling")
    add("demo", "demo -o out --iterations 20 --json > eval.json")
    add("agreement", "bench --agreement every_ray")

    add("align/path", "align {street}/out.log -o out.log --json > align.json")
    add("align/prior", "align {street}/out.log --prior --prior-position 0.05 -o out.log --json > align.json")
    add("align/camera", "synth street -o large.log --frames 12 --image-width 320 --image-height 180 --speed 5 --seed 3",
        "align large.log --keep-path --camera front --apply-cameras -o out.log --json > align.json")
    for name in ("opencv_fisheye", "ftheta_angle_to_radius", "ftheta_radius_to_angle", "mei", "double_sphere", "eucm"):
        add(f"fit/{name}", f"fit lens tum_vi_cam0 --model {name} -o lens.json --json > fit.json")
    add("export", "export {train/default}/out.scene -o camera.ply", "export {train/default}/out.scene -o camera.spz",
        "export {train/default}/out.scene --lidar -o lidar.ply", "export camera.spz -o back.ply")
    add("info", describe_sensors, "info sensors > sensors.txt", "info {street}/out.log --json > log.json",
        "info {train/default}/out.scene --json > scene.json")
    add("import/points", write_points, "import points . -o out.log")

    data = DATA or "SIMULI_DATA"
    drive = "{data/drive}/2011_09_26/2011_09_26_drive_0013_sync"
    add("data/drive", cut_drive)
    add("data/kitti", f"import kitti {drive} --poses {{data/drive}}/poses.json --tracking {{data/drive}}/labels.txt -o out.log")
    add("data/kitti_oxts", f"import kitti {drive} -o out.log")
    add("data/kitti_raw", f"fit beams {drive}/velodyne_points/data --spin-hz 9.66 --sweeps 6 -o beams.json",
        f"import kitti {drive} --no-poses --beams beams.json -o out.log")
    add("data/kitti_path", "align {data/kitti}/out.log -o out.log --json > align.json")
    add("data/kitti_camera", "align {data/kitti}/out.log --keep-path --camera image_02 --json > align.json")
    add("data/train", "train {data/kitti}/out.log -o out.scene --iterations 20 --scale 0.3 --set init.voxel_m=0.2 --json "
                      "> train.json")
    add("data/eval", "eval {data/train}/out.scene {data/kitti}/out.log --scale 0.3 --repeats 1 --json > eval.json")
    render("data/camera", "image_02", "--scale 0.3", scene="{data/train}/out.scene", times="--frames 3:3")
    render("data/lidar", "velodyne", "", scene="{data/train}/out.scene", times="--frames 3:3")
    add("data/fox", f"import nerfstudio {data}/posed_images/fox -o out.log",
        "train out.log -o out.scene --iterations 20 --scale 0.1 --json > train.json")
    for name in ("biker.compressed.ply", "biker.spz"):
        add(f"data/{name}", f"export {data}/splats/playcanvas/{name} -o out.ply")
    return found
