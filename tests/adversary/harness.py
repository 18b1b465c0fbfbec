"""Runs the program against a case, and looks at all that it may do wrong: exit code, messages, files, time."""

from __future__ import annotations

import hashlib
import os
import random
import re
import resource
import shutil
import subprocess
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

USAGE, INPUT, DEVICE, KERNEL, NUMERIC, INTERNAL, MEMORY, INTERRUPTED = 2, 3, 4, 5, 6, 70, 71, 75
REFUSED = frozenset({USAGE, INPUT, DEVICE, NUMERIC})
# No command of these sizes takes longer, where kernels must be compiled and other programs run, too.
LIMIT_S = 300.0
# A log of six frames, and a training that uses all that trainings can, in less than a second.
STREET = ["synth", "street", "--frames", "6", "--image-width", "64", "--image-height", "36", "--lidar-columns", "90"]
SMALL = ["--set", "init.voxel_m=0.3"]
# libpng tells its own errors itself.
PROGRESS = re.compile(r"^[a-z][a-z0-9 ]* +\d+( %|/)|^simuli: (note|warning): |^libpng (error|warning): ")

Argument = str | bytes | Path
# For whoever ends before they do.
STARTED: list[subprocess.Popen[bytes]] = []
Content = dict[str, str]


@dataclass
class Outcome:
    code: int  # minus the signal that ended it
    out: str
    err: str
    seconds: float
    timed_out: bool = False

    @property
    def lines(self) -> list[str]:
        """What stderr says beside progress, notes and warnings."""
        return [line for line in self.err.split("\n")[: self.err.count("\n")] if not PROGRESS.match(line)] + (
            [] if self.err.endswith("\n") or not self.err else [self.err.rsplit("\n", 1)[-1]]
        )

    def told(self) -> str:
        return f"exit code {self.code}, stderr {self.err[-300:]!r}" + (", did not end" if self.timed_out else "")


@dataclass
class Result:
    tries: int = 0
    failures: list[str] = field(default_factory=list)
    skipped: str = ""
    figures: dict[str, float] = field(default_factory=dict)
    seconds: float = 0.0


class Skip(Exception):
    """A case that can't be tried here, and why."""


@dataclass(frozen=True)
class Options:
    program: Path
    tries: int
    seed: int
    quick: bool


def content_of(path: Path) -> Content:
    """Checksum of each file below, by name; folders and links as what they are."""
    found: Content = {}
    for place, folders, files in os.walk(path):
        for name in folders + files:
            at = Path(place) / name
            key = os.fsdecode(at.relative_to(path))
            if at.is_symlink():
                found[key] = "link to " + os.readlink(at)
            elif at.is_dir():
                found[key] = "folder"
            elif at.is_file():
                found[key] = hashlib.sha256(at.read_bytes()).hexdigest()
            else:
                found[key] = "no regular file"
    return found


def difference(before: Content, after: Content) -> list[str]:
    """Names that came, went or changed."""
    return sorted(name for name in before.keys() | after.keys() if before.get(name) != after.get(name))


