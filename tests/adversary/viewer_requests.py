"""What clients say to the viewer: malformed requests, other sites' pages, wrong tokens, names of files."""

from __future__ import annotations

import http.client
import json

from harness import Trial, case
from viewer import HOST, VIEW, viewing


def bodies() -> list[bytes]:
    deep = b"[" * 500_000 + b"]" * 500_000
    view = json.dumps(VIEW).encode()
    out = [
        b"",
        b"{",
        b"[]",
        b"null",
        b'"',
        b"\xff\xfe",
        b"{}",
        deep,
        b'{"a":' * 150_000,
        view[:-1],
        view + b"x",
        b"\0" * 100,
        b'{"sensor":"front"}',
    ]
    for key in VIEW:
        for value in (None, -1, 1e308, [], {}, "x" * 100_000, "../../etc/passwd", True, [[[]]], 2**63):
            out.append(json.dumps({**VIEW, key: value}).encode())
    return out


@case("viewer: malformed requests")
def malformed(trial: Trial) -> None:
    with viewing(trial) as viewer:
        viewer.picture()
        for body in bodies():
            status, reply = viewer.ask("POST", "/api/picture", body, {"Content-Type": "application/json"})
            trial.check(status in (200, 400, 413), f"body {body[:80]!r}: {status} {reply[:200]!r}")
        head = b"POST /api/picture HTTP/1.1\r\nHost: 127.0.0.1\r\n"
        for data in (
            b"\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"\0" * 1000, b"GET /" + b"a" * 100_000 + b" HTTP/1.1\r\n\r\n",
            b"\x16\x03\x01\x02\0\x01\0\x01\xfc\x03\x03" + b"\0" * 500, b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n" + b"X: y\r\n" * 20_000 + b"\r\n",
            b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + b"y" * 1_000_000 + b"\r\n\r\n", head + b"Content-Length: -1\r\n\r\n",
            head + b"Content-Length: 1000000000\r\n\r\n" + b"x" * 1000, head + b"Content-Length: 99999999999999999999\r\n\r\n",
            head + b"Content-Length: 5\r\nContent-Length: 6\r\n\r\nabcde", head + b"Transfer-Encoding: chunked\r\n\r\nfffffffffffffff\r\n",
            head + b"Transfer-Encoding: chunked\r\n\r\n" + b"10000\r\n" + b"x" * 0x10000 + b"\r\n",
            head + b"Transfer-Encoding: chunked\r\n\r\n" + (b"8000\r\n" + b"x" * 0x8000 + b"\r\n") * 64 + b"0\r\n\r\n",
            head + b"Content-Encoding: gzip\r\nContent-Length: 3\r\n\r\nabc", head + b"Expect: 100-continue\r\nContent-Length: 2000000\r\n\r\n",
            b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nRange: bytes=0-,1-,2-,99999999999-\r\n\r\n",
            b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n",
            b"OPTIONS * HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", b"CONNECT example.org:443 HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n",
            b"DELETE / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        ):  # fmt: skip
            first = viewer.raw(data)
            trial.check(first == b"" or first.startswith(b"HTTP/1.1 "), f"{data[:60]!r}: {first!r}")
            trial.check(viewer.process.poll() is None, f"{data[:60]!r}: the viewer ended")
        for path in (
            "/../../etc/passwd",
            "/%2e%2e/%2e%2e/etc/passwd",
            "//etc/passwd",
            "/..%2f..%2fetc/passwd",
            "/page.js/../../x",
            "/%00",
            "/api/../../x",
            "/\\..\\x",
        ):
            status, reply = viewer.ask("GET", path)
            trial.check(status in (400, 403, 404, 301) and b"root:" not in reply, f"{path}: {status}")
        viewer.soon("after malformed requests")


@case("viewer: other hosts, origins and tokens")
def strangers(trial: Trial) -> None:
    with viewing(trial) as viewer:
        own = f"http://{HOST}:{viewer.port}"
        trial.check(viewer.ask("GET", "/api/scene", headers={"Origin": own})[0] == 200, "its own origin is refused")
        for host in (
            "example.org",
            "127.0.0.1.example.org",
            "localhost.example.org",
            "[::1].example.org",
            "127.0.0.1:example.org",
            "0.0.0.0",
            "",
            "127.0.0.1 example.org",
            "example.org:" + str(viewer.port),
        ):
            trial.check(
                viewer.ask("GET", "/api/scene", headers={"Host": host})[0] in (400, 403), f"host {host!r} is served"
            )
        for headers in (
            {"Origin": "http://localhost:1"},
            {"Origin": "null"},
            {"Origin": "https://example.org"},
            {"Origin": own + ".example.org"},
            {"Sec-Fetch-Site": "cross-site"},
            {"Sec-Fetch-Site": "same-site"},
        ):
            for path in ("/api/scene", "/api/status"):
                trial.check(viewer.ask("GET", path, headers=headers)[0] == 403, f"{headers} gets {path}")
            trial.check(
                viewer.ask("POST", "/api/picture", json.dumps(VIEW), headers)[0] == 403, f"{headers} gets a picture"
            )
    token = "correct horse battery"
    with viewing(trial, "--token", token) as viewer:
        for given in (
            None,
            "",
            "correct",
            token + "x",
            token[:-1],
            token.upper(),
            "x" * 60_000,
        ):
            headers = {} if given is None else {"X-Simuli-Token": given}
            status, _ = viewer.ask("GET", "/api/scene", headers=headers)
            trial.check(status in (0, 400, 401, 431), f"token {ascii(given)[:40]}: {status}")
            # Whether a body is read first.
            status, _ = viewer.ask("POST", "/api/picture", "[" * 1_000_000, headers)
            trial.check(status in (0, 400, 401, 413, 431), f"token {ascii(given)[:40]} with a body: {status}")
        trial.check(
            viewer.ask("GET", f"/api/scene?token={token.replace(' ', '%20')}")[0] in (200, 401), "token in a query"
        )
        trial.check(
            viewer.ask("GET", "/api/scene", headers={"X-Simuli-Token": token})[0] == 200, "the right token is refused"
        )
    trial.refused("view", "s.scene", "--host", "0.0.0.0", "--port", "0", codes={2}, says="--token")


@case("viewer: hostile names")
def names(trial: Trial) -> None:
    """They reach the page as data: the HTML never has them."""
    trial.give_street()
    path = trial.folder / "s.scene/scene.json"
    whole = path.read_text()
    for name in (
        "<script>alert(1)</script>",
        "</script><img src=x onerror=alert(1)>",
        "\"';--><svg onload=alert(1)>",
    ):
        if "/" in name:
            continue  # no name
        text = whole.replace('"name": "car"', '"name": ' + json.dumps(name)).replace('"front"', json.dumps(name))
        path.write_text(text)
        with viewing(trial) as viewer:
            status, page = viewer.ask("GET", "/")
            trial.check(status == 200 and name.encode() not in page, f"{name}: stands in the page")
            connection = http.client.HTTPConnection(HOST, viewer.port, timeout=30)
            connection.request("GET", "/")
            policy = connection.getresponse().headers.get("Content-Security-Policy", "")
            connection.close()
            trial.check("script-src" in policy or "default-src" in policy, f"policy: {policy!r}")
            trial.check("unsafe-inline" not in policy.split("style-src")[0], f"policy: {policy!r}")
            status, scene = viewer.ask("GET", "/api/scene")
            trial.check(
                status == 200 and name in json.dumps(json.loads(scene), ensure_ascii=False).replace('\\"', '"'),
                f"{name}: {scene[:200]!r}",
            )
    path.write_text(whole)
