"""Absurd numbers on the command line, and too little memory."""

from __future__ import annotations

import json
import resource

from harness import DEVICE, INPUT, MEMORY, NUMERIC, SMALL, STREET, USAGE, Trial, case, shown
from readers import clear_outputs

ABSURD = [
    "-1",
    "nan",
    "inf",
    "-inf",
    "1e300",
    "-1e300",
    "99999999999999999999",
    "9223372036854775808",
    "1e-320",
    "0x7f",
    "",
    "abc",
    "1,5",
    "18446744073709551615",
    "2147483648",
]
LIMIT_S = 60.0


def options_with_numbers() -> list[tuple[list[str], str]]:
    """A command line up to an option, and values of it that are allowed and quick (a regular expression of none)."""
    render = ["render", "s.scene", "--sensor", "front", "-o", "out"]
    sweep = ["render", "s.scene", "--sensor", "top", "-o", "out"]
    train = ["train", "s.log", "-o", "out.scene", "--max-seconds", "1", *SMALL]
    at = ["--times", "0:0:1"]
    street = ["synth", "street", "-o", "out.log"]
    return [
        *[([*render, *at], o) for o in ("--scale", "--fps", "--duration", "--lane-shift", "--speed")],
        *[([*sweep, *at], o) for o in ("--duration", "--lane-shift", "--scale")],
        *[(train, o) for o in ("--iterations", "--seed", "--checkpoint-every", "--held-out", "--held-out-middle", "--held-out-last", "--scale", "--view")],
        (["train", "s.log", "-o", "out.scene", "--iterations", "1", *SMALL], "--max-seconds"),
        *[(street, o) for o in ("--speed", "--seed", "--frames", "--image-width", "--image-height", "--lidar-columns")],
        *[(["eval", "s.scene", "s.log"], o) for o in ("--scale", "--held-out", "--held-out-middle", "--held-out-last", "--repeats")],
        (["actors", "s.log"], "--held-out"),
        *[(["align", "s.log"], o) for o in ("--prior-position", "--prior-rotation")],
        (["demo", "-o", "out"], "--iterations"),
        (["view", "s.scene"], "--port"),
        (["fit", "beams", "s.log"], "--sweeps"),
        (["fit", "beams", "s.log"], "--spin-hz"),
    ]  # fmt: skip


def harmless(option: str, value: str) -> bool:
    """Allowed, and does so much, or serves until it is ended, that it is not tried."""
    number = value.replace("0x7f", "127")
    if option in ("--port", "--view"):
        return number in ("127",)
    if option in (
        "--iterations",
        "--frames",
        "--image-width",
        "--image-height",
        "--lidar-columns",
        "--repeats",
        "--particles",
    ):
        return number in (
            "127",
            "2147483648",
            "99999999999999999999",
            "9223372036854775808",
            "18446744073709551615",
            "1e300",
            "inf",
        )
    return False


@case("absurd numbers in options")
def absurd_options(trial: Trial) -> None:
    trial.give_street()
    for command, option in options_with_numbers():
        for value in ABSURD if trial.tries >= len(ABSURD) else trial.random.sample(ABSURD, 3 * trial.tries):
            if option in ("--port", "--view", "--iterations", "--repeats") and harmless(option, value):
                continue
            trial.refused(
                *command, f"{option}={value}", codes={USAGE, INPUT, DEVICE, NUMERIC}, may_work=True, limit_s=LIMIT_S
            )
            clear_outputs(trial)


@case("numbers that are none", quick=True)
def no_numbers(trial: Trial) -> None:
    """What nobody can mean is refused, before any work."""
    trial.give_street()
    render = ["render", "s.scene", "--sensor", "front", "-o", "out"]
    train = ["train", "s.log", "-o", "out.scene", "--iterations", "1"]
    street = ["synth", "street", "-o", "out.log"]
    meaningless = [
        [*train, "--seed=-1"],
        [*train, "--checkpoint-every=-1"],
        [*train, "--held-out=-1"],
        [*train, "--max-seconds=nan"],
        [*train, "--scale=nan"],
        [*train, "--iterations=-1"],
        [*train, "--iterations=99999999999"],
        *[
            [*render, "--times", t]
            for t in ("0:1e9:1e-9", "0:1e300:1e-300", "nan:1:1", "0:1:0", "1:0:1", "0:1:-1", "0:1", "::")
        ],
        *[[*render, f"--fps={f}"] for f in ("nan", "-1", "0", "1e300", "inf")],
        *[[*render, f"--lane-shift={s}"] for s in ("nan", "inf")],
        *[[*render, f"--speed={s}"] for s in ("nan", "0", "-1", "1e300")],
        *[[*render, f"--scale={s}"] for s in ("nan", "0", "-1", "1e9")],
        *[[*render, f"--duration={s}"] for s in ("nan", "-1", "inf")],
        *[[*render, "--frames", f] for f in ("-1:0", "0:1e9", "1:0", "a:b")],
        *[[*street, f"--{o}=-1"] for o in ("frames", "image-width", "image-height", "lidar-columns", "seed")],
        *[[*street, f"--{o}=0"] for o in ("frames", "image-width", "image-height", "lidar-columns")],
        [*street, "--speed=nan"],
        [*street, "--speed=1e300"],
        [*street, "--image-width=2000000000", "--image-height=2000000000"],
        ["demo", "-o", "out", "--iterations=-1"],
        ["demo", "-o", "out", "--held-out-last=nan"],
        ["eval", "s.scene", "s.log", "--repeats=-1"],
        ["eval", "s.scene", "s.log", "--scale=nan"],
        ["actors", "s.log", "--held-out=-1"],
    ]
    for command in trial.sample(meaningless, quick=20):
        trial.refused(*command, codes={USAGE, INPUT}, limit_s=LIMIT_S)


