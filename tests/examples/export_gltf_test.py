"""Splats as glTF, read by another library: export_gltf_test.py SIMULI EXAMPLES WORK"""
import gzip
import pathlib
import sys

import numpy as np
import pygltflib
from export_scene import AT_S, compare, particles, run, scene

simuli, work = sys.argv[1], pathlib.Path(sys.argv[3])
drive = scene(simuli, work)
for name, extra in (("a.ply", ()), ("a.glb", ()), ("spz.glb", ("--compress",))):
    run(simuli, "export", drive, "--at", AT_S, "-o", work / name, *extra)
p = particles(work / "a.ply")

gltf = pygltflib.GLTF2().load_binary(str(work / "a.glb"))
assert gltf.asset.version == "2.0" and gltf.extensionsUsed == ["KHR_gaussian_splatting"]
(primitive,) = gltf.meshes[gltf.nodes[gltf.scenes[gltf.scene].nodes[0]].mesh].primitives
assert primitive.mode == pygltflib.POINTS
assert primitive.extensions["KHR_gaussian_splatting"]["colorSpace"] == "srgb_rec709_display"
binary = gltf.binary_blob()
attributes = {k: v for k, v in vars(primitive.attributes).items() if isinstance(v, int)}


def values(name):
    accessor = gltf.accessors[attributes[name]]
    view = gltf.bufferViews[accessor.bufferView]
    width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor.type]
    kind = {pygltflib.FLOAT: "<f4", pygltflib.UNSIGNED_BYTE: "u1"}[accessor.componentType]
    assert view.byteOffset % 4 == 0
    out = np.frombuffer(binary, kind, accessor.count * width, view.byteOffset).reshape(-1, width)
    assert out.nbytes == view.byteLength
    return out


prefix = "KHR_gaussian_splatting:"
sh = np.stack([values(f"{prefix}SH_DEGREE_{degree}_COEF_{n}") for degree in range(4) for n in range(2 * degree + 1)
               if f"{prefix}SH_DEGREE_{degree}_COEF_{n}" in attributes], 1)
left_up_forward = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]])
compare(p, left_up_forward, values("POSITION"), values(prefix + "ROTATION")[:, [3, 0, 1, 2]], values(prefix + "SCALE"),
        values(prefix + "OPACITY")[:, 0], sh)
bounds = gltf.accessors[attributes["POSITION"]]
assert np.array_equal(np.float32(bounds.min), values("POSITION").min(0))
assert np.array_equal(np.float32(bounds.max), values("POSITION").max(0))
assert np.abs(values("COLOR_0")[:, 3] / 255 - values(prefix + "OPACITY")[:, 0]).max() <= 0.5 / 255 + 1e-6

packed = pygltflib.GLTF2().load_binary(str(work / "spz.glb"))
(primitive,) = packed.meshes[0].primitives
spz = primitive.extensions["KHR_gaussian_splatting"]["extensions"]["KHR_gaussian_splatting_compression_spz_2"]
view = packed.bufferViews[spz["bufferView"]]
inside = gzip.decompress(packed.binary_blob()[view.byteOffset:view.byteOffset + view.byteLength])
assert inside[:4] == b"NGSP" and int.from_bytes(inside[8:12], "little") == len(p["x"])
words = np.frombuffer(inside, "u1", 9 * len(p["x"]), 16).reshape(-1, 3, 3).astype(np.int64)
fixed = words @ np.array([1, 256, 65536])
fixed[fixed >= 1 << 23] -= 1 << 24
assert np.abs(fixed / 2 ** inside[13] - values("POSITION")).max() < 1 / 2 ** inside[13]
print(len(p["x"]), "particles")
