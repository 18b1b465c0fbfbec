"""convert_pcd.py CLOUDS POSES OUT --lidar TABLE [options]: a folder of PCD files and where they were taken, for
`simuli import points OUT -o drive.log`. Needs NumPy alone.

CLOUDS: *.pcd (ascii, binary, binary_compressed), one per sweep. POSES: a line for each pose, either
  time x y z qx qy qz qw      (TUM; seconds) or
  12 numbers, a 3 x 4 matrix  (KITTI; the n-th of the n-th file),
of the LiDAR, or with --mount of the rig that it is mounted on. A file's time is its name: seconds (1700000000.1), whole
microseconds or nanoseconds (16 or 19 digits), or SECONDS_NANOSECONDS; of other names the n-th file has the n-th pose.
Clouds outside the times of the poses are left out. TABLE: `simuli info sensors`, or a file of `simuli fit beams`.

Fields: x y z; intensity (or reflectivity, i), to 1, 255 or 65535, whichever holds the greatest; t, time, timestamp,
time_stamp, offset_time or curvature: when each point was measured, after the sweep's start or since 1970, in s, ms, us or
ns, whichever makes a sweep of --sweep (about 0.1 s). A point belongs to the beam of the nearest elevation, whatever its
ring is called. Points have to be as measured, in the sensor's frame; --deskewed: the vehicle's motion is taken off, as of the file's time.
"""
import argparse
import json
import pathlib
import re
import sys

import numpy as np

from points_folder import Folder, Path, matrix, pose, run, spin, turn_s

INTENSITY = ("intensity", "reflectivity", "i")
TIMES = ("t", "time", "timestamp", "time_stamp", "offset_time", "curvature")
MODEL = ("kind", "columns", "azimuth_first_rad", "azimuth_span_rad", "spin", "range_min_m", "range_max_m",
         "beam_divergence_rad", "divergence_variance", "rows")
UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}


def unpack_lzf(data, size, file):
    """What liblzf packed: runs of bytes, and copies of what stands before."""
    out, at = bytearray(), 0
    while at < len(data):
        control = data[at]
        at += 1
        if control < 32:
            out += data[at:at + control + 1]
            at += control + 1
            continue
        length = control >> 5
        if length == 7:
            length += data[at]
            at += 1
        start = len(out) - ((control & 31) << 8) - data[at] - 1
        at += 1
        if start < 0:
            break
        for i in range(length + 2):  # what is copied may be what this copy writes
            out.append(out[start + i])
    if len(out) != size:
        sys.exit(f"{file}: compressed data: found {len(out)} bytes, allowed {size}")
    return bytes(out)


def read_pcd(file):
    """Columns by name."""
    data = file.read_bytes()
    head, at = {}, 0
    while "DATA" not in head:
        end = data.find(b"\n", at)
        if end < 0 or end > 65536:
            sys.exit(f"{file}: header: found no DATA line, allowed a PCD file")
        words = data[at:end].decode("latin-1").split()
        at = end + 1
        if words and not words[0].startswith("#"):
            head[words[0]] = words[1:]
    try:
        given = head["FIELDS"]
        fields = zip(given, head["TYPE"], head["SIZE"], head.get("COUNT", ["1"] * len(given)), strict=True)
        fields = [(n, f"<{t.lower()}{s}", int(c)) for n, t, s, c in fields if int(c) > 0]  # PCL pads with none of "_"
        count = int(head["POINTS"][0]) if "POINTS" in head else int(head["WIDTH"][0]) * int(head["HEIGHT"][0])
        names, counts = [f[0] for f in fields], [f[2] for f in fields]
        kind = np.dtype([(f"{name}/{i}", t, (n,)) for i, (name, t, n) in enumerate(fields)])
        if not {"x", "y", "z"} <= set(names):
            raise ValueError("no x, y, z")
    except (KeyError, IndexError, TypeError, ValueError) as error:
        sys.exit(f"{file}: header: found {type(error).__name__} {error}, allowed FIELDS with x y z, SIZE, TYPE, "
                 "COUNT and POINTS (or WIDTH and HEIGHT) that fit together")
    need = count * kind.itemsize
    if head["DATA"][0] == "ascii":
        values = np.array(data[at:].split(), float)
        if values.size != count * sum(counts):
            sys.exit(f"{file}: found {values.size} numbers, allowed {count * sum(counts)}")
        firsts = np.cumsum([0] + counts[:-1])
        values = values.reshape(count, sum(counts))
        return {name: values[:, i] for name, i in zip(names, firsts)}
    if head["DATA"][0] == "binary_compressed":  # column by column
        packed, size = np.frombuffer(data, "<u4", 2, at) if len(data) >= at + 8 else (0, 0)
        if size != need:
            sys.exit(f"{file}: found {size} bytes of points, allowed {need}")
        raw, out, at = unpack_lzf(data[at + 8:at + 8 + int(packed)], need, file), {}, 0
        for name, key in zip(names, kind.names):
            part = kind[key].base
            out[name] = np.frombuffer(raw, part, count * kind[key].shape[0], at).reshape(count, -1)[:, 0].astype(float)
            at += count * kind[key].itemsize
        return out
    if len(data) - at < need:
        sys.exit(f"{file}: found {len(data) - at} bytes of points, allowed {need}")
    points = np.frombuffer(data, kind, count, at)
    return {name: points[key][:, 0].astype(float) for name, key in zip(names, kind.names)}


