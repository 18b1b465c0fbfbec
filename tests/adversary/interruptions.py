"""Processes that end at any moment: kill -9, signals, two at once."""

from __future__ import annotations

import shutil
import signal
import time
from collections.abc import Callable

import datasets
from harness import INPUT, INTERRUPTED, SMALL, STREET, Trial, case, content_of, remove, shown

# Densification, an actor, an environment map and colour grids: all that a state holds.
TRAINING = [
    "--iterations", "60", "--checkpoint-every", "3", *SMALL,
    "lidar_every=2", "densify.epochs=1.5", "anchor.weight=0.01", "actors.track.learn=true", "color_grids=pictures",
    "init.environment_width=16",
]  # fmt: skip
KILLS = 4


def command_lines(trial: Trial) -> dict[str, tuple[list[str], str]]:
    """Commands that write, with the name of what each writes."""
    trial.give_street()
    imports = datasets.imports(trial)
    sweeps = "kitti/2011_09_26_drive_0001_sync/velodyne_points/data"
    commands: dict[str, tuple[list[str], str]] = {
        f"import {name}": (arguments, "out.log") for name, arguments in imports.items()
    }
    commands |= {
        "synth": ([*STREET, "-o", "out.log"], "out.log"),
        "render pictures": (["render", "s.scene", "--sensor", "front", "--times", "0:0.6:0.05", "-o", "out"], "out"),
        "render exr": (["render", "s.scene", "--sensor", "front", "--times", "0:0.3:0.05", "--images", "exr", "-o", "out"], "out"),
        "render clouds": (["render", "s.scene", "--sensor", "top", "--times", "0:0.5:0.05", "-o", "out"], "out"),
        "render npz": (["render", "s.scene", "--sensor", "top", "--times", "0:0.5:0.05", "--clouds", "npz", "-o", "out"], "out"),
        "export spz": (["export", "s.scene", "-o", "out.spz"], "out.spz"),
        "export ply": (["export", "s.scene", "--lidar", "-o", "out.ply"], "out.ply"),
        "eval": (["eval", "s.scene", "s.log", "--repeats", "1", "--report", "out.html"], "out.html"),
        "train": (["train", "s.log", "-o", "out.scene", "--iterations", "20", *SMALL], "out.scene"),
        "train again": (["train", "s.log", "-o", "out.scene", "--iterations", "20", "--overwrite", *SMALL], "out.scene"),
        "actors": (["actors", "s.log", "-o", "out.log", "--set", "actors.min_sweeps=4"], "out.log"),
        "fit beams": (["fit", "beams", sweeps, "-o", "out.json"], "out.json"),
        "fit lens": (["fit", "lens", "tum_vi_cam0", "--model", "ftheta_angle_to_radius", "-o", "out.json"], "out.json"),
    }  # fmt: skip
    return commands


def output_of(trial: Trial, output: str) -> dict[str, str]:
    path = trial.folder / output
    found = content_of(path) if path.is_dir() else {}
    if path.is_file():
        found = {"file": content_of(trial.folder)[output]}
    if found and output.endswith(".html"):  # has times
        return dict.fromkeys(found, str(path.read_text(errors="replace").rstrip().endswith("</html>")))
    if output.endswith(".scene"):  # scene.json names the process's seconds in none of its fields
        return found
    return found


def end_at(trial: Trial, arguments: list[str], after_s: float, signals: list[int], gap_s: float = 0.0) -> int:
    """Sends the signals to a run; its exit code, or minus the signal that ended it."""
    process = trial.start(arguments)
    began = time.monotonic()
    time.sleep(after_s)
    for number in signals:
        process.send_signal(number)
        time.sleep(gap_s)
    outcome = trial.wait(process, began)
    if outcome.timed_out:
        trial.check(False, f"{shown(arguments)}: {signals} after {after_s:.3f} s: did not end")
    return outcome.code


