"""A car that drives through a scene by itself: closed_loop.py HOST:PORT -o FOLDER|VIDEO.mp4 [options]

Asks `simuli serve` (or any other server of the service `sensorsim`) for what the front camera and a LiDAR see from a car
that follows the recorded path to the left or right of it (pure pursuit), and that brakes for what its LiDAR has ahead:
one of the scene's actors, put into its way. Where the car is, and so what is rendered, follows from what it saw before.
Needs grpcio, grpcio-tools, numpy; for a video ffmpeg.
"""
import argparse
import math
import pathlib
import shutil
import subprocess
import sys
import time

import grpc
import numpy as np

PROTOS = pathlib.Path(__file__).resolve().parent.parent / "host/apps/serve/proto"
WHEELBASE_M, FRONT_M, GAP_M = 2.8, 3.6, 1.5  # rear axle to front axle, to bumper; what is kept free
FULL_BRAKE, COMFORT = 6.0, 1.5  # m/s2
SPECKS = 4  # returns that are nothing to brake for


def rotation(q):
    """3 x 3 of a quaternion (w, x, y, z)."""
    w, x, y, z = np.asarray(q) / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
                     [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
                     [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)]])


def product(p, q):
    """p q of quaternions."""
    a, b, c, d = p
    w, x, y, z = q
    return np.array([a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y,
                     a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w])


def place_of(message):
    """(position, quaternion) of a pose."""
    v, q = message.vec, message.quat
    return np.array([v.x, v.y, v.z], float), np.array([q.w, q.x, q.y, q.z], float)


def behind(first, second):
    """Where `second`, told in the frame of `first`, is."""
    return first[0] + rotation(first[1]) @ second[0], product(first[1], second[1])


def tell(message, place):
    """Writes a pose."""
    message.vec.x, message.vec.y, message.vec.z = map(float, place[0])
    message.quat.w, message.quat.x, message.quat.y, message.quat.z = map(float, place[1] / np.linalg.norm(place[1]))


def standing(x, y, z, yaw):
    return np.array([x, y, z]), np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)])


def yaw_of(q):
    return math.atan2(*(rotation(q)[k, 0] for k in (1, 0)))


class Path:
    """The recorded one, moved to the left."""

    def __init__(self, trajectory, left_m):
        self.times_us = np.array([p.timestamp_us for p in trajectory.poses], np.int64)
        places = [place_of(p.pose) for p in trajectory.poses]
        self.yaws = np.unwrap([yaw_of(q) for _, q in places])
        self.recorded = np.array([v for v, _ in places])
        self.points = self.recorded.copy()
        self.points[:, 0] -= left_m * np.sin(self.yaws)
        self.points[:, 1] += left_m * np.cos(self.yaws)
        steps = np.linalg.norm(np.diff(self.points[:, :2], axis=0), axis=1)
        self.along = np.concatenate([[0.0], np.cumsum(steps)])
        seconds = np.diff(self.times_us) * 1e-6
        self.speeds = np.concatenate([steps / seconds, [steps[-1] / seconds[-1]]])

    def nearest(self, x, y):
        """How far along the path that is, m."""
        start, step = self.points[:-1, :2], np.diff(self.points[:, :2], axis=0)
        share = np.einsum("ij,ij->i", np.array([x, y]) - start, step) / np.maximum(np.sum(step * step, axis=1), 1e-12)
        share = np.clip(share, 0.0, 1.0)
        i = int(np.argmin(np.linalg.norm(start + share[:, None] * step - [x, y], axis=1)))
        return float(self.along[i] + share[i] * (self.along[i + 1] - self.along[i]))

    def at(self, along_m):
        """(x, y, z, yaw, speed) there."""
        columns = (*self.points.T, self.yaws, self.speeds)
        return tuple(float(np.interp(along_m, self.along, c)) for c in columns)


