"""CARLA's module as far as its NuRec client asks: a world without physics, in which actors are where they were put.

Left-handed as Unreal: x forward, y right, z up; angles in degrees. Poses that are set show in the next tick.
"""
import fnmatch
import math

import numpy as np


class Vector3D:
    def __init__(self, x=0.0, y=0.0, z=0.0):
        self.x, self.y, self.z = float(x), float(y), float(z)


class Location(Vector3D):
    def distance(self, other):
        return math.dist((self.x, self.y, self.z), (other.x, other.y, other.z))


class Rotation:
    def __init__(self, pitch=0.0, yaw=0.0, roll=0.0):
        self.pitch, self.yaw, self.roll = float(pitch), float(yaw), float(roll)


class Transform:
    # Signs of pitch and roll in get_matrix(): +1 as the wheel of CARLA 0.10 has them, -1 as the engine (nose up, right
    # side down). The client's utils.py goes with the one or the other, by its version.
    sign = 1.0

    def __init__(self, location=None, rotation=None):
        self.location, self.rotation = location or Location(), rotation or Rotation()

    def get_matrix(self):
        r, p = (math.radians(self.sign * a) for a in (self.rotation.roll, self.rotation.pitch))
        y = math.radians(self.rotation.yaw)
        about_x = np.array([[1, 0, 0], [0, math.cos(r), -math.sin(r)], [0, math.sin(r), math.cos(r)]])
        about_y = np.array([[math.cos(p), 0, math.sin(p)], [0, 1, 0], [-math.sin(p), 0, math.cos(p)]])
        about_z = np.array([[math.cos(y), -math.sin(y), 0], [math.sin(y), math.cos(y), 0], [0, 0, 1]])
        matrix = np.eye(4)
        matrix[:3, :3] = about_z @ about_y @ about_x
        matrix[:3, 3] = self.location.x, self.location.y, self.location.z
        return matrix.tolist()


class BoundingBox:
    def __init__(self, location, extent):
        self.location, self.extent = location, extent


class Blueprint:
    def __init__(self, id, length, width, height):
        self.id = id
        walks = id.startswith("walker")
        self.bounding_box = BoundingBox(Location(0.1, 0.0, 0.0 if walks else height / 2),
                                        Vector3D(length / 2, width / 2, height / 2))


class BlueprintLibrary(list):
    def find(self, id):
        return next(b for b in self if b.id == id)

    def filter(self, pattern):
        return [b for b in self if fnmatch.fnmatch(b.id, pattern)]


class Actor:
    def __init__(self, world, id, blueprint, transform):
        self.world, self.id, self.type_id, self.bounding_box = world, id, blueprint.id, blueprint.bounding_box
        self.transform = self.pending = transform

    def set_transform(self, transform):
        assert self.id in self.world.actors or self is self.world.spectator, "the actor is gone"
        self.pending = transform

    def get_transform(self):
        return self.transform

    def get_location(self):
        return self.transform.location

    def set_simulate_physics(self, enabled):
        assert not enabled, "there is no physics here"

    def destroy(self):
        del self.world.actors[self.id]


class ActorSnapshot:
    def __init__(self, actor):
        self.id, self.transform = actor.id, actor.transform

    def get_transform(self):
        return self.transform


class Timestamp:
    def __init__(self, elapsed_seconds):
        self.elapsed_seconds = elapsed_seconds


class WorldSnapshot:
    def __init__(self, world):
        self.timestamp = Timestamp(world.elapsed_s)
        self.actors = {a.id: ActorSnapshot(a) for a in world.actors.values()}

    def __iter__(self):
        return iter(self.actors.values())

    def find(self, id):
        return self.actors.get(id)


class WorldSettings:
    def __init__(self, synchronous_mode=False, fixed_delta_seconds=None):
        self.synchronous_mode, self.fixed_delta_seconds = synchronous_mode, fixed_delta_seconds


class World:
    def __init__(self, opendrive):
        self.opendrive = opendrive
        self.elapsed_s = 1.0
        self.actors, self.callbacks, self.settings = {}, [], WorldSettings()
        self.blueprints = BlueprintLibrary([
            Blueprint("vehicle.ue4.mercedes.ccc", 4.7, 1.8, 1.4), Blueprint("vehicle.small", 3.6, 1.6, 1.5),
            Blueprint("vehicle.truck", 8.5, 2.6, 3.2), Blueprint("walker.pedestrian.0001", 0.4, 0.4, 1.86)])
        self.count = 0
        self.spectator = Actor(self, -1, self.blueprints[0], Transform())

    def get_blueprint_library(self):
        return self.blueprints

    def try_spawn_actor(self, blueprint, transform):
        self.count += 1
        self.actors[self.count] = Actor(self, self.count, blueprint, transform)
        return self.actors[self.count]

    spawn_actor = try_spawn_actor

    def get_spectator(self):
        return self.spectator

    def get_snapshot(self):
        return WorldSnapshot(self)

    def get_settings(self):
        return self.settings

    def apply_settings(self, settings):
        self.settings = settings

    def on_tick(self, callback):
        self.callbacks.append(callback)

    def tick(self):
        self.elapsed_s += self.settings.fixed_delta_seconds or 0.05
        for actor in self.actors.values():
            actor.transform = actor.pending
        snapshot = self.get_snapshot()
        for callback in self.callbacks:
            callback(snapshot)


class OpendriveGenerationParameters:
    def __init__(self, **values):
        self.__dict__.update(values)


class Client:
    world = None

    def generate_opendrive_world(self, opendrive, parameters):
        self.world = World(opendrive)
        return self.world

    def get_world(self):
        return self.world

    def get_server_version(self):
        return "stand-in"


class TrafficManager:
    pass


class VehicleControl:
    pass