@case("kill -9 of trainings, resumed")
def kill_trainings(trial: Trial) -> None:
    trial.give_street()
    train = ["train", "s.log", *TRAINING]
    trial.works(*train, "-o", "whole.scene")  # compiles
    began = time.monotonic()
    trial.works(*train, "-o", "again.scene")
    duration_s = time.monotonic() - began
    whole = content_of(trial.folder / "whole.scene")
    trial.check(content_of(trial.folder / "again.scene") == whole, "the same training twice: other bits")
    trial.clear("s.log", "s.scene")
    killed = 0
    for _ in range(trial.tries):
        resume = [*train, "-o", "k.scene", "--resume"]
        for _ in range(trial.random.randint(1, KILLS)):
            killed += end_at(trial, resume, trial.random.uniform(0.0, duration_s), [signal.SIGKILL]) < 0
        last = trial.run(*resume)
        names = {path.name for path in trial.folder.iterdir()} - {"s.log", "s.scene"}
        trial.check(
            last.code == 0
            and content_of(trial.folder / "k.scene") == whole
            and names == {"k.scene", "k.scene.checkpoint"},
            f"{last.told()}, beside {sorted(names)}, others {difference_of(trial, whole)}",
        )
        trial.clear("s.log", "s.scene")
    trial.result.figures["kills"] = killed


def difference_of(trial: Trial, whole: dict[str, str]) -> list[str]:
    found = content_of(trial.folder / "k.scene")
    return sorted(name for name in whole if found.get(name) != whole[name])


@case("kill -9 of others, repeated")
def kill_others(trial: Trial) -> None:
    commands = command_lines(trial)
    kept = [path.name for path in trial.folder.iterdir()]
    right, seconds = {}, {}
    for name, (arguments, output) in commands.items():
        outcome = trial.works(*arguments)
        seconds[name], right[name] = outcome.seconds, output_of(trial, output)
        trial.clear(*kept)
    killed = 0
    for i in range(trial.tries * len(commands) if trial.tries < len(commands) else trial.tries):
        name, (arguments, output) = list(commands.items())[i % len(commands)]
        old = {}
        if "--overwrite" in arguments:
            shutil.copytree(trial.folder / "s.scene", trial.folder / output)
            old = output_of(trial, output)
        after_s = trial.random.uniform(0.0, 1.05 * seconds[name])
        code = end_at(trial, arguments, after_s, [signal.SIGKILL])
        killed += code < 0
        there = output_of(trial, output)
        trial.check(
            there in ({}, old, right[name]),
            f"{name}, killed after {after_s:.3f} s: {output} is neither whole nor absent",
        )
        if there and there != old or (there and "--overwrite" not in arguments):
            remove(trial.folder / output)
        again = trial.run(*arguments)
        beside = {path.name for path in trial.folder.iterdir()} - set(kept) - {output}
        same = output_of(trial, output) == right[name]
        trial.check(
            again.code == 0 and same and not beside,
            f"{name}, killed after {after_s:.3f} s and repeated: {again.told()}, same bits: {same}, beside: {sorted(beside)}",
        )
        left = [path.name for path in (trial.top / "tmp").iterdir()]
        trial.check(not left, f"{name}: left in TMPDIR: {left}")
        trial.clear(*kept)
    trial.result.figures["kills"] = killed


