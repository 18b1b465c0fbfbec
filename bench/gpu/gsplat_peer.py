#!/usr/bin/env python3
"""Renders the same particles with gsplat and simuli: gsplat_peer.py BIN [--demo FOLDER] [--frame N] [--size WxH] [--json]

FOLDER: output of `simuli demo -o FOLDER`; without it the demo runs first. Both render the camera set without actors, at rest, by default at
640 x 360: gsplat with its CUDA rasteriser if PyTorch has a device, else with its projection and spherical harmonics in pure Python and
a loop over particles instead of its rasteriser (only the picture is valid, not the time). Simuli uses exact extents and order by range ("balanced").

Prints the times of a frame (gsplat: median of 50 after 10; simuli: `simuli bench --trade`, the same camera along the complete drive) and the PSNR
between both pictures in pixels with a transmittance below 1 %. Both use tiles of 16 x 16 and cut-offs of 1/255 and 1e-4. Exit code 77
if PyTorch, NumPy or gsplat are missing.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

try:
    import numpy as np
    import torch
    from gsplat.cuda import _torch_impl
except ImportError as error:
    print(f"gsplat_peer.py: left out, {error}", file=sys.stderr)
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent))
import tensor_reference  # noqa: E402

torch.set_default_dtype(torch.float32)  # tensor_reference sets double


def run(*words):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"gsplat_peer.py: {' '.join(map(str, words[:3]))}: {(done.stderr.strip() or 'no message').splitlines()[-1]}")
    return done.stdout


def particles(ply, device):
    """Returns means, quaternions wxyz, scales, opacities, SH [N, K, 3]."""
    p = tensor_reference.read_set(ply, 3)
    quats = torch.nn.functional.normalize(p["quaternion"], dim=-1)
    return tuple(x.float().to(device) for x in (p["mean"], quats, p["scale"], p["opacity"], p["sh"]))


def stand_in(means, quats, scales, opacities, sh, view, k, width, height):
    """Blends gsplat's pure-Python projection and colours particle by particle."""
    degree = int(round(sh.shape[1] ** 0.5)) - 1
    covariances, _ = _torch_impl._quat_scale_to_covar_preci(quats, scales, True, False)
    radii, means2d, depths, conics, _ = _torch_impl._fully_fused_projection(means, covariances, view[None], k[None], width, height)
    centre = torch.linalg.inv(view)[:3, 3]
    colours = torch.clamp_min(_torch_impl._spherical_harmonics(degree, means - centre, sh) + 0.5, 0.0).numpy()
    radii, means2d, depths, conics = (x[0].numpy() for x in (radii, means2d, depths, conics))
    opacities = opacities.numpy()
    out, left = np.zeros((height, width, 3), np.float32), np.ones((height, width), np.float32)
    seen = np.flatnonzero((radii > 0).all(-1))
    for i in seen[np.argsort(depths[seen], kind="stable")]:
        low = np.maximum(np.floor(means2d[i] - radii[i]), 0).astype(int)
        high = np.minimum(np.ceil(means2d[i] + radii[i]), (width, height)).astype(int)
        if (low >= high).any():
            continue
        dx = np.arange(low[0], high[0]) + 0.5 - means2d[i, 0]
        dy = (np.arange(low[1], high[1]) + 0.5 - means2d[i, 1])[:, None]
        a, b, c = conics[i]
        alpha = np.minimum(opacities[i] * np.exp(-0.5 * (a * dx * dx + c * dy * dy) - b * dx * dy), 0.999)
        place = (slice(low[1], high[1]), slice(low[0], high[0]))
        weight = np.where((alpha < 1 / 255) | (left[place] < 1e-4), 0.0, alpha) * left[place]
        out[place] += weight[..., None] * colours[i]
        left[place] -= weight
    return out


