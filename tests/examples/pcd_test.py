"""Made-up folders of PCD files through their converter: pcd_test.py SIMULI EXAMPLES WORK"""
import json
import pathlib
import struct
import subprocess
import sys

import numpy as np

simuli, examples, work = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
sys.path.insert(0, str(examples))
import points_folder as pf  # noqa: E402

START_NS, TURNS, ROOM_M, RAYS, TABLE = 1_600_000_000_000_000_000, 3, 12.0, 1800, "velodyne_vlp16"
model = json.loads(subprocess.run([simuli, "info", TABLE, "--json"], check=True, text=True, capture_output=True).stdout)
MOUNT = pf.matrix([np.cos(0.3), 0, 0, np.sin(0.3)], [1.0, -0.2, 1.8])
(work / "table.json").write_text(json.dumps(model))


def path():
    """10 m/s ahead, from somewhere, at 50 ms."""
    times = [START_NS + i * 50_000_000 for i in range(2 * TURNS + 1)]
    far = pf.matrix([np.cos(0.4), 0, 0, np.sin(0.4)], [100, -50, 3])
    return times, [far @ pf.matrix([1, 0, 0, 0], [0.5 * i, 0, 0]) for i in range(len(times))]


def turn(start_ns, mount):
    """A turn in a round room about the origin of the first pose: points as measured, their times (s)."""
    times, poses = path()
    first = np.linalg.inv(poses[0])
    drive = pf.Path(times, [first @ m for m in poses])
    row, column = np.meshgrid(np.arange(len(model["rows"])), np.arange(RAYS), indexing="ij")
    elevation = np.array([r["elevation_rad"] for r in model["rows"]])[row.ravel()]
    azimuth = 0.7 - 2 * np.pi * (column.ravel() + 0.5) / RAYS  # clockwise
    ray = np.stack([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)], 1)
    time_s = (column.ravel() + 0.5) / RAYS * 0.1
    points = np.empty_like(ray)
    for c in range(RAYS):
        m = drive.at(start_ns + (c + 0.5) / RAYS * 1e8) @ mount
        own = column.ravel() == c
        d, o = ray[own] @ m[:3, :3].T, m[:3, 3]
        a, b = (d[:, :2] ** 2).sum(1), d[:, :2] @ o[:2]
        points[own] = ray[own] * ((-b + np.sqrt(b * b + a * (ROOM_M**2 - o[:2] @ o[:2]))) / a)[:, None]
    return points, time_s


def pack_lzf(data):
    """Runs of bytes, and for a value that stands four bytes before, as one copy."""
    out, at = bytearray(), 0
    while at < len(data):
        length = 0
        while at >= 4 and length < 264 and at + length < len(data) and data[at + length] == data[at + length - 4]:
            length += 1
        if length >= 9:
            out += bytes([7 << 5, length - 9, 3])
            at += length
        else:
            out += bytes([0, data[at]])
            at += 1
    return bytes(out)


def write_pcd(file, how, fields):
    """`fields`: name -> (type, values); a field of three padding bytes stands in the middle, as PCL writes them."""
    count = len(fields["x"][1])
    items = [(n, np.dtype(t), v) for n, (t, v) in fields.items()]
    items.insert(3, ("_", np.dtype("u1"), np.zeros((count, 3))))
    letter = {"f": "F", "u": "U", "i": "I"}
    head = ("# .PCD v0.7\nVERSION 0.7\nFIELDS " + " ".join(n for n, _, _ in items) + "\nSIZE "
            + " ".join(str(t.itemsize) for _, t, _ in items) + "\nTYPE " + " ".join(letter[t.kind] for _, t, _ in items)
            + "\nCOUNT " + " ".join(str(np.asarray(v)[0].size) for _, _, v in items)
            + f"\nWIDTH {count}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {count}\nDATA {how}\n").encode()
    if how == "ascii":
        table = np.column_stack([np.asarray(v, float).reshape(count, -1) for _, _, v in items])
        body = "\n".join(" ".join(f"{x:.9g}" for x in r) for r in table).encode() + b"\n"
    elif how == "binary":
        record = np.zeros(count, [(n, t, np.asarray(v)[0].shape) for n, t, v in items])
        for n, _, v in items:
            record[n] = v
        body = record.tobytes()
    else:
        raw = b"".join(np.asarray(v).astype(t).tobytes() for _, t, v in items)
        packed = pack_lzf(raw)
        body = struct.pack("<II", len(packed), len(raw)) + packed
    file.write_bytes(head + body)


def convert(*arguments):
    return subprocess.run([sys.executable, examples / "convert_pcd.py", *map(str, arguments)], text=True,
                          capture_output=True)


