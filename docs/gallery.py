"""gallery.py SIMULI WORK: runs the commands of GALLERY.md in the folder WORK and makes docs/gallery/*.jpg of what they write.

Needs NumPy and Pillow (Debian: python3-numpy python3-pil). What a command has written before is not made again: -o FOLDER that is there.
"""
import os
import pathlib
import re
import subprocess
import sys

import numpy as np
from PIL import Image

from pages import commands_of

DOCS = pathlib.Path(__file__).resolve().parent
FRAME = "000009"
WIDE, HALF, THIRD = (640, 360), (480, 270), (400, 225)
# From near, low, none to far, high, full.
SCALE = np.array([(255, 247, 214), (254, 196, 79), (217, 95, 14), (152, 52, 102), (69, 40, 120), (20, 22, 60)], float)


def coloured(values, low, high):
    """RGB of values in [low, high]; NaN is black."""
    place = np.clip((values - low) / (high - low), 0, 1) * (len(SCALE) - 1)
    rgb = np.stack([np.interp(place, np.arange(len(SCALE)), SCALE[:, c]) for c in range(3)], -1)
    return np.where(np.isnan(values)[..., None], 0, rgb)


def picture(array):
    return Image.fromarray(np.clip(array, 0, 255).astype(np.uint8))


def photo(file, size=WIDE):
    return Image.open(file).convert("RGB").resize(size, Image.Resampling.LANCZOS)


def beside(*pictures):
    gap = 6
    out = Image.new("RGB", (sum(p.width for p in pictures) + gap * (len(pictures) - 1), pictures[0].height), "white")
    at = 0
    for one in pictures:
        out.paste(one, (at, 0))
        at += one.width + gap
    return out


def above(file, radius_m=32.0, size=WIDE):
    """A cloud from above, forward to the right, coloured by height; actors orange."""
    cloud = np.load(file)
    xyz = cloud["xyz"]
    scale = size[0] / (2 * radius_m)
    # Of points on one pixel the highest is seen.
    order = np.argsort(xyz[:, 2])
    xyz = xyz[order]
    column = np.round(size[0] / 2 + xyz[:, 0] * scale).astype(int)
    row = np.round(size[1] / 2 - xyz[:, 1] * scale).astype(int)
    inside = (column >= 0) & (column < size[0]) & (row >= 0) & (row < size[1])
    rgb = coloured(-xyz[:, 2], -3.0, 3.5)
    if "actor" in cloud:
        rgb[cloud["actor"][order] > 0] = (255, 90, 0)
    out = np.full((size[1] + 1, size[0] + 1, 3), 16.0)
    for down, right in ((0, 0), (0, 1), (1, 0), (1, 1)):
        out[row[inside] + down, column[inside] + right] = rgb[inside]
    return picture(out[:-1, :-1])


def outputs():
    return np.load(f"outputs/front_{FRAME}.npz")


def depth():
    metres = outputs()["depth"]
    return picture(coloured(np.log(np.where(metres > 0, metres, np.nan)), np.log(4), np.log(120)))


def normals():
    n = outputs()["normals"]
    return picture(np.where((n != 0).any(-1, keepdims=True), 127.5 + 127.5 * n * (1, -1, -1), 0))


def actors():
    mask = outputs()["actors"][..., None] > 0
    return picture(np.where(mask, np.array((255, 140, 0)), 0.35 * np.asarray(photo(f"outputs/front_{FRAME}.png"))))


def known():
    opacity = np.load(f"fisheye/tum_vi_cam0_{FRAME}.npz")["opacity"]
    return picture(np.repeat(255 * opacity[..., None], 3, -1)).resize((400, 400), Image.Resampling.LANCZOS)


def front(folder):
    return lambda: photo(f"{folder}/front_{FRAME}.png")


def beside_truth(folder, log):
    return lambda: beside(photo(f"{folder}/front_{FRAME}.png", HALF), photo(f"{log}/images/front_{FRAME}.png", HALF))


def lidar():
    return Image.open("demo/lidar_range.png").convert("RGB")


PICTURES = {
    "camera": beside_truth("outputs", "demo/street.log"),
    "depth": depth,
    "normals": normals,
    "actors": actors,
    "lidar": lidar,
    "above": lambda: above(f"cloud/top_{FRAME}.npz"),
    "pandar": lambda: above(f"pandar/hesai_pandar128_{FRAME}.npz"),
    "fisheye": lambda: beside(photo(f"fisheye/tum_vi_cam0_{FRAME}.png", (400, 400)), known()),
    "rolling": lambda: beside(photo("rolling/rolling_000000.png", HALF), photo("frozen/front_000000.png", HALF)),
    "shift": lambda: beside(photo(f"shift_alone/front_{FRAME}.png", THIRD), photo(f"shift/front_{FRAME}.png", THIRD),
                            photo(f"shifted.log/images/front_{FRAME}.png", THIRD)),
    "removed": front("removed"),
    "twin": front("twin"),
    "turned": front("turned"),
    "cone": front("cone"),
    "wide": lambda: photo(f"wide/front_{FRAME}.png"),
}


def main(simuli, work):
    page = DOCS / "GALLERY.md"
    shown = re.findall(r"\(gallery/(\w+)\.jpg\)", page.read_text())
    assert sorted(shown) == sorted(PICTURES), set(shown) ^ set(PICTURES)
    bin_folder = pathlib.Path(work) / ".bin"
    bin_folder.mkdir(parents=True, exist_ok=True)
    link = bin_folder / "simuli"
    link.unlink(missing_ok=True)
    link.symlink_to(pathlib.Path(simuli).resolve())
    os.environ["PATH"] = f"{bin_folder.resolve()}:{os.environ['PATH']}"
    os.environ["EXAMPLES"] = str(DOCS.parent / "examples")
    os.chdir(work)
    for command in commands_of(page):
        output = re.search(r"(?:-o|>) (\S+)", command)
        if output and pathlib.Path(output[1]).exists():
            continue
        print("+", command, flush=True)
        subprocess.run(command, shell=True, check=True)
    (DOCS / "gallery").mkdir(exist_ok=True)
    for name, make in PICTURES.items():
        make().save(DOCS / "gallery" / f"{name}.jpg", quality=84, optimize=True, progressive=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
