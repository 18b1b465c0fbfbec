"""Renders a scene of simuli with another reader: splat_reader.py SCENE PLY LOG FRAME PICTURE.png [gsply|plyfile]

Reads PLY, made by `simuli export SCENE -o PLY`, with the Python package gsply (or plyfile), splats it in NumPy as the 3DGS paper does (EWA,
screen-space Gaussians, sorted by depth), and prints the PSNR to PICTURE, made by `simuli render` for the same
frame without actors. Uses no code of simuli and assumes a pinhole without distortion and a global shutter.
"""
import json
import sys

import numpy as np
from PIL import Image


def read(path, reader):
    """Returns means, scales, rotations wxyz, opacities, SH [N, K, 3]."""
    if reader == "gsply":
        import gsply

        d = gsply.plyread(path)
        sh = np.concatenate([d.sh0[:, None], d.shN.reshape(len(d.sh0), -1, 3)], 1)
        return d.means, np.exp(d.scales), d.quats, 1 / (1 + np.exp(-d.opacities)), sh
    from plyfile import PlyData

    v = PlyData.read(path)["vertex"]
    get = lambda *names: np.stack([v[n] for n in names], -1)
    rest = sum(p.name.startswith("f_rest_") for p in v.properties)
    sh = get("f_dc_0", "f_dc_1", "f_dc_2")[:, None]
    if rest:
        higher = get(*[f"f_rest_{i}" for i in range(rest)]).reshape(len(sh), 3, -1).transpose(0, 2, 1)
        sh = np.concatenate([sh, higher], 1)
    opacity = 1 / (1 + np.exp(-v["opacity"]))
    return (get("x", "y", "z"), np.exp(get("scale_0", "scale_1", "scale_2")),
            get("rot_0", "rot_1", "rot_2", "rot_3"), opacity, sh)


def rotation(q):
    w, x, y, z = (q / np.linalg.norm(q, axis=-1, keepdims=True)).T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y),
                     2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x),
                     2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1).reshape(-1, 3, 3)


def colour(sh, d):
    x, y, z = d.T[:, :, None]
    basis = [0.28209479177387814 + 0 * x, -0.4886025119029199 * y, 0.4886025119029199 * z, -0.4886025119029199 * x,
             1.0925484305920792 * x * y, -1.0925484305920792 * y * z,
             0.31539156525252005 * (2 * z * z - x * x - y * y), -1.0925484305920792 * x * z,
             0.5462742152960396 * (x * x - y * y)]
    return np.maximum(0.5 + sum(b * sh[:, k] for k, b in enumerate(basis[:sh.shape[1]])), 0)


def pose_at(path, t):
    times = np.array([p["time_ns"] for p in path])
    k = int(np.clip(np.searchsorted(times, t) - 1, 0, len(times) - 2))
    u = (t - times[k]) / (times[k + 1] - times[k])
    a, b = path[k], path[k + 1]
    qa, qb = np.array(a["rotation_wxyz"]), np.array(b["rotation_wxyz"])
    q = (1 - u) * qa + u * np.sign(qa @ qb) * qb
    return rotation(q[None])[0], (1 - u) * np.array(a["position_m"]) + u * np.array(b["position_m"])


def main(scene_folder, ply, log_folder, frame, picture, reader="gsply"):
    mean, scale, quat, opacity, sh = read(ply, reader)
    log = json.load(open(f"{log_folder}/log.json"))
    scene = json.load(open(f"{scene_folder}/scene.json"))
    image = log["images"][int(frame)]
    cam = next(c for c in log["cameras"] if c["name"] == image["camera"])
    rig_r, rig_t = pose_at(log["world_from_rig"], image["time_start_ns"])
    mount = cam["rig_from_camera"]
    r = rig_r @ rotation(np.array(mount["rotation_wxyz"])[None])[0]
    t = rig_r @ np.array(mount["position_m"]) + rig_t - np.array(scene["origin_m"])
    fx, fy, cx, cy, w, h = (cam[k] for k in ("fx_px", "fy_px", "cx_px", "cy_px", "width_px", "height_px"))
    p = (mean - t) @ r
    front = p[:, 2] > 0.2
    d = mean - t
    rgb = colour(sh, d / np.linalg.norm(d, axis=1, keepdims=True))
    m = rotation(quat) * scale[:, None]
    m = np.einsum("ji,njk->nik", r, m)
    x, y, z = p.T
    j = np.zeros((len(p), 2, 3))
    zs = np.where(front, z, 1)
    lim = 1.3
    tx, ty = (np.clip(v / zs, -lim * s / (2 * f), lim * s / (2 * f)) for v, s, f in ((x, w, fx), (y, h, fy)))
    j[:, 0, 0], j[:, 0, 2], j[:, 1, 1], j[:, 1, 2] = fx / zs, -fx * tx / zs, fy / zs, -fy * ty / zs
    jm = j @ m
    cov = jm @ jm.transpose(0, 2, 1) + 0.3 * np.eye(2)
    u, v = fx * x / zs + cx, fy * y / zs + cy
    out, left = np.zeros((h, w, 3)), np.ones((h, w))
    for i in np.argsort(np.linalg.norm(p, axis=1)):
        if not front[i]:
            continue
        a, b, c = cov[i, 0, 0], cov[i, 0, 1], cov[i, 1, 1]
        reach = 3.4 * np.sqrt(max(a, c))
        x0, x1 = int(max(u[i] - reach, 0)), int(min(u[i] + reach + 1, w))
        y0, y1 = int(max(v[i] - reach, 0)), int(min(v[i] + reach + 1, h))
        if x0 >= x1 or y0 >= y1:
            continue
        dx, dy = np.arange(x0, x1) + 0.5 - u[i], (np.arange(y0, y1) + 0.5 - v[i])[:, None]
        alpha = opacity[i] * np.exp(-0.5 * (c * dx * dx - 2 * b * dx * dy + a * dy * dy) / (a * c - b * b))
        alpha = np.where(alpha < 1 / 255, 0, np.minimum(alpha, 0.99))
        weight = left[y0:y1, x0:x1] * alpha
        out[y0:y1, x0:x1] += weight[:, :, None] * rgb[i]
        left[y0:y1, x0:x1] -= weight
    background = scene["camera_set"].get("background", [0, 0, 0])
    out = np.clip(out + left[:, :, None] * np.array(background), 0, 1)
    other = np.asarray(Image.open(picture).convert("RGB"), float) / 255
    print(f"{reader}: {len(mean)} particles, PSNR {-10 * np.log10(np.mean((out - other) ** 2)):.2f} dB")
    Image.fromarray(np.round(255 * out).astype(np.uint8)).save("splat_reader.png")


if __name__ == "__main__":
    main(*sys.argv[1:])
