"""Our cache of programs and PoCL's: damaged, full, read-only, absent, shared by processes that start at once."""

from __future__ import annotations

import os
import random
import shutil
import time
from pathlib import Path

from disks import may_mount
from harness import Outcome, Skip, Trial, case, content_of

CRASHED = "simuli: crashed, in the OpenCL driver or by a defect"
DEVICES_AT_ONCE = 8


def render(output: str = "out") -> list[str]:
    return ["render", "s.scene", "--sensor", "front", "--times", "0:0:1", "-o", output]


def own_home(trial: Trial, home: Path | None = None) -> dict[str, str | None]:
    """Caches where they are by default, below a home of the case's own."""
    return {
        "HOME": str(home or trial.top / "home"),
        "XDG_CACHE_HOME": None,
        "POCL_CACHE_DIR": None,
        "SIMULI_CACHE_DIR": None,
    }


def need_pocl(trial: Trial) -> None:
    if "Portable Computing Language" not in trial.works("devices").out:
        raise Skip("there is no PoCL")


def damage(file: Path, chance: random.Random) -> str:
    whole = file.read_bytes()
    kind = chance.choice(["cut", "flip", "empty", "zeros", "folder", "gone", "others"])
    if kind in ("folder", "gone"):
        file.unlink()
        if kind == "folder":
            file.mkdir()
        return kind
    changed = bytearray(whole)
    if whole:
        changed[chance.randrange(len(whole))] ^= 1 << chance.randrange(8)
    cut = whole[: chance.randrange(len(whole) + 1)]
    file.write_bytes(
        {"cut": cut, "flip": bytes(changed), "empty": b"", "zeros": bytes(len(whole)), "others": b"\x7fELF others"}[
            kind
        ]
    )
    return kind


def same_picture(
    trial: Trial, told: str, right: dict[str, str], environment: dict[str, str | None], outcome: Outcome | None = None
) -> Outcome:
    outcome = outcome or trial.run("--json", *render(), environment=environment)
    holds = outcome.code == 0 and content_of(trial.folder / "out") == right and not outcome.lines
    trial.check(holds, f"{told}: {outcome.told()}")
    shutil.rmtree(trial.folder / "out", ignore_errors=True)
    return outcome


def first_picture(trial: Trial) -> dict[str, str]:
    trial.give_street()
    trial.works(*render())
    right = content_of(trial.folder / "out")
    shutil.rmtree(trial.folder / "out")
    return right


@case("our cache damaged")
def own_cache(trial: Trial) -> None:
    need_pocl(trial)
    right = first_picture(trial)
    environment = own_home(trial)
    same_picture(trial, "cold", right, environment)
    cache = trial.top / "home/.cache/simuli"
    for _ in range(trial.tries):
        files = sorted(p for p in cache.rglob("*") if p.is_file())
        for file in trial.random.sample(files, min(len(files), 3)):
            kind = damage(file, trial.random)
            same_picture(trial, f"{file.name}: {kind}", right, environment)
            remove_folder_in_place(file)
    shutil.rmtree(cache)
    cache.write_text("a file in its place")
    same_picture(trial, "a file in its place", right, environment)
    cache.unlink()
    cache.symlink_to("simuli")
    same_picture(trial, "a link to itself in its place", right, environment)


def remove_folder_in_place(file: Path) -> None:
    if file.is_dir():
        file.rmdir()


@case("PoCL's cache damaged")
def driver_cache(trial: Trial) -> None:
    """A crash of PoCL's is one line, and ends one run, not all."""
    need_pocl(trial)
    right = first_picture(trial)
    environment = own_home(trial)
    same_picture(trial, "cold", right, environment)
    crashes = 0
    for _ in range(trial.tries):
        caches = [trial.top / "home/.cache/pocl", *(trial.top / "home/.cache/simuli").glob("pocl*")]
        files = sorted(p for c in caches if c.exists() for p in c.rglob("*") if p.is_file())
        file = trial.random.choice([p for p in files if p.suffix == ".so"] or files)
        kind = damage(file, trial.random)
        told = f"{file.name}: {kind}"
        outcome = trial.run("--json", *render(), environment=environment)
        if outcome.code != 0:
            crashes += 1
            # PoCL may have told more; ours is the last line.
            one_line = outcome.lines[-1:] and outcome.lines[-1].startswith("simuli: crashed") and not outcome.timed_out
            trial.check(one_line, f"{told}: {outcome.told()}")
            outcome = trial.run("--json", *render(), environment=environment)
        same_picture(trial, f"{told}, the start after it", right, environment, outcome)
    trial.result.figures["crashes of PoCL"] = crashes


@case("homes that can't hold a cache")
def homes(trial: Trial) -> None:
    need_pocl(trial)
    right = first_picture(trial)
    same_picture(trial, "no HOME", right, {**own_home(trial), "HOME": None})
    for home in ("/nonexistent/home", "/proc/home", "", "relative/home"):
        same_picture(trial, f"HOME={home}", right, own_home(trial) | {"HOME": home})
    file = trial.top / "home/file"
    file.write_text("")
    same_picture(trial, "HOME is a file", right, own_home(trial, file))
    if not may_mount():
        return
    disk = trial.top / "small"
    disk.mkdir()
    for size in (4096, 65536, 1 << 20):
        script = f'mount -t tmpfs -o size={size} none "{disk}" && exec "$@"'
        began = time.monotonic()
        process = trial.start(
            ["--json", *render()], own_home(trial, disk), before=["unshare", "-m", "sh", "-c", script, "sh"]
        )
        outcome = trial.wait(process, began)
        if outcome.code != 0:  # PoCL ends the process when its disk is full; that is told in a line
            told = [line for line in outcome.lines if line.startswith("simuli: ")]
            trial.check(bool(told), f"HOME on a disk of {size} bytes: {outcome.told()}")
            shutil.rmtree(trial.folder / "out", ignore_errors=True)
        else:
            same_picture(trial, f"HOME on a disk of {size} bytes", right, {}, outcome)
    script = f'mount -t tmpfs none "{disk}" && mount -o remount,ro "{disk}" && exec "$@"'
    began = time.monotonic()
    process = trial.start(
        ["--json", *render()], own_home(trial, disk), before=["unshare", "-m", "sh", "-c", script, "sh"]
    )
    same_picture(trial, "HOME is read-only", right, {}, trial.wait(process, began))


@case("processes that start at once")
def at_once(trial: Trial) -> None:
    need_pocl(trial)
    right = first_picture(trial)
    for i in range(max(1, trial.tries // 3)):
        home = trial.top / f"home{i}"
        home.mkdir()
        began = time.monotonic()
        processes = [
            trial.start(["--json", *render(f"out{k}")], own_home(trial, home)) for k in range(DEVICES_AT_ONCE)
        ]
        for k, process in enumerate(processes):
            outcome = trial.wait(process, began, 600)
            found = content_of(trial.folder / f"out{k}")
            trial.check(outcome.code == 0 and found == right, f"process {k}: {outcome.told()}")
            shutil.rmtree(trial.folder / f"out{k}", ignore_errors=True)
        left = [p for p in home.rglob("*.tmp*") if p.is_file() and "simuli" in os.fspath(p)]
        trial.check(not left, f"left in the cache: {left}")