@case("absurd settings")
def absurd_settings(trial: Trial) -> None:
    trial.give_street()
    help_text = trial.works("train", "s.log", "-o", "x", "--set", "help", "--json").out
    keys = [entry["key"] for entry in json.loads(help_text)]
    train = ["train", "s.log", "-o", "out.scene", "--iterations", "2", "--max-seconds", "2"]
    for key in keys:
        for value in trial.random.sample(
            ["-1", "nan", "1e300", "inf", "99999999999999999999", "", "x", "0"], min(8, trial.tries)
        ):
            more = [] if key == "init.voxel_m" else ["init.voxel_m=0.3"]
            trial.refused(
                *train,
                "--set",
                *more,
                f"{key}={value}",
                codes={USAGE, INPUT, DEVICE, NUMERIC},
                may_work=True,
                limit_s=LIMIT_S,
            )
            clear_outputs(trial)


@case("sizes in files that nobody has memory for")
def huge_sizes(trial: Trial) -> None:
    trial.give_street()
    path = trial.folder / "s.scene/scene.json"
    whole = json.loads(path.read_text())
    for keys in (("cameras", 0, "width_px"), ("cameras", 0, "height_px"), ("lidars", 0, "columns")):
        for value in (0, -1, 60_000, 10**6, 2**31, 2**40, 2**63, 1e300):
            changed = json.loads(json.dumps(whole))
            changed[keys[0]][keys[1]][keys[2]] = value
            path.write_text(json.dumps(changed))
            sensor = "top" if keys[0] == "lidars" else "front"
            trial.refused(
                "render",
                "s.scene",
                "--sensor",
                sensor,
                "--times",
                "0:0:1",
                "-o",
                "out",
                codes={INPUT, DEVICE},
                may_work=value in (60_000, 10**6),
                limit_s=LIMIT_S,
            )
            clear_outputs(trial)


@case("little memory, few files")
def little_memory(trial: Trial) -> None:
    trial.give_street()
    commands = [
        [*STREET, "-o", "out.log"],
        ["info", "s.scene"],
        ["render", "s.scene", "--sensor", "front", "--times", "0:0:1", "-o", "out"],
        ["train", "s.log", "-o", "out.scene", "--iterations", "2", *SMALL],
        ["export", "s.scene", "-o", "out.ply"],
    ]
    for command in commands:
        for megabytes in trial.random.sample(
            [40, 80, 120, 160, 200, 300, 400, 600, 800, 1200, 2000, 4000], min(12, 3 * trial.tries)
        ):
            before = len(trial.result.failures)
            # Less than libraries need ends it before its first line (127: the loader; an abort: their threads).
            codes = {USAGE, INPUT, DEVICE, 5, 127, -6} if megabytes <= 400 else {USAGE, INPUT, DEVICE, 5}
            outcome = trial.refused(
                *command, codes={*codes, MEMORY}, may_work=True, limits={resource.RLIMIT_AS: megabytes << 20}
            )
            if outcome.code in (127, -6) and megabytes <= 400:
                del trial.result.failures[before:]
            if "no OpenCL device at all" in outcome.err and "given memory" not in outcome.err:
                trial.check(False, f"{shown(command)} in {megabytes} MB: misleading: {outcome.told()}")
            clear_outputs(trial)
        for files in (6, 8, 10, 12, 16, 20):
            outcome = trial.refused(
                *command, codes={USAGE, INPUT, DEVICE, 5, 127}, may_work=True, limits={resource.RLIMIT_NOFILE: files}
            )
            clear_outputs(trial)
    render, train = commands[2], commands[3]
    for limit in ("0", "1", "-1", "x", "99999999"):
        trial.refused(*render, may_work=True, environment={"POCL_MEMORY_LIMIT": limit})
        clear_outputs(trial)
    for size in ("1", "1000000"):
        trial.refused(*train, f"memory_bytes={size}", codes={DEVICE})
