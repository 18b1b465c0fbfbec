#!/usr/bin/env python3
"""Are results of `simuli batch` the same however it is run, and whoever is killed meanwhile?

  bench/batch_kills.py PROGRAM [--jobs 200] [--kill-every SECONDS] [--seed N] [--work FOLDER]

A sweep over a car's place and the lane on a street of its own, a camera's pictures and a LiDAR's sweeps each. First one
process makes all, undisturbed. Then 1, 2 and 4 ranks, the same by mpirun where it is installed, and 4 tasks of a job
array: every so often (exponentially, as told) one that is picked at random is killed by SIGKILL, and started again.
(mpirun ends the other ranks with it, so all are.) At last every file is compared with that of the first run, but for the
records (*.job), which hold times. One line per way; exit code 1 where anything is different, or left behind.
"""
import argparse
import hashlib
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


def run(command, folder, **more):
    done = subprocess.run(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **more)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: exit code {done.returncode}: {done.stderr.strip()}")
    return done.stdout


def clean_environment(**more):
    return {**{k: v for k, v in os.environ.items() if not k.startswith(LAUNCHERS)}, **more}


def prepare(program, work, jobs):
    run([program, "synth", "street", "-o", "s.log", "--frames", "8", "--image-width", "160", "--image-height", "90",
         "--lidar-columns", "180"], work)
    run([program, "train", "s.log", "-o", "s.scene", "--iterations", "20", "--set", "init.voxel_m=0.3"], work)
    places = (jobs + 7) // 8
    run([program, "batch", "all.json", "--vary", f"car.move.forward=0:{(places - 1) * 0.1:.1f}:0.1",
         "--vary", "lane_shift=-1:0.75:0.25", "--", "render", "s.scene", "--sensor", "front", "--sensor", "top",
         "--frames", "0:1", "-o", "out/{}"], work)
    lines = (work / "all.json").read_text().splitlines()
    kept = lines[1:1 + jobs]
    (work / "jobs.json").write_text("\n".join([lines[0], *kept[:-1], kept[-1].rstrip(","), "]}"]))
    return len(kept)


def hashes(folder):
    return {str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
            for file in sorted(folder.rglob("*")) if file.is_file() and file.suffix != ".job"}


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


class Rank:
    """A process that is started again until it has done its part."""

    def __init__(self, command, folder, environment):
        self.command, self.folder, self.environment = command, folder, environment
        self.starts, self.process = 0, None
        self.start()

    def start(self):
        self.starts += 1
        self.process = subprocess.Popen(self.command, cwd=self.folder, env=self.environment, stdout=subprocess.PIPE,
                                        stderr=subprocess.DEVNULL, text=True)

    def is_done(self):
        if self.process.poll() is None:
            return False
        if self.process.returncode == 0:
            return True
        self.start()
        return False

    def kill(self):
        """False where it had ended by itself. Of mpirun one of its ranks."""
        victims = children(self.process.pid) if self.command[0] == "mpirun" else [self.process.pid]
        if not victims or self.process.poll() is not None:
            return False
        try:
            os.kill(random.choice(victims), signal.SIGKILL)
        except ProcessLookupError:
            return False
        self.process.wait()
        return self.process.returncode != 0


def disturbed(ranks, every_s):
    """Kills, and seconds until all are done."""
    start, kills, unfinished = time.monotonic(), 0, ranks
    next_kill = start + random.expovariate(1 / every_s)
    while unfinished:
        time.sleep(0.01)
        unfinished = [rank for rank in unfinished if not rank.is_done()]
        if unfinished and time.monotonic() >= next_kill:
            kills += random.choice(unfinished).kill()
            next_kill = time.monotonic() + random.expovariate(1 / every_s)
    return kills, time.monotonic() - start


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=lambda text: str(pathlib.Path(text).resolve()))
    parser.add_argument("--jobs", type=int, default=200)
    parser.add_argument("--kill-every", type=float, default=2.0, help="seconds, on average")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--work", type=pathlib.Path, help="folder to make; default: a temporary one, removed again")
    args = parser.parse_args()
    random.seed(args.seed)
    work = args.work or pathlib.Path(tempfile.mkdtemp(prefix="simuli_batch_"))
    work.mkdir(exist_ok=True)
    batch = [args.program, "batch", "jobs.json"]
    count = prepare(args.program, work, args.jobs)

    start = time.monotonic()
    run(batch, work, env=clean_environment())
    print(f"{count} jobs, undisturbed: {time.monotonic() - start:.1f} s, {len(hashes(work / 'out'))} files", flush=True)
    wanted = hashes(work / "out")
    start = time.monotonic()
    told = run(batch, work, env=clean_environment())
    print(f"again: {time.monotonic() - start:.1f} s, {told.count('done ')} of {count} skipped", flush=True)

    ways = [(f"{n} ranks", [clean_environment(OMPI_COMM_WORLD_RANK=str(r), OMPI_COMM_WORLD_SIZE=str(n))
                            for r in range(n)], batch) for n in (1, 2, 4)]
    ways += [("4 tasks of an array", [clean_environment(
        SLURM_ARRAY_TASK_ID=str(3 + 2 * r), SLURM_ARRAY_TASK_MIN="3", SLURM_ARRAY_TASK_STEP="2",
        SLURM_ARRAY_TASK_COUNT="4") for r in range(4)], batch)]
    if shutil.which("mpirun"):
        alone = clean_environment(OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1",
                                  OMPI_MCA_rmaps_base_oversubscribe="1")
        ways += [(f"mpirun -n {n}", [alone], ["mpirun", "-n", str(n), *batch]) for n in (2, 4)]
    else:
        print("SKIPPED: mpirun, which is not installed")
    is_same = True
    for name, environments, command in ways:
        shutil.rmtree(work / "out")
        ranks = [Rank(command, work, environment) for environment in environments]
        kills, seconds = disturbed(ranks, args.kill_every)
        left = [str(file) for file in work.rglob(".*")]
        found = hashes(work / "out")
        different = [file for file in wanted.keys() | found.keys() if wanted.get(file) != found.get(file)]
        is_same = is_same and not different and not left
        print(f"{name}: {seconds:.1f} s, {kills} killed, {sum(rank.starts for rank in ranks)} starts: "
              f"{len(wanted) - len(different)} of {len(wanted)} files the same, {len(left)} left behind", flush=True)
        for file in [*different, *left][:10]:
            print("  " + file)
    if args.work is None:
        shutil.rmtree(work)
    return 0 if is_same else 1


if __name__ == "__main__":
    sys.exit(main())
