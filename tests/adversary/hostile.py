"""Names and links that lead elsewhere, and files that are none."""

from __future__ import annotations

import json
import os
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import datasets
from harness import INPUT, REFUSED, SMALL, STREET, USAGE, Trial, case, content_of, difference, remove
from readers import clear_outputs

LIMIT_S = 20.0


def bad_names(trial: Trial) -> list[str]:
    return [
        "../../x", "../../../x", str(trial.top / "absolute"), "..", ".", ".x", "a/b", "a\\b", "", "a\nb", "a\rb", "a\0b", "a\x1b[31mb",
        "\u202ea", "a\u2066b", "x" * 129, "x" * 10_000, "\x7f", "\u0085",
    ]  # fmt: skip


def odd_names() -> list[str]:
    """Allowed, and harmless."""
    return [
        "a b",
        "a'b\"c",
        "<script>alert(1)</script>",
        "$(id)",
        "`id`",
        "-o",
        "%s%n",
        "Größe 日本",
        "a:b",
        "a,b",
        "x" * 128,
        "CON",
        "~",
    ]


def places_in(value: Any, at: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where names and files stand in a JSON."""
    if isinstance(value, dict):
        for key, child in value.items():
            yield from places_in(child, (*at, key))
    elif isinstance(value, list):
        for i, child in enumerate(value[:2]):
            yield from places_in(child, (*at, i))
    elif isinstance(value, str):
        yield at


def changed(value: Any, at: tuple[Any, ...], text: str) -> str:
    copy = json.loads(json.dumps(value))
    place = copy
    for key in at[:-1]:
        place = place[key]
    place[at[-1]] = text
    return json.dumps(copy)


def commands_of(name: str) -> list[list[str]]:
    if name == "s.log":
        return [
            ["info", "s.log"],
            ["train", "s.log", "-o", "out.scene", "--iterations", "1", *SMALL],
            ["actors", "s.log", "-o", "out.log", "--set", "actors.min_sweeps=4"],
            ["align", "s.log", "-o", "out.log"],
            ["eval", "s.scene", "s.log", "--report", "out.html", "--repeats", "1"],
            ["render", "s.scene", "--sensor", "front", "--trajectory", "s.log", "-o", "out"],
            ["render", "s.scene", "--sensor", "front", "--track", "car:s.log", "-o", "out"],
            ["fit", "lens", "s.log", "front", "--model", "opencv_fisheye", "-o", "out.json"],
        ]
    return [
        ["info", "s.scene"],
        ["render", "s.scene", "--sensor", "front", "--times", "0:0:1", "-o", "out"],
        ["eval", "s.scene", "s.log", "--report", "out.html", "--repeats", "1"],
        ["export", "s.scene", "-o", "out.ply"],
        ["render", "s.scene", "--sensor", "top", "--times", "0:0:1", "--add", "s.scene:car:guest", "-o", "out"],
    ]


def try_name(trial: Trial, name: str, command: list[str]) -> None:
    """What is written lies in the output that was named, and nothing else changed."""
    before = content_of(trial.top)
    outcome = trial.run("--json", *command, limit_s=60)
    outputs = ("out", "out.ply", "out.log", "out.scene", "out.json", "out.html")
    prefix = os.fsdecode(trial.folder.relative_to(trial.top)) + "/"
    others = [
        path
        for path in difference(before, content_of(trial.top))
        if not any(path == prefix + o or path.startswith(f"{prefix}{o}/") for o in outputs)
    ]
    wrong = trial.wrong_words(outcome) if outcome.code else []
    if outcome.code not in REFUSED | {0} or outcome.timed_out:
        wrong.append("wrong end")
    trial.check(
        not others and not wrong, f"{ascii(name)[:60]} in {command}: wrote {others}, {wrong}: {outcome.told()}"
    )
    remove(trial.folder / "out.html")
    clear_outputs(trial)


@case("hostile names in logs and scenes")
def names_in_json(trial: Trial) -> None:
    trial.give_street()
    for folder, file in (("s.log", "log.json"), ("s.scene", "scene.json")):
        path = trial.folder / folder / file
        whole = path.read_text()
        value = json.loads(whole)
        commands = commands_of(folder)
        places = list(places_in(value))
        named = [p for p in places if p[-1] in ("name", "file")]
        others = [p for p in places if p[-1] not in ("name", "file")]
        for at in named + trial.random.sample(others, min(len(others), 2 * trial.tries)):
            for name in trial.random.sample(bad_names(trial), min(19, 2 * trial.tries)) + trial.random.sample(
                odd_names(), min(13, trial.tries)
            ):
                path.write_text(changed(value, at, name))
                try_name(trial, name, trial.random.choice(commands))
        path.write_text(whole)


@case("hostile names in data sets")
def names_in_sets(trial: Trial) -> None:
    imports = datasets.imports(trial)
    for name, arguments in imports.items():
        for path in sorted((trial.folder / name).rglob("*.json")):
            whole = path.read_text()
            value = json.loads(whole)
            for at in places_in(value):
                for bad in trial.random.sample(bad_names(trial), min(19, trial.tries)) + trial.random.sample(
                    odd_names(), 1
                ):
                    path.write_text(changed(value, at, bad))
                    try_name(trial, bad, arguments)
            path.write_text(whole)
    texts = {"kitti": ("labels.txt", "Car"), "colmap": ("sparse/0/images.txt", "0.png")}
    for name, (file, word) in texts.items():
        path = trial.folder / name / file
        whole = path.read_text()
        for bad in bad_names(trial) + odd_names():
            path.write_bytes(whole.replace(word, bad).encode())
            try_name(trial, bad, imports[name])
        path.write_text(whole)


def reading_commands() -> dict[str, list[str]]:
    """Each command that reads a path, X."""
    return {
        "info": ["info", "X"],
        "train": ["train", "X", "-o", "out.scene"],
        "actors": ["actors", "X"],
        "align": ["align", "X"],
        "eval scene": ["eval", "X", "s.log"],
        "eval log": ["eval", "s.scene", "X"],
        "render": ["render", "X", "--sensor", "front", "-o", "out"],
        "render sensor": ["render", "s.scene", "--sensor", "X", "-o", "out"],
        "render trajectory": ["render", "s.scene", "--sensor", "front", "--trajectory", "X", "-o", "out"],
        "render add": ["render", "s.scene", "--sensor", "front", "--add", "X:car", "-o", "out"],
        "render track": ["render", "s.scene", "--sensor", "front", "--track", "car:X", "-o", "out"],
        "export": ["export", "X", "-o", "out.ply"],
        "export ply": ["export", "X.ply", "-o", "out.ply"],
        "export spz": ["export", "X.spz", "-o", "out.ply"],
        "mask": ["mask", "s.log", "front:X", "-o", "out.log"],
        "view": ["view", "X", "--port", "0"],
        "fit beams": ["fit", "beams", "X"],
        "fit lens": ["fit", "lens", "X", "--model", "opencv_fisheye"],
        "kitti": ["import", "kitti", "X", "-o", "out.log"],
        "kitti poses": ["import", "kitti", "kitti/2011_09_26_drive_0001_sync", "--poses", "X", "-o", "out.log"],
        "kitti labels": ["import", "kitti", "kitti/2011_09_26_drive_0001_sync", "--tracking", "X", "-o", "out.log"],
        "kitti beams": ["import", "kitti", "kitti/2011_09_26_drive_0001_sync", "--beams", "X", "-o", "out.log"],
        "kitti360": ["import", "kitti360", "X", "-o", "out.log"],
        "nuscenes": ["import", "nuscenes", "X", "-o", "out.log"],
        "waymo": ["import", "waymo", "X", "-o", "out.log"],
        "points": ["import", "points", "X", "-o", "out.log"],
        "colmap": ["import", "colmap", "X", "-o", "out.log"],
        "nerfstudio": ["import", "nerfstudio", "X", "-o", "out.log"],
    }


def make_no_files(trial: Trial, ending: str) -> list[str]:
    """Links that go round or nowhere, a pipe, a folder, devices, a socket-like nothing."""
    at = trial.folder
    (at / f"loop{ending}").symlink_to(f"loop{ending}")
    (at / f"nowhere{ending}").symlink_to("no/where")
    (at / f"zero{ending}").symlink_to("/dev/zero")
    (at / f"null{ending}").symlink_to("/dev/null")
    (at / f"folder{ending}").mkdir()
    (at / f"empty{ending}").write_bytes(b"")
    os.mkfifo(at / f"fifo{ending}")
    return [
        f"{name}{ending}"
        for name in ("loop", "nowhere", "zero", "null", "folder", "empty", "fifo", "absent", "x" * 300)
    ]


@case("what is no file, as an argument", quick=True)
def no_files(trial: Trial) -> None:
    trial.give_street()
    datasets.kitti(trial.folder / "kitti", trial)
    names = {ending: make_no_files(trial, ending) for ending in ("", ".ply", ".spz")}
    commands = list(reading_commands().values())
    for command in trial.sample(commands, 8):
        ending = next((Path(a).suffix for a in command if a.startswith("X.")), "")
        for name in trial.sample(names[ending], 4):
            arguments = [
                name if a == "X" + ending else a.replace("X", name) if "X:" in a or ":X" in a else a for a in command
            ]
            # A drive may have no labels at all.
            may_work = name.startswith("empty") and "--tracking" in arguments
            trial.refused(*arguments, may_work=may_work, limit_s=LIMIT_S)


@case("what is no file, inside of folders")
def no_files_inside(trial: Trial) -> None:
    trial.give_street()
    folders = {name: [arguments] for name, arguments in datasets.imports(trial).items()}
    folders |= {"s.log": commands_of("s.log")[:3], "s.scene": commands_of("s.scene")}
    for name, commands in folders.items():
        files = sorted(p for p in (trial.folder / name).rglob("*") if p.is_file())
        kinds = {p.suffix + p.stem.strip("0123456789") + p.parent.name: p for p in files}
        for file in kinds.values():
            whole = file.read_bytes()
            for kind in trial.random.sample(
                ["loop", "nowhere", "zero", "fifo", "folder", "null", "device"], min(7, 2 * trial.tries)
            ):
                remove(file)
                if kind == "fifo":
                    os.mkfifo(file)
                elif kind == "folder":
                    file.mkdir()
                elif kind == "device" and os.geteuid() == 0:
                    os.mknod(file, stat.S_IFCHR | 0o666, os.makedev(1, 5))
                else:
                    file.symlink_to(
                        {"loop": file.name, "nowhere": "no/where", "null": "/dev/null"}.get(kind, "/dev/zero")
                    )
                before = len(trial.result.failures)
                # A picture that is named but absent is told and passed over.
                trial.refused(*trial.random.choice(commands), may_work=True, limit_s=LIMIT_S)
                if len(trial.result.failures) > before:
                    trial.result.failures[-1] = (
                        f"{file.relative_to(trial.folder)} is {kind}: " + trial.result.failures[-1]
                    )
                clear_outputs(trial)
                remove(trial.folder / "out.html")
                remove(file)
            file.write_bytes(whole)


@case("paths with odd characters", quick=True)
def odd_paths(trial: Trial) -> None:
    """Spaces, quotes, line breaks, bytes that are no UTF-8: written, read, told in one line when refused."""
    names = [
        b"with space",
        b"quote'\"s",
        b"line\nbreak",
        "Größe 日本".encode(),
        b"$(id);&|",
        b"\xff\xfe",
        b"-dash",
        b"%s%d",
        b"a\x1b[31m",
    ]
    trial.give_street()
    for raw in trial.sample(names, 2):
        name = os.fsdecode(raw)
        place = trial.folder / f"{name}.d"
        place.mkdir()
        at = f"./{name}.d/{name}"
        for command in (
            [*STREET, "-o", at + ".log"],
            ["train", at + ".log", "-o", at + ".scene", "--iterations", "1", *SMALL],
            ["info", at + ".scene"],
            ["render", at + ".scene", "--sensor", "front", "--times", "0:0:1", "-o", at],
            ["export", at + ".scene", "-o", at + ".ply"],
            ["export", at + ".ply", "-o", at + ".spz"],
            ["eval", at + ".scene", at + ".log", "--repeats", "1", "--report", at + ".html"],
        ):
            outcome = trial.run("--json", *command)
            holds = outcome.code == 0
            # JSON holds text alone: a name that is none is refused, in one line.
            refused = b"\xff" in raw and outcome.code in (INPUT, USAGE) and not trial.wrong_words(outcome)
            trial.check(holds or refused, f"{ascii(name)}: {command[0]}: {outcome.told()}")
            if not holds:
                break
        else:
            trial.refused("render", at + ".scene", "--sensor", "front", "--times", "0:0:1", "-o", at)
            trial.refused("info", at + ".nothing")
        shutil.rmtree(place)
