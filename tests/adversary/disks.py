"""Disks without room, and outputs that can't be what was asked for."""

from __future__ import annotations

import os
import resource
import shutil
import stat
import subprocess
import time
from functools import cache
from pathlib import Path

from harness import INPUT, SMALL, USAGE, Outcome, Skip, Trial, case, content_of, difference, remove, shown
from interruptions import TRAINING, command_lines

# Mounts a disk of $1 bytes at $2, copies $3 there when it is named, runs the rest, lists what is left to $LEFT.
ON_SMALL_DISK = """
mount -t tmpfs -o size=$1 none "$2" && if [ -n "$3" ]; then cp -r "$3" "$2/$4"; fi || exit 99
at=$2; shift 4; "$@"; code=$?; cd "$at" && find . -mindepth 1 -exec sha256sum {} + > "$LEFT" 2>/dev/null; exit $code
"""


@cache
def may_mount() -> bool:
    if os.geteuid() != 0 or shutil.which("unshare") is None:
        return False
    probe = ["unshare", "-m", "sh", "-c", "mount -t tmpfs none /mnt"]
    return subprocess.run(probe, capture_output=True, check=False).returncode == 0


def on_small_disk(
    trial: Trial, size: int, arguments: list[str], old: str = "", name: str = ""
) -> tuple[Outcome, str]:
    """The end of a run whose output is on a disk of its own, and the checksums of what it leaves there."""
    disk, left = trial.folder / "disk", trial.top / "left.txt"
    disk.mkdir(exist_ok=True)
    left.write_text("")
    before = ["unshare", "-m", "sh", "-c", ON_SMALL_DISK, "sh", str(size), str(disk), old, name]
    began = time.monotonic()
    outcome = trial.wait(trial.start(["--json", *arguments], {"LEFT": str(left)}, before=before), began)
    return outcome, left.read_text()


