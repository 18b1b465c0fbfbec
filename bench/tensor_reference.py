#!/usr/bin/env python3
"""Compares pictures and sweeps with the formulas of docs/METHOD.md on tensors: tensor_reference.py SIMULI SCENE [TIME_S]

Reads the scene folder with NumPy, evaluates each particle on each ray in double precision with PyTorch, sorts the responses of each ray by
distance and blends them: no projection, no tiles, no code of simuli. Then renders the same time with the program SIMULI
(without actors, exact extents, per-ray order) and compares. Exit code 1 if a bound is exceeded.

Supports pinholes without distortion, spinning LiDARs with lever arms, sensors that move during a frame; no environment map, no
bilateral grid. Needs Python 3.9, numpy and torch (Debian: python3-numpy, python3-torch).
"""
import json
import math
import pathlib
import struct
import subprocess
import sys
import tempfile
import zlib

import numpy as np
import torch

ALPHA_CUT, TRANSMITTANCE_CUT, ALPHA_MAX = 1 / 255, 1e-4, 0.999
CAMERA_FILTER_PX2 = 1 / 12
SWEEP_S = 0.1
RAYS_AT_ONCE, PARTICLES_AT_ONCE = 128, 2048  # sized for the cache
# Float against double: directions differ by 6e-8, and responses at the cut may be decided differently.
ONE_SURFACE_M = 0.15  # host/device/render/scene/seen.cpp
LEAST_PSNR_DB, MOST_MEDIAN_M, MOST_P99_M, MOST_CHANGED, MOST_INTENSITY = 60.0, 1e-4, 2e-3, 1e-3, 1e-3
torch.set_default_dtype(torch.float64)


def tensor(values):
    return torch.from_numpy(np.array(values, dtype=np.float64))


def read_ply(path):
    """Returns the columns of a binary little-endian PLY of vertices."""
    kinds = {"float": "<f4", "double": "<f8", "uint": "<u4", "int": "<i4", "uchar": "u1"}
    with open(path, "rb") as file:
        fields, count = [], 0
        while (line := file.readline().decode("ascii").split()) != ["end_header"]:
            if line[:2] == ["element", "vertex"]:
                count = int(line[2])
            if line[0] == "property":
                fields.append((line[2], kinds[line[1]]))
        return np.frombuffer(file.read(), dtype=np.dtype(fields), count=count)


