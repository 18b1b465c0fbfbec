"""A small trained drive and its particles, for the tests of exports: what they have in common."""
import pathlib
import subprocess

import numpy as np

AT_S = 0.3


def run(*words):
    subprocess.run([str(w) for w in words], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def scene(simuli, work):
    run(simuli, "synth", "street", "-o", work / "street.log", "--frames", 4, "--image-width", 64, "--image-height", 36,
        "--lidar-columns", 90)
    run(simuli, "train", work / "street.log", "-o", work / "street.scene", "--iterations", 2)
    return work / "street.scene"


def particles(ply):
    """Columns of a 3DGS PLY by name."""
    data = pathlib.Path(ply).read_bytes()
    head, body = data.split(b"end_header\n", 1)
    names = [line.split()[-1].decode() for line in head.splitlines() if line.startswith(b"property float")]
    rows = np.frombuffer(body, "<f4").reshape(-1, len(names))
    return {name: rows[:, i] for i, name in enumerate(names)}


def coefficients(p):
    """[N, K, 3]: f_rest is channel after channel."""
    rest = sorted((n for n in p if n.startswith("f_rest_")), key=lambda n: int(n[7:]))
    first = np.stack([p[f"f_dc_{c}"] for c in range(3)], 1)[:, None]
    more = np.stack([p[n] for n in rest], 1).reshape(len(first), 3, -1).transpose(0, 2, 1)
    return np.concatenate([first, more], 1)


def basis(d):
    """[M, 16] real spherical harmonics with the Condon-Shortley phase, in the order of KHR_gaussian_splatting."""
    x, y, z = d.T
    one = np.ones_like(x)
    return np.stack([
        0.28209479177387814 * one,
        -0.4886025119029199 * y, 0.4886025119029199 * z, -0.4886025119029199 * x,
        1.0925484305920792 * x * y, -1.0925484305920792 * y * z, 0.31539156525252 * (2 * z * z - x * x - y * y),
        -1.0925484305920792 * x * z, 0.5462742152960396 * (x * x - y * y),
        -0.5900435899266435 * y * (3 * x * x - y * y), 2.890611442640554 * x * y * z,
        -0.4570457994644657 * y * (4 * z * z - x * x - y * y),
        0.3731763325901154 * z * (2 * z * z - 3 * x * x - 3 * y * y),
        -0.4570457994644657 * x * (4 * z * z - x * x - y * y), 1.445305721320277 * z * (x * x - y * y),
        -0.5900435899266435 * x * (x * x - 3 * y * y)], 1)


def matrices(wxyz):
    """[N, 3, 3] of rotations that need not have length 1."""
    w, x, y, z = (wxyz / np.linalg.norm(wxyz, axis=1, keepdims=True)).T
    return np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y), 2 * (x * y + w * z),
                     1 - 2 * (x * x + z * z), 2 * (y * z - w * x), 2 * (x * z - w * y), 2 * (y * z + w * x),
                     1 - 2 * (x * x + y * y)], 1).reshape(-1, 3, 3)


def compare(p, axes, position, wxyz, scale, opacity, sh):
    """That what a file holds is the scene: `axes` takes the scene's axes to the file's."""
    own = np.stack([p["x"], p["y"], p["z"]], 1)
    assert np.array_equal(position, own @ axes.T.astype(np.float32)), "positions"
    logs = np.stack([p[f"scale_{i}"] for i in range(3)], 1)
    assert np.allclose(scale, np.exp(logs), rtol=1e-5), "scales"
    assert np.allclose(opacity, 1 / (1 + np.exp(-p["opacity"])), atol=1e-6), "opacities"
    turned = axes @ matrices(np.stack([p[f"rot_{i}"] for i in range(4)], 1))
    assert np.allclose(np.linalg.norm(wxyz, axis=1), 1, atol=1e-5), "unit quaternions"
    assert np.allclose(matrices(wxyz), turned, atol=1e-5), "rotations"
    d = np.random.default_rng(1).normal(size=(40, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    ours = coefficients(p)
    at_first, at_turned = basis(d)[:, :ours.shape[1]], basis(d @ axes.T)[:, :ours.shape[1]]
    assert sh.shape == ours.shape, (sh.shape, ours.shape)
    assert np.allclose(np.einsum("mk,nkc->nmc", at_turned, sh), np.einsum("mk,nkc->nmc", at_first, ours),
                       atol=1e-4), "colours"