def size_of(path: Path) -> int:
    files = [path] if path.is_file() else [p for p in path.rglob("*") if p.is_file()]
    return sum((p.stat().st_size + 4095) // 4096 * 4096 for p in files)


def onto(arguments: list[str], output: str, place: str) -> list[str]:
    return [f"{place}/{output}" if a == output else a for a in arguments]


def check_full(trial: Trial, told: str, outcome: Outcome, left: str, old: str = "") -> None:
    wrong = trial.wrong_words(outcome) if outcome.code != 0 else []
    if outcome.code not in (0, INPUT):
        wrong.append("wrong end")
    if outcome.code != 0 and left.strip() != old.strip():
        wrong.append(f"left there: {left.split()[1::2]}")
    trial.check(not wrong, f"{told}: {'; '.join(wrong)}: {outcome.told()}")


@case("full disk, every command")
def full_disk(trial: Trial) -> None:
    if not may_mount():
        raise Skip("needs root, to mount a small disk")
    commands = command_lines(trial)
    kept = [path.name for path in trial.folder.iterdir()]
    commands.pop("train again")
    for name, (arguments, output) in commands.items():
        trial.works(*arguments)
        size = size_of(trial.folder / output)
        trial.clear(*kept)
        sizes = [4096] + [trial.random.randrange(4096, max(size, 8192)) for _ in range(trial.tries)]
        for most in sizes:
            outcome, left = on_small_disk(trial, most, onto(arguments, output, "disk"))
            check_full(trial, f"{name}, {size} bytes on a disk of {most}", outcome, left)
    # A report beside a training that has room; a checkpoint; retraining over an old scene.
    for _ in range(trial.tries):
        trial.clear(*kept)
        size = size_of(trial.folder / "s.scene")
        most = trial.random.randrange(size + 4096, 2 * size)
        again = ["train", "s.log", "-o", "disk/s.scene", "--iterations", "20", "--seed", "2", "--overwrite", *SMALL]
        outcome, left = on_small_disk(trial, most, again, "s.scene", "s.scene")
        sums = {line.split()[1].rsplit("/", 1)[-1]: line.split()[0] for line in left.splitlines()}
        old = content_of(trial.folder / "s.scene")
        trial.check(outcome.code == INPUT and sums == old, f"retrained on a full disk: {outcome.told()}, {left}")
        outcome, left = on_small_disk(
            trial,
            trial.random.randrange(4096, 1 << 20),
            onto(["train", "s.log", "-o", "out.scene", *TRAINING], "out.scene", "disk"),
        )
        if "checkpoint" not in left:
            check_full(trial, "a checkpoint on a full disk", outcome, left)
        else:  # an older one, whole
            trial.check(
                outcome.code == INPUT and len(left.splitlines()) == 1, f"a checkpoint: {outcome.told()}, {left}"
            )


@case("files that may not grow", quick=True)
def limited_files(trial: Trial) -> None:
    commands = command_lines(trial)
    kept = [path.name for path in trial.folder.iterdir()]
    chosen = ["export ply", "synth", "import nerfstudio", "eval"] if trial.options.quick else list(commands)
    for name in chosen:
        arguments, output = commands[name]
        trial.run("--json", *arguments)  # compiles its kernels: files of a driver's compiler can't grow either
        trial.clear(*kept)
        for most in trial.sample([0, 512, 4096, 65536], 2):
            before = content_of(trial.top)
            outcome = trial.run("--json", *arguments, limits={resource.RLIMIT_FSIZE: most})
            after = content_of(trial.top)
            changed = difference(before, after) if outcome.code != 0 else []
            wrong = trial.wrong_words(outcome) if outcome.code != 0 else []
            trial.check(
                outcome.code in (0, INPUT) and not wrong and not changed,
                f"{name}, files of {most} bytes: {wrong}, {changed}: {outcome.told()}",
            )
            trial.clear(*kept)


@case("stdout that can't be written", quick=True)
def full_stdout(trial: Trial) -> None:
    trial.give_street()
    for arguments in (
        ["info", "s.log"],
        ["info", "s.scene", "--json"],
        ["info", "sensors"],
        ["devices"],
        ["train", "s.log", "-o", "x", "--set", "help"],
    ):
        with open("/dev/full", "wb") as full:
            began = time.monotonic()
            outcome = trial.wait(trial.start(arguments, stdout=full.fileno()), began)
        trial.check(outcome.code == INPUT and len(outcome.lines) == 1, f"{shown(arguments)}: {outcome.told()}")


def make_unwritable(trial: Trial) -> dict[str, str]:
    """Places that no output can have, with what would be found there."""
    at = trial.folder
    (at / "file").write_text("somebody's")
    (at / "folder").mkdir()
    (at / "folder" / "notes.txt").write_text("somebody's")
    (at / "empty").mkdir()
    (at / "loop").symlink_to("loop")
    (at / "nowhere").symlink_to("no/where")
    os.mkfifo(at / "fifo")
    places = {
        "folder": "a folder with files",
        "empty": "an empty folder",
        "file/OUT": "below a file",
        "/proc/OUT": "a disk without files",
        "loop": "a link to itself",
        "loop/OUT": "below a link to itself",
        "": "no name",
        "x" * 300: "too long a name",
        "fifo": "a pipe",
    }
    if os.geteuid() == 0:
        for name, number in {"full": 7, "null": 3}.items():
            os.mknod(at / name, stat.S_IFCHR | 0o666, os.makedev(1, number))
            places[name] = "a device"
    else:
        (at / "locked").mkdir(mode=0o500)
        places["locked/OUT"] = "a folder without permission"
    return places


@case("outputs that can't be", quick=True)
def impossible_outputs(trial: Trial) -> None:
    commands = command_lines(trial)
    places = make_unwritable(trial)
    chosen = list(commands.items())
    if trial.options.quick:
        chosen = [(n, commands[n]) for n in ("export ply", "render pictures", "import points", "fit lens", "eval")]
    for name, (arguments, output) in chosen:
        for place in trial.sample(places, quick=5):
            target = place.replace("OUT", output)
            # What a training replaces is a scene, or a folder that is as good as new.
            may_work = place == "empty" and "--overwrite" in arguments
            before = content_of(trial.top)
            trial.refused(
                *[target if a == output else a for a in arguments],
                codes={INPUT, USAGE},
                may_work=may_work or place == "loop",
            )
            changed = difference(before, content_of(trial.top))
            if changed and not may_work:  # a link is replaced by the file; what it leads to is not
                trial.check(
                    place == "loop" and (trial.folder / "loop").is_file(), f"{name} to {place!r}: changed {changed}"
                )
                remove(trial.folder / "loop")
                (trial.folder / "loop").symlink_to("loop")
        if Path(output).suffix in (".png", ".ply", ".spz", ".html", ".json"):  # folders are made with those above
            trial.refused(*[f"no/folder/{output}" if a == output else a for a in arguments], codes={INPUT, USAGE})