def read_exr(path):
    """Returns a scan-line OpenEXR picture, [height, width, 3], uncompressed or with ZIP compression."""
    data = open(path, "rb").read()
    at, header = 8, {}
    while data[at]:
        end = data.index(b"\0", at)
        name, at = data[at:end].decode(), end + 1
        at = data.index(b"\0", at) + 1
        size = struct.unpack_from("<i", data, at)[0]
        header[name] = data[at + 4 : at + 4 + size]
        at += 4 + size
    channels, raw = [], header["channels"]
    while raw[0]:
        end = raw.index(b"\0")
        kind = struct.unpack_from("<i", raw, end + 1)[0]
        channels.append((raw[:end].decode(), {1: "<f2", 2: "<f4"}[kind]))
        raw = raw[end + 17 :]
    x0, y0, x1, y1 = struct.unpack("<4i", header["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    lines = {0: 1, 2: 1, 3: 16}[header["compression"][0]]
    offsets = struct.unpack_from(f"<{-(-height // lines)}Q", data, at + 1)
    out = {name: np.zeros((height, width)) for name, _ in channels}
    for offset in offsets:
        y, size = struct.unpack_from("<2i", data, offset)
        y -= y0
        rows = min(lines, height - y)
        expected = rows * width * sum(np.dtype(kind).itemsize for _, kind in channels)
        block = data[offset + 8 : offset + 8 + size]
        if size < expected:
            steps = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
            steps[1:] -= 128
            halves = (np.cumsum(steps) & 255).astype(np.uint8)
            whole = np.empty_like(halves)
            middle = (len(halves) + 1) // 2
            whole[0::2], whole[1::2] = halves[:middle], halves[middle:]
            block = whole.tobytes()
        place = 0
        for row in range(rows):
            for name, kind in channels:
                out[name][y + row] = np.frombuffer(block, kind, width, place)
                place += width * np.dtype(kind).itemsize
    return np.stack([out[c] for c in "RGB"], -1)


def rotation(q):
    """Returns matrices [..., 3, 3] of quaternions [..., 4] (w, x, y, z) of any norm."""
    w, x, y, z = (q / q.norm(dim=-1, keepdim=True)).unbind(-1)
    return torch.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                        2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                        2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1).unflatten(-1, (3, 3))


def slerp(a, b, u):
    """Interpolates quaternions a and b [4] on the shorter arc at shares u [N]; returns [N, 4]."""
    a, b = a / a.norm(), b / b.norm()
    b = -b if a @ b < 0 else b
    angle = 2 * torch.atan2((a - b).norm(), (a + b).norm())
    u = u[:, None]
    if angle < 1e-9:
        return (1 - u) * a + u * b
    return (torch.sin((1 - u) * angle) * a + torch.sin(u * angle) * b) / torch.sin(angle)


def product(a, b):
    """Returns the quaternion of rotation b followed by a."""
    return torch.cat([(a[0] * b[0] - a[1:] @ b[1:])[None],
                      a[0] * b[1:] + b[0] * a[1:] + torch.linalg.cross(a[1:], b[1:])])


def pose_at(path, mount, origin, time_s):
    """Returns quaternion and position (relative to the scene origin) of a sensor on the rig at a time."""
    times = [p["time_ns"] * 1e-9 for p in path]
    k = min(max(int(np.searchsorted(times, time_s, side="right")) - 1, 0), len(path) - 2)
    a, b = path[k], path[k + 1]
    u = tensor([(time_s - times[k]) / (times[k + 1] - times[k])])
    q = slerp(tensor(a["rotation_wxyz"]), tensor(b["rotation_wxyz"]), u)[0]
    t = (1 - u) * tensor(a["position_m"]) + u * tensor(b["position_m"])
    return (product(q, tensor(mount["rotation_wxyz"]) / tensor(mount["rotation_wxyz"]).norm()),
            rotation(q) @ tensor(mount["position_m"]) + t - origin)


def in_world(start, end, share, origins, directions):
    """Transforms rays to the world, each at its share of the frame: slerp of the rotation, lerp of the centre."""
    r = rotation(slerp(start[0], end[0], share))
    centre = (1 - share[:, None]) * start[1] + share[:, None] * end[1]
    turn = lambda v: (r @ v[:, :, None])[:, :, 0]
    return turn(origins) + centre, turn(directions)


def camera_rays(camera):
    """Returns origins, directions and time shares of all pixels, row by row."""
    if camera["model"] != "pinhole" or camera["shutter"] != "global":
        sys.exit(f"tensor_reference.py: camera: found {camera['model']}, {camera['shutter']}, allowed pinhole, global")
    y, x = torch.meshgrid(torch.arange(camera["height_px"]) + 0.5, torch.arange(camera["width_px"]) + 0.5, indexing="ij")
    d = torch.stack([(x - camera["cx_px"]) / camera["fx_px"], (y - camera["cy_px"]) / camera["fy_px"], torch.ones_like(x)], -1)
    d = (d / d.norm(dim=-1, keepdim=True)).reshape(-1, 3)
    return torch.zeros_like(d), d, torch.full((len(d),), 0.5)


def lidar_rays(lidar):
    """Returns origins, directions and time shares of all rays, beam by beam."""
    row = lambda key: tensor([r[key] for r in lidar["rows"]])[:, None]
    spin = -1 if lidar["spin"] == "clockwise" else 1
    columns = torch.arange(lidar["columns"], dtype=torch.float64)
    azimuth = lidar["azimuth_first_rad"] + spin * lidar["azimuth_span_rad"] / lidar["columns"] * columns + row("azimuth_offset_rad")
    share = (columns + 0.5) / lidar["columns"] + row("time_offset_s") / SWEEP_S
    sine, cosine, up = azimuth.sin(), azimuth.cos(), row("elevation_rad").expand_as(azimuth)
    out, side = row("radial_offset_m"), row("horizontal_offset_m")
    o = torch.stack([out * cosine - side * sine, out * sine + side * cosine, row("vertical_offset_m").expand_as(azimuth)], -1)
    d = torch.stack([up.cos() * cosine, up.cos() * sine, up.sin()], -1)
    return o.reshape(-1, 3), d.reshape(-1, 3), share.reshape(-1)


def spherical_harmonics(degree, d):
    x, y, z = d.unbind(-1)
    basis = [torch.full_like(x, 0.28209479177387814)]
    if degree > 0:
        basis += [-0.4886025119029199 * y, 0.4886025119029199 * z, -0.4886025119029199 * x]
    if degree > 1:
        basis += [1.0925484305920792 * x * y, -1.0925484305920792 * y * z, 0.31539156525252005 * (2 * z * z - x * x - y * y),
                  -1.0925484305920792 * x * z, 0.5462742152960396 * (x * x - y * y)]
    if degree > 2:
        basis += [-0.5900435899266435 * y * (3 * x * x - y * y), 2.890611442640554 * x * y * z,
                  -0.4570457994644658 * y * (4 * z * z - x * x - y * y), 0.3731763325901154 * z * (2 * z * z - 3 * x * x - 3 * y * y),
                  -0.4570457994644658 * x * (4 * z * z - x * x - y * y), 1.445305721320277 * z * (x * x - y * y),
                  -0.5900435899266435 * x * (x * x - 3 * y * y)]
    return torch.stack(basis, -1)


def read_set(path, clamped):
    """Returns background particles as a dictionary of tensors; `clamped` features are biased by 1/2 and not negative."""
    v = read_ply(path)
    if "actor" in v.dtype.names:
        v = v[v["actor"] == 0]
    get = lambda *names: tensor(np.stack([v[n] for n in names], -1))
    rest = sum(name.startswith("f_rest_") for name in v.dtype.names)
    sh = get("f_dc_0", "f_dc_1", "f_dc_2")[:, None]
    if rest:
        sh = torch.cat([sh, get(*[f"f_rest_{i}" for i in range(rest)]).unflatten(1, (3, rest // 3)).transpose(1, 2)], 1)
    quaternion = get("rot_0", "rot_1", "rot_2", "rot_3")
    return {"mean": get("x", "y", "z"), "scale": get("scale_0", "scale_1", "scale_2").exp(),
            "quaternion": quaternion, "rotation": rotation(quaternion), "opacity": torch.sigmoid(get("opacity")[:, 0]),
            "sh": sh, "degree": math.isqrt(sh.shape[1]) - 1, "clamped": clamped}


def monomials(a, b=None):
    """Returns the factors that give a'Pb for a symmetric matrix P with entries (xx, yy, zz, xy, xz, yz)."""
    b = a if b is None else b
    off = lambda i, j: a[:, i] * b[:, j] + a[:, j] * b[:, i]
    return torch.stack([a[:, 0] * b[:, 0], a[:, 1] * b[:, 1], a[:, 2] * b[:, 2], off(0, 1), off(0, 2), off(1, 2)], -1)


def render(particles, origins, directions, centre, kappa, background, t_min, t_max, by_range=False):
    """Returns features [rays, 3], transmittance, sum of w tau and median distance of all rays (METHOD sections 7 and 8), in per-ray order
    or in order of the particles' ranges."""
    # Relative to the sensor position in the middle of the frame.
    mean, origins = particles["mean"] - centre, origins - centre
    range2 = (mean * mean).sum(1)
    basis = spherical_harmonics(particles["degree"], mean / range2.sqrt()[:, None])
    feature = (basis[:, :, None] * particles["sh"]).sum(1)
    c = particles["clamped"]
    feature[:, :c] = (feature[:, :c] + 0.5).clamp(min=0)
    filtered2 = particles["scale"] ** 2 + kappa * range2[:, None]
    r = particles["rotation"]
    p = (r / filtered2[:, None, :]) @ r.transpose(1, 2)  # inverse covariance
    six = torch.stack([p[:, 0, 0], p[:, 1, 1], p[:, 2, 2], p[:, 0, 1], p[:, 0, 2], p[:, 1, 2]], -1)
    p_mean = (p @ mean[:, :, None])[:, :, 0]
    linear = torch.cat([six, -p_mean], 1)
    square = torch.cat([six, -2 * p_mean, (p_mean * mean).sum(1, keepdim=True)], 1)
    q_max = 2 * torch.log(particles["opacity"] / ALPHA_CUT)
    out = []
    for first in range(0, len(directions), RAYS_AT_ONCE):
        o, d = origins[first : first + RAYS_AT_ONCE], directions[first : first + RAYS_AT_ONCE]
        by_n, by_dot = monomials(d), torch.cat([monomials(o, d), d], 1)
        by_square = torch.cat([monomials(o), o, torch.ones_like(o[:, :1])], 1)
        hits = []
        for i in range(0, len(mean), PARTICLES_AT_ONCE):
            part = slice(i, i + PARTICLES_AT_ONCE)
            n = by_n @ six[part].T            # d'Pd
            dot = by_dot @ linear[part].T     # d'P(o - mu)
            q = by_square @ square[part].T - dot * dot / n
            ray, which = torch.nonzero(q <= q_max[part], as_tuple=True)
            hits.append((ray, which + i, q[ray, which], -dot[ray, which] / n[ray, which]))
        ray, which, q, tau = (torch.cat(v) for v in zip(*hits))
        ray, which, q, tau = (v[(tau > t_min) & (tau < t_max)] for v in (ray, which, q, tau))
        alpha = (particles["opacity"][which] * torch.exp(-0.5 * q)).clamp(max=ALPHA_MAX)
        order = torch.argsort(range2[which] if by_range else tau, stable=True)
        order = order[torch.argsort(ray[order], stable=True)]
        ray, which, alpha, tau = ray[order], which[order], alpha[order], tau[order]
        counts = torch.bincount(ray, minlength=len(d))
        place = torch.arange(len(ray)) - (torch.cumsum(counts, 0) - counts)[ray]
        dense = lambda v: torch.zeros(len(d), max(int(counts.max()), 1), *v.shape[1:]).index_put((ray, place), v)
        a, t, f = dense(alpha), dense(tau), dense(feature[which])
        after = torch.cumprod(1 - a, 1)
        before = torch.cat([torch.ones(len(d), 1), after[:, :-1]], 1)
        w = torch.where(before >= TRANSMITTANCE_CUT, a * before, torch.zeros_like(a))
        left = 1 - w.sum(1)
        half = (before > 0.5) & (after <= 0.5)
        out.append(torch.cat([(w[:, :, None] * f).sum(1) + left[:, None] * background, left[:, None],
                              (w * t).sum(1, keepdim=True), (t * half).sum(1, keepdim=True)], 1))
    out = torch.cat(out)
    return out[:, :3], out[:, 3], out[:, 4], out[:, 5]


def rays_of(points, origins, directions):
    """Returns for each point the nearest ray and the distance from it in m."""
    which, beside = [], []
    for first in range(0, len(points), RAYS_AT_ONCE):
        p = points[first : first + RAYS_AT_ONCE]
        along = p @ directions.T - (origins * directions).sum(1)
        off2 = (p * p).sum(1, keepdim=True) - 2 * p @ origins.T + (origins * origins).sum(1) - along**2
        best = torch.where(along > 0, off2, torch.full_like(off2, math.inf)).min(1)
        which.append(best.indices)
        beside.append(best.values.clamp(min=0).sqrt())
    return torch.cat(which), torch.cat(beside)


def drop_logit(parameters, feature, left, distance):
    """Returns ln(p / (1 - p)) of the ray drop probability p (METHOD section 7); without parameters only from the logits."""
    opacity = 1 - left
    reach = distance + 20 * opacity
    inputs = torch.stack([feature[:, 2] - feature[:, 1], 10 * left, 10 * feature[:, 0],
                          10 * opacity * distance / torch.where(reach > 0, reach, torch.ones_like(reach))], 1)
    if parameters is None:
        return inputs[:, 0]
    skip, bias, hidden, out = parameters[:4], parameters[4], parameters[5:45].reshape(8, 5), parameters[45:]
    sums = inputs @ hidden[:, :4].T + hidden[:, 4]
    return inputs @ skip + bias + (sums / (1 + sums.abs())) @ out


def main(program, folder, time_s="1"):
    folder, time_s = pathlib.Path(folder), float(time_s)
    scene = json.load(open(folder / "scene.json"))
    for key in ("environment", "color_grids"):
        if key in scene:
            sys.exit(f"tensor_reference.py: {folder}: found {key}, allowed a scene without")
    origin, path = tensor(scene["origin_m"]), scene["world_from_rig"]
    work = tempfile.TemporaryDirectory()

    def simuli(sensor, *more):
        out = pathlib.Path(work.name) / sensor
        removed = [word for actor in scene.get("actors", []) for word in ("--remove", actor["name"])]
        done = subprocess.run([program, "render", str(folder), "--sensor", sensor, "-o", str(out), "--times", f"{time_s}:{time_s}:1",
                               *removed, *more, "--set", "render.order=per_ray", "render.extent=exact"],
                              capture_output=True, text=True)
        if done.returncode:
            sys.exit(f"tensor_reference.py: {program} render: exit code {done.returncode}: {done.stderr.strip()[-300:]}")
        return out / f"{sensor}_000000"

    broken = []

    def check(name, value, bound, unit, at_least=False):
        print(f"{name:<44} {value:>12.6g} {unit:<6} ({'at least' if at_least else 'at most'} {bound:g})")
        if not (value >= bound if at_least else value <= bound):
            broken.append(name)

    camera = scene["cameras"][0]
    pose = pose_at(path, camera["rig_from_camera"], origin, time_s)
    rays = in_world(pose, pose, *(camera_rays(camera)[k] for k in (2, 0, 1)))
    kappa = CAMERA_FILTER_PX2 / (camera["fx_px"] * camera["fy_px"])
    background = tensor(scene["camera_set"]["background"])
    picture = render(read_set(folder / "camera.ply", 3), *rays, pose[1], kappa, background, 0.01, 1e6)[0].clamp(0, 1)
    found = tensor(read_exr(f"{simuli(camera['name'], '--images', 'exr')}.exr")).reshape(-1, 3).clamp(0, 1)
    check(f"{camera['name']}: PSNR", float(-10 * torch.log10(((picture - found) ** 2).mean())), LEAST_PSNR_DB, "dB", True)
    print(f"{camera['name']}: largest difference {float((picture - found).abs().max()):.3g} of 1")

    lidar = scene["lidars"][0]
    start, end = (pose_at(path, lidar["rig_from_lidar"], origin, t) for t in (time_s, time_s + SWEEP_S))
    origins, directions, share = lidar_rays(lidar)
    origins, directions = in_world(start, end, share, origins, directions)
    kappa = lidar["divergence_variance"] * math.tan(lidar["beam_divergence_rad"] / 2) ** 2
    feature, left, distance, median = render(read_set(folder / "lidar.ply", 1), origins, directions, (start[1] + end[1]) / 2, kappa,
                                             tensor(scene["lidar_set"]["background"]), lidar["range_min_m"], lidar["range_max_m"])
    drops = scene.get("ray_drop", [])
    drop = next((d for d in drops if d["lidar"] == lidar["name"]), drops[0] if drops else None)
    logit = drop_logit(None if drop is None else tensor(drop["parameters"]), feature, left, distance)
    expected = torch.where(left < 1, distance / (1 - left), torch.zeros_like(left))
    distance = torch.where((median > 0) & ((expected - median).abs() > ONE_SURFACE_M), median, expected)
    returns = (logit <= 0) & (distance > 0)
    cloud = np.load(f"{simuli(lidar['name'], '--clouds', 'npz')}.npz")
    which, beside = rays_of(tensor(cloud["xyz"]) - origin, origins, directions)
    if not bool((which[1:] > which[:-1]).all()):
        broken.append("order of the returns")
    ours = torch.zeros(len(returns), dtype=torch.bool)
    ours[which] = True
    bias = tensor([r.get("range_bias_m", 0.0) for r in lidar["rows"]]).repeat_interleave(lidar["columns"])
    both = returns[which]
    apart = (tensor(cloud["range"]) - (distance + bias)[which])[both].abs().sort().values
    intensity = (tensor(cloud["intensity"]) - feature[which, 0].clamp(0, 1))[both]
    check(f"{lidar['name']}: returns beside their rays, worst", float(beside.max()), MOST_MEDIAN_M, "m")
    check(f"{lidar['name']}: rays that return in only one", float((ours != returns).double().mean()), MOST_CHANGED, "of 1")
    check(f"{lidar['name']}: distance error, median", float(apart[len(apart) // 2]), MOST_MEDIAN_M, "m")
    check(f"{lidar['name']}: distance error, 99th percentile", float(apart[len(apart) * 99 // 100]), MOST_P99_M, "m")
    check(f"{lidar['name']}: intensity error, RMS", float((intensity**2).mean().sqrt()), MOST_INTENSITY, "of 1")
    print(f"{lidar['name']}: {len(apart)} returns in both of {len(returns)} rays, largest distance error {float(apart[-1]):.3g} m")
    if broken:
        sys.exit("tensor_reference.py: bounds broken: " + ", ".join(broken))


if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(f"tensor_reference.py: found {len(sys.argv) - 1} arguments, allowed SIMULI SCENE [TIME_S]")
    main(*sys.argv[1:])
