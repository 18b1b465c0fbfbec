"""Renders a scene of simuli with another viewer: splat_viewer.py SCENE PLY LOG FRAME PICTURE.png [OUT.png]

Reads PLY, made by `simuli export SCENE -o PLY`, with the Python package gsply, renders it with viser, a WebGL renderer
of splats in a browser (a headless Chromium controlled by playwright), and prints the PSNR to PICTURE, made by
`simuli render` at the same time (--times) without actors and with --set render.sh_degree=0, since viser uses one colour
per splat. OUT: viser's picture above simuli's. Uses no code of simuli and assumes a centred pinhole without distortion
and a global shutter.
"""
import json
import sys
import threading
import time

import gsply
import numpy as np
import viser
import viser.transforms
from PIL import Image
from playwright.sync_api import sync_playwright

from splat_reader import pose_at, rotation

CHROMIUM = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


def rendered_by_viser(d, world_rotation, position, width, height, fov):
    """Returns the canvas of a client for this pose, RGBA in [0, 1], [height, width, 4]."""
    m = rotation(d.quats) * np.exp(d.scales)[:, None]
    server = viser.ViserServer(host="127.0.0.1", port=0, verbose=False)
    server.scene.add_gaussian_splats(
        "/scene", (d.means - position).astype(np.float32), (m @ m.transpose(0, 2, 1)).astype(np.float32),
        np.clip(0.5 + 0.28209479177387814 * d.sh0, 0, 1).astype(np.float32),
        (1 / (1 + np.exp(-d.opacities)))[:, None].astype(np.float32))
    found = {}

    def shoot(client):
        try:
            # Splats are drawn with the view of the canvas, not of get_render: so the canvas view is set, too.
            view = {"wxyz": viser.transforms.SO3.from_matrix(world_rotation).wxyz, "position": np.zeros(3)}
            client.camera.fov, client.camera.wxyz, client.camera.position = fov, view["wxyz"], view["position"]
            last = None
            for _ in range(60):  # sorting is asynchronous: waits for two equal pictures
                time.sleep(1)
                shot = client.get_render(height, width, fov=fov, transport_format="png", **view)
                if last is not None and shot.any() and np.array_equal(shot, last):
                    found["picture"] = shot
                    return
                last = shot
            found["error"] = "the picture did not converge"
        except Exception as error:  # in a thread: stored for the caller
            found["error"] = error

    server.on_client_connect(lambda client: threading.Thread(target=shoot, args=(client,), daemon=True).start())
    with sync_playwright() as p:
        browser = p.chromium.launch(executable_path="/usr/bin/chromium", args=CHROMIUM)
        page = browser.new_page(viewport={"width": width, "height": height})
        page.goto(f"http://127.0.0.1:{server.get_port()}/")
        end = time.time() + 300
        while not found and time.time() < end:
            page.wait_for_timeout(500)
        browser.close()
    if "picture" not in found:
        sys.exit(f"splat_viewer.py: no picture: {found.get('error', 'timed out')}")
    return found["picture"] / 255


def main(scene_folder, ply, log_folder, frame, picture, out=None):
    log = json.load(open(f"{log_folder}/log.json"))
    scene = json.load(open(f"{scene_folder}/scene.json"))
    image = log["images"][int(frame)]
    cam = next(c for c in log["cameras"] if c["name"] == image["camera"])
    w, h = cam["width_px"], cam["height_px"]
    if cam["fx_px"] != cam["fy_px"] or (cam["cx_px"], cam["cy_px"]) != (w / 2, h / 2):
        sys.exit("splat_viewer.py: camera: found another, allowed one focal length and the principal point in the middle")
    rig_r, rig_t = pose_at(log["world_from_rig"], image["time_start_ns"])
    mount = cam["rig_from_camera"]
    world_rotation = rig_r @ rotation(np.array(mount["rotation_wxyz"])[None])[0]
    position = rig_r @ np.array(mount["position_m"]) + rig_t - np.array(scene["origin_m"])
    d = gsply.plyread(ply)
    rgba = rendered_by_viser(d, world_rotation, position, w, h, 2 * np.arctan(h / 2 / cam["fy_px"]))
    background = np.array(scene["camera_set"].get("background", [0, 0, 0]))
    theirs = rgba[..., :3] * rgba[..., 3:] + (1 - rgba[..., 3:]) * background
    ours = np.asarray(Image.open(picture).convert("RGB"), float) / 255
    print(f"viser {viser.__version__}: {len(d.means)} particles, PSNR {-10 * np.log10(np.mean((theirs - ours) ** 2)):.2f} dB")
    if out:
        Image.fromarray(np.round(255 * np.clip(np.concatenate([theirs, ours]), 0, 1)).astype(np.uint8)).save(out)


if __name__ == "__main__":
    if len(sys.argv) not in (6, 7):
        sys.exit(__doc__)
    main(*sys.argv[1:])