def imported(folder, log):
    run = subprocess.run([simuli, "import", "points", folder, "-o", log], text=True, capture_output=True)
    assert run.returncode == 0, run.stderr
    words = [w for w in run.stderr.replace(",", "").split() if w.isdigit()]
    said = dict(zip(("points", "unplaced", "echoes", "returned", "rays"), map(int, words[-5:])))
    return said, json.loads((log / "log.json").read_text())


def check(name, clouds, poses, *options, mount=np.eye(4), turns=TURNS):
    run = convert(clouds, poses, work / name, "--name", "top", *options)
    assert run.returncode == 0, run.stderr
    said, log = imported(work / name, work / f"{name}.log")
    assert said["points"] == turns * RAYS * 16 and said["unplaced"] == 0, said
    assert said["returned"] > 0.999 * said["points"], said
    assert len(log["sweeps"]) == turns and log["lidars"][0]["name"] == "top"
    assert np.allclose(log["lidars"][0]["rig_from_lidar"]["position_m"], mount[:3, 3], atol=1e-9)
    first, second = (np.array(p["position_m"]) for p in log["world_from_rig"][:2])
    assert np.allclose(first, 0, atol=1e-6), first
    return run.stdout, log, second - first


# Points' times tell how long a turn takes, also of a part of it.
for seconds, part in ((0.05, 1.0), (0.1, 0.3), (0.2, 1.0)):
    share = np.arange(0.0, part, 1e-3)
    found, agreement = pf.turn_s(np.angle(np.exp(1j * (0.7 - 2 * np.pi * share))), share * seconds)
    assert abs(found - seconds) < 1e-3 * seconds and agreement > 0.999, (seconds, found, agreement)

times, poses = path()
tum, kitti = work / "poses.txt", work / "kitti.txt"
tum.write_text("# time x y z qx qy qz qw\n" + "".join(
    f"{t // 10**9}.{t % 10**9:09} {m[0, 3]} {m[1, 3]} {m[2, 3]} {q[1]} {q[2]} {q[3]} {q[0]}\n"
    for t, m, q in ((t, m, pf.quaternion(m)) for t, m in zip(times, poses))))
kitti.write_text("".join(" ".join(map(str, m[:3].ravel())) + "\n" for m in poses[::2]))

timed, bare, flat = work / "timed", work / "bare", work / "deskewed"
for folder in (timed, bare, flat):
    folder.mkdir()
hows = ["ascii", "binary", "binary_compressed"]
for i in range(TURNS):
    start_ns = START_NS + i * 100_000_000
    xyz, time_s = turn(start_ns, MOUNT)
    axes = {k: ("f4", xyz[:, j]) for j, k in enumerate("xyz")}
    write_pcd(timed / f"{start_ns // 10**9}_{start_ns % 10**9}.pcd", hows[i],
              {**axes, "intensity": ("f4", np.full(len(xyz), 51.0)), "t": ("u4", time_s * 1e9)})
    drive = pf.Path(times, poses)
    here = drive.at(start_ns) @ MOUNT
    moved = np.empty_like(xyz)
    for step in np.unique(time_s):
        m = np.linalg.inv(here) @ drive.at(start_ns + step * 1e9) @ MOUNT
        moved[time_s == step] = xyz[time_s == step] @ m[:3, :3].T + m[:3, 3]
    write_pcd(flat / f"{start_ns}.pcd", "binary", {
        **{k: ("f4", moved[:, j]) for j, k in enumerate("xyz")}, "timestamp": ("f8", start_ns * 1e-9 + time_s)})
    xyz, _ = turn(start_ns, np.eye(4))
    lost = np.vstack([xyz, [[np.nan] * 3, [0, 0, 0]]])
    write_pcd(bare / f"{i:06}.pcd", "binary", {k: ("f4", lost[:, j]) for j, k in enumerate("xyz")})

mount = "1,-0.2,1.8,0,0,34.37746770784939"
said, log, step = check("a", timed, tum, "--lidar", TABLE, "--columns", RAYS, "--mount", mount, mount=MOUNT)
assert "intensity to 255; times of points: t, ns" in said and "turns clockwise from 40.1 deg" in said, said
assert np.allclose(step, [0.5, 0, 0], atol=1e-5), step
assert log["lidars"][0]["spin"] == "clockwise"
# The file of a table, times since 1970, the vehicle's motion taken off.
said, _, _ = check("b", flat, tum, "--lidar", work / "table.json", "--columns", RAYS, "--mount", mount, "--deskewed",
                   mount=MOUNT)
