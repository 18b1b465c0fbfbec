"""The viewer, before clients that mean it harm. Loopback alone, and a bounded number of requests."""

from __future__ import annotations

import contextlib
import http.client
import json
import os
import re
import select
import shutil
import signal
import socket
import subprocess
import threading
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from harness import STARTED, Skip, Trial, case

VIEW = {
    "sensor": "front", "quality": "balanced", "time_s": 0.2, "width": 96, "forward_m": 0, "left_m": 0, "up_m": 0,
    "yaw_rad": 0, "pitch_rad": 0, "removed": [], "moved": {},
}  # fmt: skip
SOON_S = 5.0  # also where everything is slower
HOST = "127.0.0.1"


class Viewer:
    """`simuli view` on a free port."""

    def __init__(self, trial: Trial, *more: str) -> None:
        self.trial = trial
        self.log = open(trial.top / "view.txt", "w+b")  # noqa: SIM115  closed by close()
        self.process = subprocess.Popen(
            [trial.options.program, "view", "s.scene", "--port", "0", *more],
            cwd=trial.folder,
            env=trial.environment(),
            stdin=subprocess.DEVNULL,
            stdout=self.log,
            stderr=self.log,
            start_new_session=True,
        )
        STARTED.append(self.process)
        began = time.monotonic()
        found = None
        while found is None and self.process.poll() is None and time.monotonic() - began < 300:
            found = re.search(rb"http://127\.0\.0\.1:(\d+)", self.said())
            time.sleep(0.05)
        if found is None:
            raise Skip(f"the viewer did not start: {self.said()[-300:]!r}")
        self.port = int(found.group(1))

    def said(self) -> bytes:
        return Path(self.log.name).read_bytes()

    def memory_mb(self) -> float:
        status = Path(f"/proc/{self.process.pid}/status").read_text()
        return int(re.search(r"VmRSS:\s+(\d+)", status).group(1)) / 1024  # type: ignore[union-attr]

    def ask(
        self,
        method: str,
        path: str,
        body: bytes | str | None = None,
        headers: dict[str, str] | None = None,
        limit_s: float = 60.0,
    ) -> tuple[int, bytes]:
        """Status and body; status 0 where the connection ended without a reply."""
        connection = http.client.HTTPConnection(HOST, self.port, timeout=limit_s)
        try:
            connection.request(method, path, body, headers or {})
            reply = connection.getresponse()
            return reply.status, reply.read()
        except (OSError, http.client.HTTPException):
            return 0, b""
        finally:
            connection.close()

    def picture(self, **changes: object) -> int:
        return self.ask(
            "POST", "/api/picture", json.dumps({**VIEW, **changes}), {"Content-Type": "application/json"}
        )[0]

    def soon(self, told: str) -> None:
        began = time.monotonic()
        status, _ = self.ask("GET", "/api/status", limit_s=30.0)
        took = time.monotonic() - began
        self.trial.check(status == 200 and took < SOON_S, f"{told}: next reply {status} after {took:.1f} s")

    def raw(self, data: bytes, limit_s: float = 15.0) -> bytes:
        """The first bytes of what is said to these."""
        with contextlib.suppress(OSError), socket.create_connection((HOST, self.port), timeout=limit_s) as connection:
            with contextlib.suppress(OSError):
                connection.sendall(data)
            if select.select([connection], [], [], limit_s)[0]:
                return connection.recv(64)
        return b""

    def end(self, number: int = signal.SIGTERM) -> int:
        """The exit code, or minus the signal; of a viewer that doesn't end a SIGKILL's."""
        self.process.send_signal(number)
        try:
            return self.process.wait(30)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            return -99
        finally:
            self.log.close()


@contextlib.contextmanager
def viewing(trial: Trial, *more: str) -> Iterator[Viewer]:
    trial.give_street()
    viewer = Viewer(trial, *more)
    try:
        yield viewer
    finally:
        if viewer.process.poll() is None:
            code = viewer.end()
            trial.check(code in (0, -signal.SIGTERM), f"the end: {code}")
        else:
            trial.check(False, f"ended by itself: {viewer.process.returncode}, {viewer.said()[-300:]!r}")