def time_of(stem):
    """ns since 1970 (or since whatever the clock counts from) of a file's name; None: it tells none."""
    if pair := re.fullmatch(r"(\d+)_(\d{1,9})", stem):
        return int(pair[1]) * 1_000_000_000 + int(pair[2])
    if re.fullmatch(r"\d{19}", stem):
        return int(stem)
    if re.fullmatch(r"\d{16}", stem):
        return int(stem) * 1000
    if dotted := re.fullmatch(r"(\d+)\.(\d+)", stem):
        return int(dotted[1]) * 1_000_000_000 + int(dotted[2][:9].ljust(9, "0"))
    return None


def natural(text):
    """Sorts 2 before 10."""
    return [int(part) if part.isdigit() else part for part in re.split(r"([0-9]+)", text)], text


def read_poses(file):
    """Times (ns; None of matrices without any) and poses."""
    rows = [line.split() for line in file.read_text().splitlines() if line.strip() and not line.startswith("#")]
    if rows and all(len(r) == 12 for r in rows):
        return None, [np.vstack([np.array(r, float).reshape(3, 4), [0, 0, 0, 1]]) for r in rows]
    bad = next((i for i, r in enumerate(rows) if len(r) != 8), None)
    if bad is not None or not rows:
        sys.exit(f"{file}: line {(bad or 0) + 1}: found {len(rows[bad]) if rows else 0} numbers, "
                 "allowed 8 (time x y z qx qy qz qw) or 12 (3 x 4)")
    told = [time_of(r[0]) for r in rows]
    times = [t if t is not None else round(float(r[0]) * 1e9) for t, r in zip(told, rows)]
    return times, [matrix([r[7], r[4], r[5], r[6]], [float(v) for v in r[1:4]]) for r in
                   ([float(v) for v in row] for row in rows)]


def unit_of(span, sweep_s):
    """The unit in which a sweep's times span about a sweep."""
    return min(UNITS, key=lambda u: abs(np.log(max(span * UNITS[u], 1e-12) / sweep_s)))


