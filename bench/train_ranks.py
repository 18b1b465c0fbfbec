#!/usr/bin/env python3
"""Checks that a training is independent of the number of ranks and of killed ranks, and measures the gain of ranks.

  bench/train_ranks.py PROGRAM [hashes] [speed] [kills] [rates] [--kills 20] [--runs 5] [--seed N] [--work FOLDER]
                       [--picture 160x90] [--columns 360]

Uses the embedded street and mpirun (oversubscribed); each rank has one thread of PoCL. Runs all parts unless some are named:
  hashes  the scenes of 1, 2 and 4 ranks with 4 shards, and of one process with two devices: SHA-256 of all files
  speed   1 and 2 ranks in turns, and two separate concurrent trainings: minimum seconds of several runs, and the data
          exchanged between ranks per step
  kills   kills a rank by SIGKILL at a random time and resumes with a random number of ranks, until the training is
          finished: the files must equal those of the undisturbed run
  rates   the same number of frames in steps of 1, 2 and 4, with unchanged learning rates, scaled by the root, and by the number
Exit code 1 if bits differ.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

LAUNCHERS = ("OMPI_", "PMI_", "PMIX_", "SLURM_")
ENVIRONMENT = dict(
    {name: value for name, value in os.environ.items() if not name.startswith(LAUNCHERS)},
    OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1", OMPI_MCA_rmaps_base_oversubscribe="1",
    OMPI_MCA_btl_vader_single_copy_mechanism="none", POCL_MAX_PTHREAD_COUNT="1")


def launched(ranks, command):
    return ["mpirun", "-n", str(ranks), *command] if ranks > 1 else command


def run(command, folder, **more):
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                          env={**ENVIRONMENT, **more})
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: exit code {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def children(pid):
    found = []
    for status in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = status.read_text().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == pid:
            found.append(int(status.parent.name))
    return found


def scene_hash(scene):
    total = hashlib.sha256()
    for file in sorted(scene.rglob("*")):
        if file.is_file():
            total.update(str(file.relative_to(scene)).encode() + b"\0" + file.read_bytes())
    return total.hexdigest()[:16]


def train(args, ranks, name, *options, **environment):
    """Returns the JSON report of the training and the hash of its scene."""
    command = [args.program, "--json", "train", "s.log", "-o", name, "--overwrite", "--set", "init.voxel_m=0.2", *options]
    report = json.loads(run(launched(ranks, command), args.work, **environment))
    return report, scene_hash(args.work / name)


def hashes(args):
    options = ["--iterations", "60", "--set", "shards=4", "--set", "densify.epochs=1.5",
               "--set", "color_grids=pictures", "--set", "actors.track.learn=true"]
    found = {}
    for ranks in (1, 2, 4):
        report, found[f"{ranks} ranks"] = train(args, ranks, f"h{ranks}.scene", *options)
        print(f"{ranks} ranks: {found[f'{ranks} ranks']}, {report['train_psnr_db']:.3f} dB", flush=True)
    # Two devices of one process give equal bits if the driver's copies are equal.
    _, found["2 devices"] = train(args, 1, "hd.scene", "--device", "0,1", *options, POCL_DEVICES="pthread pthread")
    print(f"2 devices of one process: {found['2 devices']}", flush=True)
    return len(set(found.values())) == 1


def speed(args):
    options = ["--iterations", "120", "--set", "shards=4"]
    seconds, apart = {1: [], 2: []}, []
    for _ in range(args.runs):
        for ranks in seconds:
            report, _ = train(args, ranks, "t.scene", *options)
            seconds[ranks].append(report["seconds"])
        # Two separate trainings on one machine: the lower bound of two ranks.
        with concurrent.futures.ThreadPoolExecutor(2) as both:
            apart.append(max(report["seconds"] for report, _ in
                             both.map(lambda k: train(args, 1, f"apart{k}.scene", *options), range(2))))
    gathered = report["gathered_bytes"] / report["iterations"]
    least = {ranks: min(times) for ranks, times in seconds.items()}
    print(f"training alone, least of {args.runs}: 1 rank {least[1]:.2f} s, 2 ranks {least[2]:.2f} s: "
          f"{least[1] / least[2]:.2f} times as fast; two trainings apart {min(apart):.2f} s: "
          f"{2.0 * least[1] / min(apart):.2f} times one after the other; {gathered / 1e6:.2f} MB gathered a step "
          f"({report['camera_particles']} + {report['lidar_particles']} particles)", flush=True)
    print("  all: " + "; ".join(f"{r} ranks " + ", ".join(f"{s:.2f}" for s in t) for r, t in seconds.items()) +
          "; apart " + ", ".join(f"{s:.2f}" for s in apart))
    return True


def kills(args):
    options = ["--iterations", "60", "--set", "shards=4", "--checkpoint-every", "5",
               "--set", "densify.epochs=1.5"]
    start = time.monotonic()
    _, wanted = train(args, 1, "whole.scene", *options)
    duration = time.monotonic() - start
    print(f"undisturbed: {wanted}, {duration:.1f} s", flush=True)
    killed, scenes, is_same, started, last = 0, 0, True, [], None
    while killed < args.kills:
        for path in args.work.glob("killed.scene*"):
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        while True:
            ranks = random.choice([r for r in (1, 2, 4) if r != last])  # always another number
            last = ranks
            started.append(ranks)
            command = launched(ranks, [args.program, "train", "s.log", "-o", "killed.scene", "--resume", "--set",
                                       "init.voxel_m=0.2", *options])
            process = subprocess.Popen(command, cwd=args.work, env=ENVIRONMENT, stdout=subprocess.DEVNULL,
                                       stderr=subprocess.DEVNULL)
            if killed < args.kills:
                try:
                    process.wait(random.uniform(0.2, 0.9) * duration)
                except subprocess.TimeoutExpired:
                    victims = children(process.pid) if ranks > 1 else [process.pid]
                    if victims:
                        os.kill(random.choice(victims), signal.SIGKILL)
                        killed += 1
            if process.wait() == 0:
                break
        scenes += 1
        found = scene_hash(args.work / "killed.scene")
        is_same = is_same and found == wanted
        print(f"{killed} killed, {scenes} scenes: {found}", flush=True)
    print(f"{killed} killed, {len(started)} starts by {' '.join(map(str, started))} ranks, {scenes} scenes: "
          f"{'all the same' if is_same else 'DIFFERENT'}")
    return is_same


def rates(args):
    frames = 400
    for shards in (1, 2, 4):
        scores = []
        for seed in (1, 2):
            train(args, 1, "r.scene", "--iterations", str(frames // shards), "--seed", str(seed), "--set",
                  f"shards={shards}", POCL_MAX_PTHREAD_COUNT="2")
            report = json.loads(run([args.program, "--json", "eval", "r.scene", "s.log"], args.work,
                                  POCL_MAX_PTHREAD_COUNT="2"))
            scores.append((report["psnr_db"], report["ssim"], 100 * report["distance_median_m"], report["raydrop_accuracy"]))
        mean = [sum(values) / len(scores) for values in zip(*scores)]
        print(f"| {shards} | {frames // shards} | {mean[0]:.2f} | {mean[1]:.4f} | {mean[2]:.2f} | "
              f"{100 * mean[3]:.2f} | {abs(scores[0][0] - scores[1][0]):.2f} dB |", flush=True)
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda text: str(pathlib.Path(text).resolve()))
    parts = {"hashes": hashes, "speed": speed, "kills": kills, "rates": rates}
    parser.add_argument("parts", nargs="*", choices=[[], *parts], default=[])
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--picture", default="160x90", help="of the street's camera, px")
    parser.add_argument("--columns", type=int, default=360, help="of its LiDAR")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--work", type=pathlib.Path, help="folder to write; default: a temporary folder")
    args = parser.parse_args()
    if shutil.which("mpirun") is None:
        sys.exit("train_ranks.py: mpirun: found none, allowed one that is installed (openmpi-bin)")
    random.seed(args.seed)
    is_kept = args.work is not None
    args.work = args.work or pathlib.Path(tempfile.mkdtemp(prefix="simuli_ranks_"))
    args.work.mkdir(exist_ok=True)
    if not (args.work / "s.log").exists():
        width, height = args.picture.split("x")
        run([args.program, "synth", "street", "-o", "s.log", "--frames", "20", "--image-width", width, "--image-height",
             height, "--lidar-columns", str(args.columns)], args.work)
    is_same = all([parts[part](args) for part in args.parts or parts])
    if not is_kept:
        shutil.rmtree(args.work)
    return 0 if is_same else 1


if __name__ == "__main__":
    sys.exit(main())