@case("kill -9 of the demo, repeated")
def kill_demo(trial: Trial) -> None:
    arguments = ["demo", "-o", "out", "--iterations", "2"]
    seconds = trial.works(*arguments).seconds
    seconds = 0.5 * seconds  # kernels are compiled now
    right = {k: v for k, v in content_of(trial.folder / "out").items() if not k.endswith(".html")}
    trial.clear()
    for _ in range(max(1, trial.tries // 10)):
        end_at(trial, arguments, trial.random.uniform(0.0, seconds), [signal.SIGKILL])
        remove(trial.folder / "out")
        again = trial.run(*arguments)
        found = {k: v for k, v in content_of(trial.folder / "out").items() if not k.endswith(".html")}
        names = [path.name for path in trial.folder.iterdir()]
        trial.check(again.code == 0 and found == right and names == ["out"], f"{again.told()}, {names}")
        trial.clear()


def signalled(
    trial: Trial, name: str, arguments: list[str], output: str, seconds: float, whole: Callable[[], bool]
) -> None:
    """One or two signals at any moment: the output is absent or whole, and nothing stays beside."""
    kept = {path.name for path in trial.folder.iterdir()}
    signals = trial.random.choice(
        [[signal.SIGTERM], [signal.SIGINT], [signal.SIGHUP], [signal.SIGTERM] * 2, [signal.SIGINT, signal.SIGTERM]]
    )
    after_s, gap_s = trial.random.uniform(0.0, 1.05 * seconds), trial.random.uniform(0.0, 0.03)
    code = end_at(trial, arguments, after_s, signals, gap_s)
    checkpoint = {output + ".checkpoint"} if "--checkpoint-every" in arguments else set()
    beside = {path.name for path in trial.folder.iterdir()} - kept - {output} - checkpoint
    allowed = {0} | {-s for s in signals} | ({INTERRUPTED} if checkpoint else set())
    is_whole = not (trial.folder / output).exists() or whole()
    told = f"{name}: {[s.name for s in signals]} after {after_s:.3f} s, {gap_s:.3f} s apart: exit code {code}"
    trial.check(code in allowed and not beside and is_whole, f"{told}, beside {sorted(beside)}, whole: {is_whole}")
    left = [path.name for path in (trial.top / "tmp").iterdir()]
    trial.check(not left, f"{told}: left in TMPDIR: {left}")
    trial.clear(*kept)


@case("SIGTERM, SIGINT, SIGHUP, once and twice")
def signals(trial: Trial) -> None:
    commands = command_lines(trial)
    commands["train with checkpoints"] = (["train", "s.log", "-o", "out.scene", *TRAINING], "out.scene")
    del commands["train again"]
    kept = [path.name for path in trial.folder.iterdir()]
    for name, (arguments, output) in commands.items():
        seconds = trial.works(*arguments).seconds
        if name.startswith("train with"):
            trial.clear(*kept)
            seconds = trial.works(*arguments).seconds  # the first compiles
        right = output_of(trial, output)
        trial.clear(*kept)
        for _ in range(trial.tries):
            signalled(trial, name, arguments, output, seconds, lambda: output_of(trial, output) == right)  # noqa: B023


@case("two processes, one output")
def two_processes(trial: Trial) -> None:
    trial.give_street()
    train = ["train", "s.log", "-o", "out.scene", "--iterations", "100000", "--checkpoint-every", "5", *SMALL]
    first = trial.start(train)
    began = time.monotonic()
    checkpoint = trial.folder / "out.scene.checkpoint"
    while not checkpoint.exists() and first.poll() is None and time.monotonic() - began < 60:
        time.sleep(0.02)
    for more in ([], ["--resume"], ["--overwrite"], ["--resume", "--overwrite"]):
        second = trial.run("--json", *train, *more)
        trial.check(second.code == INPUT and f"process {first.pid}" in second.err, f"train {more}: {second.told()}")
    first.send_signal(signal.SIGTERM)
    code = trial.wait(first, began).code
    trial.check(code == INTERRUPTED, f"the first: exit code {code}")
    trial.clear("s.log", "s.scene")
    # Others are atomic: one of them wins, the other is refused, and what is there is whole.
    kept = [path.name for path in trial.folder.iterdir()]
    for arguments, output in (
        (["render", "s.scene", "--sensor", "front", "--times", "0:0.6:0.05", "-o", "out"], "out"),
        ([*STREET, "-o", "out.log"], "out.log"),
        (["train", "s.log", "-o", "out.scene", "--iterations", "10", *SMALL], "out.scene"),
        (["export", "s.scene", "-o", "out.ply"], "out.ply"),
    ):
        trial.works(*arguments)
        right = output_of(trial, output)
        trial.clear(*kept)
        for _ in range(trial.tries):
            began = time.monotonic()
            both = [trial.start(["--json", *arguments]) for _ in range(2)]
            ends = sorted((trial.wait(process, began) for process in both), key=lambda o: o.code)
            fits = ends[0].code == 0 and ends[1].code in (0, INPUT) and output_of(trial, output) == right
            names = {path.name for path in trial.folder.iterdir()} - set(kept)
            trial.check(
                fits and names == {output},
                f"{shown(arguments)} twice at once: {[o.told() for o in ends]}, {sorted(names)}",
            )
            trial.clear(*kept)