def rasterized(arguments, view, k, width, height):
    """Returns the picture and the time in ms."""
    from gsplat import rasterization
    means, quats, scales, opacities, sh = arguments
    degree = int(round(sh.shape[1] ** 0.5)) - 1

    def frame():
        return rasterization(means, quats, scales, opacities, sh, view[None], k[None], width, height, sh_degree=degree, near_plane=0.01,
                             tile_size=16)[0][0]
    samples = []
    for i in range(-10, 50):
        begin, end = torch.cuda.Event(enable_timing=True), torch.cuda.Event(enable_timing=True)
        begin.record()
        picture = frame()
        end.record()
        torch.cuda.synchronize()
        if i >= 0:
            samples.append(begin.elapsed_time(end))
    return picture.cpu().numpy(), statistics.median(samples)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("--demo", type=pathlib.Path)
    parser.add_argument("--frame", type=int, default=4)
    parser.add_argument("--size", default="640x360")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    width, height = (int(side) for side in arguments.size.split("x"))
    simuli = arguments.bin / "simuli"
    with tempfile.TemporaryDirectory() as temporary:
        work = pathlib.Path(temporary)
        demo = arguments.demo or work / "demo"
        if not demo.exists():
            run(simuli, "demo", "-o", demo)
        scene, log = demo / "street.scene", demo / "street.log"
        run(simuli, "export", scene, "-o", work / "camera.ply")
        run(simuli, "render", scene, "--sensor", "front", "--frames", f"{arguments.frame}:{arguments.frame}", "--duration", 0, "--size",
            arguments.size, "--remove", "car", "--images", "exr", "--outputs", "rgb,opacity", "--values", "npz", "-o", work / "ours")
        told = json.loads((work / "ours/frames.json").read_text())
        files = {pathlib.Path(name).suffix: work / "ours" / name for name in told["frames"][0]["files"]}
        ours = tensor_reference.read_exr(files[".exr"])
        with np.load(files[".npz"]) as arrays:
            opaque = arrays["opacity"].reshape(height, width) > 0.99

        device = "cuda" if torch.cuda.is_available() else "cpu"
        pose = told["frames"][0]["world_from_sensor_start"]
        origin = json.loads((scene / "scene.json").read_text())["origin_m"]
        world_from_sensor = torch.eye(4)
        world_from_sensor[:3, :3] = torch.as_tensor(np.asarray(tensor_reference.rotation(
            torch.tensor(pose["rotation_wxyz"], dtype=torch.float64))), dtype=torch.float32)
        world_from_sensor[:3, 3] = torch.tensor(pose["position_m"]) - torch.tensor(origin)
        view = torch.linalg.inv(world_from_sensor).to(device)
        camera = told["sensor"]
        k = torch.tensor([[camera["fx_px"], 0, camera["cx_px"]], [0, camera["fy_px"], camera["cy_px"]], [0, 0, 1]], device=device)
        own = particles(work / "camera.ply", device)
        found = {"particles": len(own[0]), "size": arguments.size, "rasteriser": "gsplat CUDA" if device == "cuda" else "stand-in"}
        if device == "cuda":
            theirs, found["gsplat_ms"] = rasterized(own, view, k, width, height)
        else:
            theirs = stand_in(*own, view, k, width, height)
        difference = (np.clip(ours, 0, 1) - np.clip(theirs, 0, 1))[opaque]
        found["psnr_db"] = float(-10 * np.log10(np.mean(difference ** 2)))
        found["opaque_share"] = float(opaque.mean())
        scale = width / json.loads((log / "log.json").read_text())["cameras"][0]["width_px"]
        rows = json.loads(run(simuli, "bench", "--json", "--trade", scene, log, "--sensor", "front", "--scale", scale, "--repeats", 21, "--set",
                              "render.order=range"))
        found["simuli_ms"] = next(row["value"] for row in rows if row["name"].endswith("/balanced/frame"))
        if "gsplat_ms" in found:
            found["gsplat_over_simuli"] = found["gsplat_ms"] / found["simuli_ms"]
    print(json.dumps(found) if arguments.json else "\n".join(f"{key}: {value}" for key, value in found.items()))


if __name__ == "__main__":
    main()