class Trial:
    """One case being tried: a folder of its own, three levels down, so that what climbs out of it is found."""

    def __init__(self, options: Options, scratch: Path, name: str, street: Path) -> None:
        self.options = options
        self.result = Result()
        self.random = random.Random(f"{options.seed} {name}")
        self.top = scratch / name
        self.folder = self.top / "a" / "b" / "c"
        self.street = street
        for path in (self.folder, self.top / "home", self.top / "tmp"):
            path.mkdir(parents=True)

    @property
    def tries(self) -> int:
        return self.options.tries

    def sample(self, all_of: Sequence[object], quick: int) -> list:
        """All of them, or some where time is short."""
        if not self.options.quick or len(all_of) <= quick:
            return list(all_of)
        return self.random.sample(list(all_of), quick)

    def environment(self, more: Mapping[str, str | None] | None = None) -> dict[str, str]:
        """HOME and TMPDIR are the case's own, so that what is written there is seen; caches are everybody's."""
        home = Path(os.environ.get("HOME", "/nonexistent"))
        variables: dict[str, str | None] = {
            "XDG_CACHE_HOME": os.environ.get("XDG_CACHE_HOME", str(home / ".cache")),
            "HOME": str(self.top / "home"),
            "TMPDIR": str(self.top / "tmp"),
            **(more or {}),
        }
        merged = {**os.environ, **{k: v for k, v in variables.items() if v is not None}}
        return {k: v for k, v in merged.items() if variables.get(k, "") is not None}

    def start(
        self,
        arguments: Sequence[Argument],
        environment: Mapping[str, str | None] | None = None,
        limits: Mapping[int, int] | None = None,
        umask: int = -1,
        stdout: int | None = None,
        before: Sequence[Argument] = (),
    ) -> subprocess.Popen[bytes]:
        def limit() -> None:
            for what, most in (limits or {}).items():
                resource.setrlimit(what, (most, most))

        process = subprocess.Popen(
            [*before, self.options.program, *arguments],
            cwd=self.folder,
            env=self.environment(environment),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE if stdout is None else stdout,
            stderr=subprocess.PIPE,
            preexec_fn=limit,
            restore_signals=False,
            umask=umask,
            start_new_session=True,
        )
        STARTED.append(process)
        return process

    def wait(self, process: subprocess.Popen[bytes], began: float, limit_s: float = LIMIT_S) -> Outcome:
        timed_out = False
        try:
            out, err = process.communicate(timeout=limit_s)
        except subprocess.TimeoutExpired:
            timed_out = True
            process.kill()
            out, err = process.communicate()
        return Outcome(
            process.returncode,
            os.fsdecode(out or b""),
            os.fsdecode(err),
            time.monotonic() - began,
            timed_out,
        )

    def run(self, *arguments: Argument, limit_s: float = LIMIT_S, **how: object) -> Outcome:
        began = time.monotonic()
        return self.wait(self.start(arguments, **how), began, limit_s)  # type: ignore[arg-type]

    def check(self, holds: bool, what: str) -> bool:
        self.result.tries += 1
        if not holds:
            self.result.failures.append(what)
        return holds

    def works(self, *arguments: Argument, **how: object) -> Outcome:
        """What has to succeed for the case to go on."""
        outcome = self.run(*arguments, **how)  # type: ignore[arg-type]
        if outcome.code != 0:
            raise RuntimeError(f"{shown(arguments)}: {outcome.told()}")
        return outcome

    def refused(
        self,
        *arguments: Argument,
        codes: Iterable[int] = REFUSED,
        says: str = "",
        may_work: bool = False,
        limit_s: float = LIMIT_S,
        **how: object,
    ) -> Outcome:
        """Ends with one of the codes and one line, and changes no file. `may_work`: or does what it should."""
        before = content_of(self.top)
        outcome = self.run("--json", *arguments, limit_s=limit_s, **how)  # type: ignore[arg-type]
        after = content_of(self.top)
        wrong = [] if says in outcome.err else [f"does not say {says!r}"]
        if outcome.code == 0 and may_work and not outcome.timed_out:
            self.check(True, "")
            return outcome
        if outcome.timed_out or outcome.code not in set(codes):
            wrong.append("wrong end")
        wrong += self.wrong_words(outcome)
        if before != after:
            wrong.append(f"files changed: {difference(before, after)[:5]}")
        self.check(not wrong, f"{shown(arguments)}: {'; '.join(wrong)}: {outcome.told()}")
        return outcome

    @staticmethod
    def wrong_words(outcome: Outcome) -> list[str]:
        """An error is one line, without control characters."""
        lines = outcome.lines
        wrong = []
        if len(lines) != 1 or not lines[0].startswith("simuli: "):
            wrong.append(f"{len(lines)} lines")
        if any(ord(c) < 32 and c != "\n" or 0x7F <= ord(c) < 0xA0 for c in outcome.err):
            wrong.append("control characters")
        if any(0x202A <= ord(c) <= 0x202E or 0x2066 <= ord(c) <= 0x2069 for c in outcome.err):
            wrong.append("direction marks")
        return wrong

    def give_street(self) -> None:
        """s.log and s.scene of the street."""
        for name in ("s.log", "s.scene"):
            if not (self.folder / name).exists():
                shutil.copytree(self.street / name, self.folder / name)

    def clear(self, *keep: str) -> None:
        for path in self.folder.iterdir():
            if path.name not in keep:
                remove(path)


def remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        for place, folders, _ in os.walk(path):
            for folder in folders:
                at = Path(place) / folder
                if not at.is_symlink():
                    at.chmod(0o700)
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def shown(arguments: Sequence[Argument]) -> str:
    text = " ".join(ascii(os.fsdecode(a))[1:-1] for a in arguments)
    return text if len(text) <= 200 else text[:200] + ".."


Case = Callable[[Trial], None]


@dataclass(frozen=True)
class Entry:
    name: str
    run: Case
    quick: bool


CASES: dict[str, Entry] = {}


def case(name: str, quick: bool = False) -> Callable[[Case], Case]:
    """Registers a case. `quick`: short enough for every run of the tests, and in none of the others."""

    def register(run: Case) -> Case:
        CASES[name] = Entry(name, run, quick)
        return run

    return register