def parse():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("clouds", type=pathlib.Path)
    parser.add_argument("poses", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--lidar", required=True, help="hesai_pandar64 ..., or a .json of simuli fit beams")
    parser.add_argument("--name", default="lidar", help="what it is called in the log")
    parser.add_argument("--mount", help="X,Y,Z,ROLL,PITCH,YAW on the rig, m and degrees")
    parser.add_argument("--sweep", type=float, help="s of a turn; default: what points' times say, else 0.1. Of files "
                        "without times their rhythm, too")
    parser.add_argument("--stamp", choices=("start", "end"), default="start", help="which of a sweep a file's time is")
    parser.add_argument("--columns", type=int, help="firings a turn, if not the table's")
    parser.add_argument("--deskewed", action="store_true")
    return parser.parse_args()


def mounting(text):
    if not text:
        return np.eye(4)
    v = [float(x) for x in text.split(",")]
    if len(v) != 6:
        sys.exit(f"--mount: found {len(v)} numbers, allowed X,Y,Z,ROLL,PITCH,YAW")
    half = np.radians(v[3:]) / 2
    turns = [matrix([np.cos(a), *(np.sin(a) * np.eye(3)[axis])], [0, 0, 0]) for axis, a in enumerate(half)]
    out = turns[2] @ turns[1] @ turns[0]
    out[:3, 3] = v[:3]
    return out


def placed(files, times, poses, sweep_ns):
    """(file, its time) of those that have a pose, and the path; says which have none."""
    stamps = [time_of(f.stem) for f in files]
    if times is None or None in stamps:
        if len(files) > len(poses):
            sys.exit(f"{len(files)} clouds, {len(poses)} poses, and no times in names and poses that tell which is whose")
        if times is None:
            times = stamps if None not in stamps else [i * sweep_ns for i in range(len(files))]
        return list(zip(files, times)), Path(times[:len(files)], poses[:len(files)])
    path = Path(times, poses)
    kept = [(f, t) for f, t in zip(files, stamps) if path.times_ns[0] <= t <= path.times_ns[-1]]
    if len(kept) < len(files):
        print(f"{len(files) - len(kept)} clouds are outside the times of the poses and are left out")
    return kept, path


def sweep_of(files):
    """Seconds of a turn by the points' times of the first cloud that has such; 0.1 where none tells."""
    for file in files[:4]:
        columns = read_pcd(file)
        field = next((k for k in TIMES if k in columns), None)
        good = np.isfinite(columns["x"]) & (np.abs(columns["x"]) + np.abs(columns["y"]) > 0)
        if field is None or (good & np.isfinite(columns[field])).sum() < 100:
            continue
        good &= np.isfinite(columns[field])
        t = columns[field][good] - columns[field][good].min()
        azimuth = np.arctan2(columns["y"][good], columns["x"][good])
        found, agreement = turn_s(azimuth, t * UNITS[unit_of(np.ptp(t), 0.1)])
        if agreement > 0.9 and 0.01 < found < 2 and abs(found - 0.1) > 0.003:
            print(f"a turn in {found:.4f} s, by the points' times")
            return found
        return 0.1
    return 0.1


def main():
    args = parse()
    files = sorted((f for f in args.clouds.iterdir() if f.suffix.lower() == ".pcd"),
                   key=lambda f: (time_of(f.stem) or 0, natural(f.stem)))
    if not files:
        sys.exit(f"{args.clouds}: no *.pcd")
    times, poses = read_poses(args.poses)
    args.sweep = args.sweep or sweep_of(files)
    sweep_ns = round(args.sweep * 1e9)
    kept, path = placed(files, times, poses, sweep_ns)
    if not kept:
        sys.exit("no cloud lies on the path: are names and poses of one clock?")
    first = np.linalg.inv(path.poses[0])
    path = Path(path.times_ns, [first @ m for m in path.poses])
    rig_from_lidar = mounting(args.mount)
    begin_ns = kept[0][1] - (sweep_ns if args.stamp == "end" else 0)
    folder = Folder(args.out, args.out.name, min(int(path.times_ns[0]), begin_ns))
    folder.json["points_in"] = "world" if args.deskewed else "sensor"
    turns, left_out, unit, told = [], 0, None, None
    for file, stamp_ns in kept:
        columns = read_pcd(file)
        xyz = np.stack([columns[k] for k in "xyz"], 1)
        good = np.isfinite(xyz).all(1) & (np.abs(xyz).sum(1) > 0)
        field = next((k for k in TIMES if k in columns), None)
        if field:
            good &= np.isfinite(columns[field])
        left_out += int((~good).sum())
        if not good.any():
            continue
        xyz = xyz[good]
        bright = columns.get(next((k for k in INTENSITY if k in columns), ""), np.zeros(len(good)))[good]
        start_ns = stamp_ns if args.stamp == "start" else stamp_ns - sweep_ns
        time_s = None
        if field:
            t = columns[field][good]
            unit = unit or unit_of(np.ptp(t), args.sweep)
            time_s = (t - (t.min() if abs(t.min()) * UNITS[unit] > 10 * args.sweep else 0)) * UNITS[unit]
            time_s = time_s - min(0.0, time_s.min())  # those of a stamp at the sweep's end are negative
        if told is None:
            told = (max((m for m in (1, 255, 65535) if bright.max(initial=0) > m / 256), default=1), field)
        if field != told[1]:
            sys.exit(f"{file}: times of points: found {field}, allowed {told[1]}, as in the first file")
        if args.deskewed:
            if time_s is None:
                sys.exit("--deskewed: needs a field with the time of each point")
            m = path.at(stamp_ns) @ rig_from_lidar
            xyz = xyz @ m[:3, :3].T + m[:3, 3]
        if time_s is not None:
            own = path.to_sensor(xyz, start_ns + time_s * 1e9, rig_from_lidar) if args.deskewed else xyz
            turns.append(spin(np.arctan2(own[:, 1], own[:, 0]), time_s / args.sweep))
        folder.sweep(args.name, xyz, bright / told[0], time_s, start_ns, start_ns + sweep_ns)
    if told is None:
        sys.exit(f"{args.clouds}: points: found none with a place and a time")
    entry = {"table": args.lidar}
    if args.lidar.endswith(".json"):  # what it is, without what the file says about itself
        table = json.loads(pathlib.Path(args.lidar).read_text())
        entry = {k: v for k, v in table.items() if k in MODEL}
    entry["name"] = args.name
    entry["rig_from_lidar"] = pose(rig_from_lidar)
    if args.columns:
        entry["columns"] = args.columns
    print(f"{len(kept)} clouds; intensity to {told[0]}; " + (f"times of points: {told[1]}, {unit}" if told[1] else
          "no times of points: each has its column's"))
    if turns:
        sign = 1 if sum(t[0] for t in turns) >= 0 else -1
        start = float(np.angle(np.mean([np.exp(1j * t[1]) for t in turns if t[0] == sign])))
        entry.update(azimuth_first_rad=start, spin="counter_clockwise" if sign > 0 else "clockwise")
        print(f"turns {'counter-' if sign > 0 else ''}clockwise from {np.degrees(start):.1f} deg, agreement "
              f"{np.mean([t[2] for t in turns]):.3f}")
    if left_out:
        print(f"{left_out} points without a place or a time are left out")
    folder.json["lidars"].append(entry)
    folder.finish(path)


if __name__ == "__main__":
    run(main)