class Car:
    """A bicycle: rear axle, heading, speed."""

    def __init__(self, path):
        self.x, self.y, self.z = path.recorded[0]  # it goes over to its own lane from there
        self.yaw, self.speed = path.yaws[0], path.speeds[0]

    def place(self):
        return standing(self.x, self.y, self.z, self.yaw)

    def drive(self, path, ahead_m, seconds):
        """One step; ahead_m: how far before the rear axle the next thing is."""
        along = path.nearest(self.x, self.y)
        wanted = path.at(along)[4]
        acceleration = float(np.clip((wanted - self.speed) / 1.0, -COMFORT, COMFORT))
        needed = self.speed**2 / (2 * max(ahead_m - FRONT_M - GAP_M, 0.1))
        if needed > COMFORT:
            acceleration = -min(needed, FULL_BRAKE)
        look = max(4.0, 0.8 * self.speed)
        tx, ty, *_ = path.at(along + look)
        bearing = math.atan2(ty - self.y, tx - self.x) - self.yaw
        curvature = 2.0 * math.sin(bearing) / max(math.hypot(tx - self.x, ty - self.y), 1.0)
        curvature = float(np.clip(curvature, -math.tan(0.6) / WHEELBASE_M, math.tan(0.6) / WHEELBASE_M))
        before = max(self.speed, 0.0)
        self.speed = max(0.0, before + acceleration * seconds)
        metres = 0.5 * (before + self.speed) * seconds
        self.x += metres * math.cos(self.yaw + 0.5 * curvature * metres)
        self.y += metres * math.sin(self.yaw + 0.5 * curvature * metres)
        self.yaw += curvature * metres
        self.z = path.at(path.nearest(self.x, self.y))[2]


