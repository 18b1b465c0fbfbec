"""Random damage in every file that the command line reads: the reader refuses it in one line, or it does no harm."""

from __future__ import annotations

import json
import random
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import datasets
from harness import INPUT, REFUSED, SMALL, Trial, case
from interruptions import TRAINING

NUMBER = re.compile(rb"-?\b\d+(\.\d+)?([eE][-+]?\d+)?\b")
NUMBERS = [b"NaN", b"nan", b"-1", b"0", b"1e300", b"-1e300", b"1e999", b"4294967296", b"9223372036854775807",
           b"18446744073709551616", b"1099511627776", b"0x10", b"", b"1 1"]  # fmt: skip
WORDS = [b"\xff\xff\xff\xff\xff\xff\xff\xff", b"\xff\xff\xff\x7f", b"\0\0\0\0", b"\0\0\xc0\x7f", b"\0\0\x80\x7f"]


def damaged(whole: bytes, chance: random.Random) -> tuple[str, bytes]:
    """One kind of damage, at random."""
    size = len(whole)
    place = chance.randrange(size) if size else 0
    kind = chance.choice(["cut", "number", "number", "flip", "zeros", "word", "twice", "gone", "longer", "empty"])
    if kind == "cut":
        return kind, whole[:place]
    if kind == "number":
        places = list(NUMBER.finditer(whole[:100_000]))
        if places and b"\0" not in whole[:64]:
            at, number = chance.choice(places), chance.choice(NUMBERS)
            return f"{number.decode()} at {at.start()}", whole[: at.start()] + number + whole[at.end() :]
        kind = "flip"
    if kind == "flip":
        changed = bytearray(whole)
        for _ in range(chance.choice([1, 1, 8, 64])):
            if changed:
                changed[chance.randrange(size)] ^= 1 << chance.randrange(8)
        return kind, bytes(changed)
    if kind == "word":
        word = chance.choice(WORDS)
        place = chance.choice([place, min(place, 64)])
        return f"word at {place}", whole[:place] + word + whole[place + len(word) :]
    length = chance.randrange(1, max(2, size // 2))
    part = whole[place : place + length]
    middle = {"zeros": b"\0" * len(part), "twice": part * 2, "gone": b""}
    if kind in middle:
        return f"{kind} at {place}", whole[:place] + middle[kind] + whole[place + length :]
    return kind, whole + chance.randbytes(length) if kind == "longer" else b""


def inputs(trial: Trial) -> Iterator[tuple[str, Path, list[list[str]]]]:
    """A file, and the commands that read it."""
    trial.give_street()
    at = trial.folder
    trial.works("export", "s.scene", "-o", "s.spz")
    trial.works("export", "s.scene", "-o", "s.ply")
    for name in ("generic64", "tum_vi_cam0"):
        (at / f"{name}.json").write_text(trial.works("info", name, "--json").out)
    out = ["-o", "out.ply"]
    render = ["render", "s.scene", "--sensor", "front", "--times", "0:0:1", "-o", "out"]
    yield "scene.json", at / "s.scene/scene.json", [["info", "s.scene"], render]
    yield "camera.ply", at / "s.scene/camera.ply", [["export", "s.scene", *out], render]
    yield "lidar.ply", at / "s.scene/lidar.ply", [["export", "--lidar", "s.scene", *out]]
    yield "splat PLY", at / "s.ply", [["export", "s.ply", *out]]
    yield "SPZ", at / "s.spz", [["export", "s.spz", *out]]
    yield "camera file", at / "tum_vi_cam0.json", [["info", "tum_vi_cam0.json"]]
    yield "LiDAR file", at / "generic64.json", [["info", "generic64.json"]]
    actors = ["actors", "s.log", "-o", "out.log", "--set", "actors.min_sweeps=4"]
    train = ["train", "s.log", "-o", "out.scene", "--iterations", "1", *SMALL]
    yield "log.json", at / "s.log/log.json", [["info", "s.log"], actors, train]
    yield "picture of a log", next((at / "s.log/images").rglob("*.png")), [train]
    yield "sweep of a log", next((at / "s.log/sweeps").rglob("*.exr")), [actors]
    seed = Path(__file__).parent.parent / "fuzz/seeds"
    for name in ("ply_compressed/sh.ply", "ply/ascii.ply"):
        copy = at / Path(name).name
        shutil.copy(seed / name, copy)
        yield name, copy, [["export", copy.name, *out]]
    shutil.copy(seed / "waymo_records/segment", at / "w.tfrecord")
    yield "Waymo segment", at / "w.tfrecord", [["import", "waymo", "w.tfrecord", "-o", "out.log"]]
    for name, arguments in datasets.imports(trial).items():
        files = sorted(p for p in (at / name).rglob("*") if p.is_file() and p.suffix not in (".png", ".jpg"))
        for file in {f.suffix + f.stem.strip("0123456789") + f.parent.name: f for f in files}.values():
            yield f"{name}: {file.relative_to(at / name).name}", file, [arguments]
    (at / "beams").mkdir()
    shutil.copy(next((at / "kitti").rglob("*.bin")), at / "beams/0.bin")
    yield "points of fit beams", at / "beams/0.bin", [["fit", "beams", "beams", "-o", "out.json"]]


def clear_outputs(trial: Trial) -> None:
    for name in ("out", "out.ply", "out.log", "out.scene", "out.json", "out.scene.checkpoint"):
        path = trial.folder / name
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def try_mutants(trial: Trial, only: set[str], tries: int) -> None:
    for name, file, commands in inputs(trial):
        if only and name not in only:
            continue
        whole = file.read_bytes()
        for _ in range(tries):
            kind, mutant = damaged(whole, trial.random)
            file.write_bytes(mutant)
            before = len(trial.result.failures)
            command = trial.random.choice(commands)
            trial.refused(*command, codes=REFUSED, may_work=True, limit_s=60)
            if len(trial.result.failures) > before:
                trial.result.failures[-1] = f"{name}, {kind}: " + trial.result.failures[-1]
            clear_outputs(trial)
        file.write_bytes(whole)


@case("damaged files, every reader")
def mutants(trial: Trial) -> None:
    try_mutants(trial, set(), 4 * trial.tries)


@case("damaged files, some readers", quick=True)
def some_mutants(trial: Trial) -> None:
    try_mutants(trial, {"scene.json", "SPZ", "log.json", "points: points.json"}, trial.tries)


@case("deep JSON")
def deep_json(trial: Trial) -> None:
    for name, file, commands in inputs(trial):
        if file.suffix != ".json":
            continue
        whole = file.read_bytes()
        key = b'{"' + next(iter(json.loads(whole)) if whole[:1] == b"{" else iter(["a"])).encode() + b'": '
        for text in (
            b"[" * 200_000,
            key + b"[" * 100_000 + b"]" * 100_000 + b"}",
            b'{"a":' * 150_000,
            b"[" * 65 + b"]" * 65,
        ):
            file.write_bytes(text)
            for command in commands:
                before = len(trial.result.failures)
                trial.refused(*command, codes={INPUT})
                if len(trial.result.failures) > before:
                    trial.result.failures[-1] = f"{name}: " + trial.result.failures[-1]
        file.write_bytes(whole)


@case("checkpoints of others, damaged")
def checkpoints(trial: Trial) -> None:
    trial.give_street()
    train = ["train", "s.log", "-o", "k.scene", *TRAINING, "--resume"]
    trial.works(*train)
    state = trial.folder / "k.scene.checkpoint"
    whole = state.read_bytes()
    remove = shutil.rmtree
    remove(trial.folder / "k.scene")
    size = len(whole)
    damage = [b"", b"\0" * size, whole[: size // 2], whole[:-1], whole[:7], whole + b"x", b"\0" * 64 + whole[64:]]
    for _ in range(10 * trial.tries):
        changed = bytearray(whole)
        changed[trial.random.randrange(size)] ^= 1 << trial.random.randrange(8)
        damage.append(bytes(changed))
    for bytes_ in damage:
        state.write_bytes(bytes_)
        trial.refused(*train, codes={INPUT}, says="k.scene.checkpoint")
    state.write_bytes(whole)
    for more in (
        ["--seed", "2"],
        ["--scale", "0.4"],
        ["--held-out", "3"],
        ["--iterations", "30"],
        ["--quality", "draft"],
        ["--set", "lidar_every=3"],
    ):
        trial.refused(*train, *more, codes={INPUT, 2}, says="found")
    trial.works(
        "synth",
        "street",
        "--frames",
        "6",
        "--image-width",
        "64",
        "--image-height",
        "36",
        "--lidar-columns",
        "90",
        "--speed",
        "9",
        "-o",
        "o.log",
    )
    trial.refused("train", "o.log", *train[2:], codes={INPUT}, says="found log=")
    state.unlink()
    state.mkdir()
    trial.refused(*train, codes={INPUT}, says="k.scene.checkpoint")
    state.rmdir()
    for target in ("k.scene.checkpoint", "/dev/zero", "no/where"):
        state.symlink_to(target)
        trial.refused(*train, codes={INPUT}, says="k.scene.checkpoint")
        state.unlink()