def sockets(port: int, count: int) -> list[socket.socket]:
    opened = []
    for _ in range(count):
        with contextlib.suppress(OSError):
            opened.append(socket.create_connection((HOST, port), timeout=5))
    return opened


@case("viewer: idle and slow clients")
def idle_clients(trial: Trial) -> None:
    with viewing(trial) as viewer:
        viewer.picture()
        began_mb = viewer.memory_mb()
        idle = sockets(viewer.port, 500)
        viewer.soon(f"{len(idle)} idle clients")
        for client in idle[::2]:
            with contextlib.suppress(OSError):
                client.sendall(b"POST /api/picture HTTP/1.1\r\nHost: ")
        viewer.soon("half a header each")
        for client in idle:
            client.close()
        slow = sockets(viewer.port, 60)
        over = threading.Event()

        def trickle() -> None:
            while not over.wait(0.1):
                for client in slow:
                    with contextlib.suppress(OSError):
                        client.sendall(b"G")

        thread = threading.Thread(target=trickle)
        thread.start()
        for _ in range(3):
            viewer.soon("60 trickling clients")
        over.set()
        thread.join()
        for client in slow:
            client.close()
        # Readers that ask and never take the reply.
        lazy = sockets(viewer.port, 60)
        for client in lazy:
            with contextlib.suppress(OSError):
                client.sendall(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n" * 50)
        viewer.soon("60 clients that read nothing")
        for client in lazy:
            client.close()
        trial.result.figures |= {"idle": len(idle), "MB at the start": began_mb, "at the end": viewer.memory_mb()}


@case("viewer: a flood")
def flood(trial: Trial) -> None:
    with viewing(trial) as viewer:
        viewer.picture(sensor="front")
        began_mb = viewer.memory_mb()
        requests, at_once = 2000, 50

        def one(i: int) -> int:
            if i % 4 == 0:
                return viewer.ask("POST", "/api/picture", '{"sensor": 1}', {"Content-Type": "application/json"})[0]
            return viewer.picture(time_s=0.001 * (i % 500), sensor="front")

        began = time.monotonic()
        with ThreadPoolExecutor(at_once) as pool:
            statuses = Counter(pool.map(one, range(requests)))
        seconds = time.monotonic() - began
        trial.check(
            statuses == {200: requests * 3 // 4, 400: requests // 4}, f"{requests} requests: {dict(statuses)}"
        )
        viewer.soon("after a flood")
        ended_mb = viewer.memory_mb()
        trial.check(ended_mb < began_mb + 200, f"memory: {began_mb:.0f} MB before, {ended_mb:.0f} MB after")
        trial.result.figures |= {
            "requests": requests,
            "s": seconds,
            "MB at the start": began_mb,
            "at the end": ended_mb,
        }


@case("viewer: ended under load")
def ended(trial: Trial) -> None:
    for number in (signal.SIGTERM, signal.SIGINT):
        trial.give_street()
        viewer = Viewer(trial)
        viewer.picture()
        over = threading.Event()

        def load() -> None:
            while not over.is_set():  # noqa: B023
                viewer.picture()  # noqa: B023

        threads = [threading.Thread(target=load) for _ in range(8)]
        for thread in threads:
            thread.start()
        idle = sockets(viewer.port, 20)
        time.sleep(0.5)
        began = time.monotonic()
        code = viewer.end(number)
        over.set()
        for thread in threads:
            thread.join()
        for client in idle:
            client.close()
        took = time.monotonic() - began
        trial.check(code in (0, -number) and took < 10, f"{number.name}: exit code {code} after {took:.1f} s")
        shutil.rmtree(os.fspath(trial.top / "tmp"), ignore_errors=True)