assert "intensity to 1; times of points: timestamp, s" in said and "agreement 1.000" in said, said
# Neither times nor intensities; the poses of the LiDAR itself, one for each file.
said, _, step = check("c", bare, kitti, "--lidar", TABLE, "--columns", RAYS)
assert "no times of points" in said and f"{2 * TURNS} points without a place" in said, said
assert np.allclose(step, [1.0, 0, 0], atol=1e-5), step
# Clouds without a pose are told; what fits nothing is refused in a line.
short = work / "short.txt"
short.write_text("\n".join(tum.read_text().splitlines()[:4]) + "\n")
said, _, _ = check("d", timed, short, "--lidar", TABLE, "--columns", RAYS, "--mount", mount, mount=MOUNT, turns=2)
assert "1 clouds are outside the times of the poses and are left out" in said, said

# Clouds called 8 to 12 have their poses in that order; padding of no bytes is no field, without POINTS the size is
# WIDTH x HEIGHT; a point whose time is NaN is left out.
plain = work / "plain"
plain.mkdir()
for i, number in enumerate((8, 9, 10, 11, 12)):
    cloud = plain / f"{number}.pcd"
    write_pcd(cloud, "binary", {"x": ("f4", np.full(4, i + 1.0)), "y": ("f4", np.ones(4)), "z": ("f4", np.zeros(4)),
                                "t": ("f4", [0.0, 0.05, 0.0999, np.nan])})
    bytes_ = cloud.read_bytes()
    if number == 9:
        bytes_ = bytes_.replace(b"POINTS 4\n", b"")
    if number == 10:
        padded, at = bytearray(), bytes_.index(b"binary\n") + 7
        for k in range(4):  # without the three bytes behind x y z
            padded += bytes_[at + 19 * k:at + 19 * k + 12] + bytes_[at + 19 * k + 15:at + 19 * (k + 1)]
        bytes_ = bytes_[:at].replace(b"COUNT 1 1 1 3", b"COUNT 1 1 1 0") + bytes(padded)
    cloud.write_bytes(bytes_)
ahead = work / "ahead.txt"
ahead.write_text("".join(f"1 0 0 {i} 0 1 0 0 0 0 1 0\n" for i in range(5)))
run = convert(plain, ahead, work / "plain_out", "--lidar", TABLE)
assert run.returncode == 0 and "5 points without a place or a time" in run.stdout, (run.stdout, run.stderr)
write_pcd(plain / "13.pcd", "binary", {"x": ("f4", [1.0]), "y": ("f4", [1.0]), "z": ("f4", [0.0]), "t": ("f4", [np.nan])})
ahead.write_text(ahead.read_text() + "1 0 0 5 0 1 0 0 0 0 1 0\n")
run = convert(plain, ahead, work / "plain_out_6", "--lidar", TABLE)
assert run.returncode == 0 and "6 points without a place or a time" in run.stdout, (run.stdout, run.stderr)
order = [np.fromfile(f, "<f4")[0] for f in sorted((work / "plain_out").rglob("*.bin"))]
assert order == [1, 2, 3, 4, 5], order


def refuse(word, *arguments):
    run = convert(*arguments, "--lidar", TABLE)
    assert run.returncode == 1 and word in run.stderr and run.stderr.count("\n") == 1, (word, run.stderr)
    assert not (work / "x").exists() and not list(work.glob(".*")), word


refuse("nowhere", work / "nowhere", kitti, work / "x")
refuse("nowhere.txt", bare, work / "nowhere.txt", work / "x")
(bare / "y.txt").write_text("1 0 0 a 0 1 0 0 0 0 1 0\n")
refuse("'a'", bare, bare / "y.txt", work / "x")
refuse("'six'", bare, kitti, work / "x", "--mount", "1,2,3,4,5,six")
refuse("found something of that name", bare, kitti, work / "a")
refuse("found 3 numbers", bare, bare / "x.txt" if (bare / "x.txt").write_text("1 2 3\n") else "", work / "x")
refuse("3 clouds, 1 poses", bare, short if short.write_text(kitti.read_text().split("\n")[0] + "\n") else "", work / "x")
(bare / "000001.pcd").write_bytes((bare / "000001.pcd").read_bytes()[:-5])
refuse("000001.pcd: found", bare, kitti, work / "x")
(bare / "000001.pcd").write_bytes(b"ply\n")
refuse("found no DATA line", bare, kitti, work / "x")
(bare / "000001.pcd").write_bytes(b"FIELDS x y\nSIZE 4 4\nTYPE F F\nPOINTS 0\nDATA ascii\n")
refuse("000001.pcd: header: found ValueError no x, y, z", bare, kitti, work / "x")
