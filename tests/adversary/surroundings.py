"""Locale, umask, line ends: what differs from machine to machine changes no bit."""

from __future__ import annotations

import json
import shutil
import subprocess

import datasets
from harness import SMALL, STREET, Skip, Trial, case, content_of


@case("umask", quick=True)
def umask(trial: Trial) -> None:
    trial.give_street()
    for mask in (0o077, 0o027, 0o022):
        for arguments in (
            [*STREET, "-o", "out.log"],
            ["export", "s.scene", "-o", "out.ply"],
            ["render", "s.scene", "--sensor", "front", "--times", "0:0:1", "-o", "out"],
            [
                "train",
                "s.log",
                "-o",
                "out.scene",
                "--iterations",
                "1",
                "--checkpoint-every",
                "1",
                "--report",
                "out.html",
                "--tensorboard",
                "events",
                *SMALL,
            ],
        ):
            trial.works(*arguments, umask=mask)
        for path in trial.folder.rglob("*"):
            if "out" not in path.relative_to(trial.folder).parts[0] or path.is_symlink():
                continue
            mode = path.stat().st_mode & 0o777
            wanted = (0o777 if path.is_dir() else 0o666) & ~mask
            trial.check(mode == wanted, f"{path.name}: {mode:o}, umask {mask:o} wants {wanted:o}")
        trial.clear("s.log", "s.scene")


@case("locale")
def locale(trial: Trial) -> None:
    known = subprocess.run(["locale", "-a"], capture_output=True, text=True, check=False).stdout.split()
    commas = [name for name in known if name.startswith(("de_", "fr_", "it_", "es_"))]
    if not commas:
        raise Skip("no locale with a decimal comma is installed")
    trial.give_street()
    commands = (
        [*STREET, "-o", "out.log"],
        ["train", "s.log", "-o", "out.scene", "--iterations", "5", *SMALL],
        ["render", "s.scene", "--sensor", "top", "--times", "0:0:1", "-o", "out"],
        ["export", "s.scene", "-o", "out.ply"],
    )
    found = []
    for name in ("C", commas[0]):
        said = [trial.works("--json", "info", "s.log", environment={"LC_ALL": name}).out]
        for arguments in commands:
            trial.works(*arguments, environment={"LC_ALL": name})
        found.append((said, content_of(trial.folder)))
        trial.clear("s.log", "s.scene")
    trial.check(found[0] == found[1], f"{commas[0]}: other bits than in C")


@case("line ends and byte order marks", quick=True)
def line_ends(trial: Trial) -> None:
    """Text files as an editor of another system saves them."""
    trial.give_street()
    imports = datasets.imports(trial)
    if trial.options.quick:
        imports = {name: imports[name] for name in ("points", "colmap")}
    for name, arguments in imports.items():
        trial.works(*arguments)
        right = content_of(trial.folder / "out.log")
        shutil.rmtree(trial.folder / "out.log")
        files = [p for p in (trial.folder / name).rglob("*") if p.suffix in (".txt", ".json")]
        saved = {file: file.read_bytes() for file in files}
        for file, text in saved.items():
            mark = b"\xef\xbb\xbf" if file.suffix == ".json" else b""
            file.write_bytes(mark + text.replace(b"\n", b"\r\n"))
        outcome = trial.run("--json", *arguments)
        same = outcome.code == 0 and content_of(trial.folder / "out.log") == right
        trial.check(same, f"{name} with CRLF: {outcome.told()}")
        shutil.rmtree(trial.folder / "out.log", ignore_errors=True)
        for file, text in saved.items():
            file.write_bytes(text)
    for folder, file in (("s.log", "log.json"), ("s.scene", "scene.json")):
        path = trial.folder / folder / file
        right_info = trial.works("info", folder, "--json").out
        path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
        outcome = trial.run("info", folder, "--json")
        trial.check(outcome.out == right_info, f"{folder} with CRLF: {outcome.told()}")


@case("times out of order", quick=True)
def times(trial: Trial) -> None:
    """Refused by the name of a file that is the user's, or told what was left out."""
    arguments = datasets.kitti(trial.folder / "kitti", trial)
    for file in (
        "image_02/timestamps.txt",
        "velodyne_points/timestamps.txt",
        "oxts/timestamps.txt",
        "velodyne_points/timestamps_start.txt",
    ):
        path = trial.folder / arguments[2] / file
        whole = path.read_text()
        lines = whole.splitlines(keepends=True)
        path.write_text("".join([lines[1], lines[0], *lines[2:]]))
        outcome = trial.refused(*arguments, says="kitti/", may_work=True)
        trial.check(".tmp" not in outcome.err, f"{file}: names a temporary file: {outcome.told()}")
        if outcome.code == 0:
            trial.check("left out" in outcome.err, f"{file}: does not say what was left out: {outcome.told()}")
            shutil.rmtree(trial.folder / arguments[-1])
        path.write_text(whole)
    arguments = datasets.points(trial.folder / "points")
    path = trial.folder / "points/points.json"
    value = json.loads(path.read_text())
    value["sweeps"].reverse()
    path.write_text(json.dumps(value))
    outcome = trial.refused(*arguments, may_work=True)
    trial.check(".tmp" not in outcome.err, f"names a temporary file: {outcome.told()}")


@case("what a log holds is told", quick=True)
def info(trial: Trial) -> None:
    trial.give_street()
    for target in ("s.log", "s.scene"):
        trial.check("car" in trial.works("info", target).out, f"info {target} names no actor")
        said = json.loads(trial.works("info", target, "--json").out)
        trial.check("car" in json.dumps(said.get("actors")), f"info {target} --json names no actor")