class Client:
    """What the server has, and what it is asked for."""

    def __init__(self, address, protos):
        sys.path.insert(0, str(protos))
        self.messages, services = grpc.protos_and_services("sensorsim.proto")
        options = [("grpc.max_receive_message_length", -1)]
        self.stub = services.SensorsimServiceStub(grpc.insecure_channel(address, options=options))
        self.common = grpc.protos("common.proto")

    def open(self, scene):
        scenes = self.stub.get_available_scenes(self.common.Empty(), wait_for_ready=True, timeout=60).scene_ids
        self.scene = scene or scenes[0]
        if self.scene not in scenes:
            sys.exit(f"closed_loop: scene {self.scene}: the server has {', '.join(scenes)}")
        m = self.messages
        self.cameras = self.stub.get_available_cameras(m.AvailableCamerasRequest(scene_id=self.scene)).available_cameras
        self.trajectory = self.stub.get_available_trajectories(
            m.AvailableTrajectoriesRequest(scene_id=self.scene)).available_trajectories[0].trajectory
        self.actors = self.stub.get_dynamic_objects(m.AvailableDynamicObjectsRequest(scene_id=self.scene)).dynamic_objects

    def recorded_actors(self, time_us):
        """{id: place} of those that the recording has then."""
        there = {}
        for actor in self.actors:
            times = np.array([p.timestamp_us for p in actor.trajectory.poses], np.int64)
            if not times[0] <= time_us <= times[-1]:
                continue
            places = [place_of(p.pose) for p in actor.trajectory.poses]
            i = min(int(np.searchsorted(times, time_us, side="right")) - 1, max(len(times) - 2, 0))
            share = 0.0 if len(times) < 2 else (time_us - times[i]) / (times[i + 1] - times[i])
            (v0, q0), (v1, q1) = places[i], places[min(i + 1, len(times) - 1)]
            q1 = q1 if q0 @ q1 >= 0 else -q1
            there[actor.id] = ((1 - share) * v0 + share * v1, (1 - share) * q0 + share * q1)
        return there

    @staticmethod
    def fill(request, start_us, end_us, sensor, actors):
        """What requests for pictures and sweeps share; sensor and actors: (place at the start, at the end)."""
        request.frame_start_us, request.frame_end_us = start_us, end_us
        tell(request.sensor_pose.start_pose, sensor[0])
        tell(request.sensor_pose.end_pose, sensor[1])
        for name, (start, end) in actors.items():
            actor = request.dynamic_objects.add(track_id=name)
            tell(actor.pose_pair.start_pose, start)
            tell(actor.pose_pair.end_pose, end)
        return request

    def picture(self, camera, *frame):
        m, spec = self.messages, camera.intrinsics
        request = m.RGBRenderRequest(scene_id=self.scene, camera_intrinsics=spec, resolution_h=spec.resolution_h,
                                     resolution_w=spec.resolution_w, image_format=m.PNG)
        return self.stub.render_rgb(self.fill(request, *frame)).image_bytes

    def sweep(self, lidar, *frame):
        """[N][3] in the LiDAR's axes at the frame's end."""
        request = self.fill(self.messages.LidarRenderRequest(scene_id=self.scene), *frame)
        reply = self.stub.render_lidar(request, metadata=[("x-simuli-lidar", lidar)] if lidar else None)
        return np.frombuffer(reply.point_xyzs_buffer, np.float32).reshape(-1, 3)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("address")
    parser.add_argument("-o", "--output", required=True, help="a folder of pictures, or a video.mp4")
    parser.add_argument("--scene", help="default: the server's first")
    parser.add_argument("--camera", help="default: the scene's first")
    parser.add_argument("--lidar", default="", help="of the scene, or built in; default: PANDAR128")
    parser.add_argument("--left", type=float, default=1.0, help="m, of the recorded path")
    parser.add_argument("--obstacle", type=float, default=30.0, help="m along the path, or its end, where an actor is put; 0: nowhere")
    parser.add_argument("--seconds", type=float, default=1e9, help="at most; default: to the path's end")
    parser.add_argument("--rate", type=float, default=10.0, help="pictures per second of the drive")
    parser.add_argument("--protos", default=PROTOS, type=pathlib.Path, help="folder of sensorsim.proto")
    args = parser.parse_args()
    if not (args.protos / "sensorsim.proto").is_file():
        parser.error(f"--protos: found no sensorsim.proto in {args.protos}, allowed host/apps/serve/proto of simuli")

    client = Client(args.address, args.protos)
    client.open(args.scene)
    cameras = {c.logical_id: c for c in client.cameras}
    camera = cameras[args.camera] if args.camera else client.cameras[0]
    rig_from_camera = place_of(camera.rig_to_camera)
    rig_from_lidar = np.array([0.0, 0.0, 1.8]), np.array([1.0, 0.0, 0.0, 0.0])
    path, recorded = Path(client.trajectory, args.left), Path(client.trajectory, 0.0)
    car = Car(path)
    obstacle = client.actors[0].id if client.actors and args.obstacle > 0 else None
    if obstacle:
        x, y, z, yaw, _ = path.at(args.obstacle)
        blocked = standing(x, y, z + client.actors[0].object_size.size_z / 2, yaw)

    is_video = args.output.endswith(".mp4")
    if is_video and not shutil.which("ffmpeg"):
        sys.exit("closed_loop: -o: a video needs ffmpeg; a folder does not")
    folder = pathlib.Path(args.output if not is_video else args.output + ".frames")
    folder.mkdir(parents=True)
    step_us = round(1e6 / args.rate)
    frames, began, slowest, nearest = 0, time.monotonic(), math.inf, math.inf
    for start_us in range(int(path.times_us[0]), int(path.times_us[-1]) - step_us, step_us):
        if (start_us - path.times_us[0]) * 1e-6 >= args.seconds:
            break
        at_start = car.place()
        car.drive(path, nearest, step_us * 1e-6)
        at_end = car.place()
        end_us = start_us + step_us
        then, later = client.recorded_actors(start_us), client.recorded_actors(end_us)
        actors = {name: (place, later.get(name, place)) for name, place in then.items() if name != obstacle}
        if obstacle:
            actors[obstacle] = blocked, blocked
        (folder / f"{frames:06d}.png").write_bytes(
            client.picture(camera, start_us, end_us, [behind(p, rig_from_camera) for p in (at_start, at_end)], actors))
        points = client.sweep(args.lidar, start_us, end_us, [behind(p, rig_from_lidar) for p in (at_start, at_end)], actors)
        ahead = points[(np.abs(points[:, 1]) < 1.0) & (points[:, 0] > 2.0) & (points[:, 2] > -1.3)]
        nearest = float(np.partition(ahead[:, 0], SPECKS)[SPECKS]) if len(ahead) > SPECKS else math.inf
        slowest = min(slowest, car.speed)
        off_m = math.hypot(*(np.array([car.x, car.y]) - recorded.at(recorded.nearest(car.x, car.y))[:2]))
        print(f"{frames:4d}  {car.speed:5.1f} m/s  {off_m:5.2f} m off the recorded path  LiDAR: {nearest:5.1f} m to what is ahead")
        frames += 1
    seconds = time.monotonic() - began
    print(f"{frames} frames, {frames / seconds:.1f} a second, slowest {slowest:.2f} m/s")
    if is_video:
        subprocess.run(["ffmpeg", "-v", "error", "-y", "-framerate", str(args.rate), "-i", str(folder / "%06d.png"),
                        "-pix_fmt", "yuv420p", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", args.output], check=True)
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
