#!/usr/bin/env python3
"""Measures and tests simuli on a machine with a GPU, with one command and one page of results.

  bench/gpu/run.py BIN [-o FOLDER] [--device NAME] [--as-gpu] [--parts PART ...] [--frames N] [--limit SECONDS]

BIN     folder of the built programs (build/release/bin, build/dev/bin, or a folder made by bench/gpu/bundle.py)
FOLDER  page.md, page.json and the output of each program; default: gpu_page

Parts, in this order. A failed part is reported on the page and the others still run; the page is rewritten after each part, so an interrupted
run keeps its results:
  check      simuli devices --check: a known scene in float and double
  tests      the tests that run kernels, on this device: in as many concurrent shards as the processor has threads
  stages     simuli bench --stages, with the predictions of bench/gpu/model.py for its cards
  pictures   simuli bench --agreement: each ray compared with the processor's driver, if there is one
  training   simuli bench --training: an iteration by stage, memory
  street     simuli demo: the embedded street trained and scored, time
  trade      simuli bench --trade: speed and accuracy
  peers      gsplat's rasterisation of the same particles, in turns with simuli's, if PyTorch and gsplat are installed

--as-gpu treats the device as a GPU even if it is none: runs all GPU-only parts, for a rehearsal.
Drivers without an .icd file are searched in the vendors' usual folders. Exit code 1 on any failure.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent), str(HERE)]
import drivers  # noqa: E402
import icd  # noqa: E402
import model  # noqa: E402

PARTS = ("check", "tests", "stages", "pictures", "training", "street", "trade", "peers")
TESTS = ("simuli_runtime_tests", "simuli_cl_tests", "simuli_render_tests", "simuli_scene_tests", "simuli_optim_tests")


def markdown(columns, rows):
    lines = ["| " + " | ".join(columns) + " |", "|" + " --- |" * len(columns)]
    return "\n".join(lines + ["| " + " | ".join(str(cell) for cell in row) + " |" for row in rows])


def number(value):
    return f"{value:.4g}" if isinstance(value, float) else str(value)


class Page:
    """Results by part."""

    def __init__(self, folder):
        self.folder, self.data, self.texts = folder, {"parts": {}, "failures": []}, {}

    def add(self, part, seconds, data, text):
        self.data["parts"][part] = {"seconds": round(seconds, 1), "data": data}
        self.texts[part] = text
        self.write()

    def fail(self, part, reason):
        self.data["failures"].append(f"{part}: {reason}")
        self.write()

    def write(self):
        device = self.data.get("device", {})
        lines = [f"# simuli on {device.get('name', 'an unknown device')}", ""]
        lines += [f"{device.get('platform', '')}, driver {device.get('driver_version', '')}, "
                  f"{device.get('compute_units', '?')} compute units{', taken for a GPU' if self.data.get('as_gpu') else ''}; {self.data.get('version', '')}; "
                  f"processor {self.data.get('processor', '')}", ""]
        for part, text in self.texts.items():
            lines += [f"## {part} ({self.data['parts'][part]['seconds']:.0f} s)", text, ""]
        lines += ["## Failures", *(f"- {failure}" for failure in self.data["failures"] or ["none"]), ""]
        for name, text in (("page.md", "\n".join(lines)), ("page.json", json.dumps(self.data, indent=2) + "\n")):
            temporary = self.folder / (name + ".tmp")
            temporary.write_text(text)
            temporary.replace(self.folder / name)


class Bench:
    def __init__(self, arguments, page):
        self.arguments, self.page = arguments, page
        vendors = icd.vendors_folder(page.folder / "vendors")
        self.driver = drivers.Driver(["device", str(vendors) if vendors else "-"], arguments.bin.resolve(), page.folder)
        self.driver.limit_s = arguments.limit
        if arguments.device:
            self.driver.env["SIMULI_DEVICE"] = arguments.device

    def program(self, *words):
        """Returns the standard output of a program; raises on failure."""
        code, out = self.driver.run(*words)
        if code != 0:
            raise RuntimeError(self.driver.failures.pop())
        return out

    def rows(self, *words):
        return {row["name"]: row for row in json.loads(self.program("simuli", "bench", "--json", *words))}

    def row_table(self, rows):
        return markdown(("what", "value", "unit"), [(name, number(row["value"]), row.get("unit", "")) for name, row in rows.items()])

    def devices(self):
        found = json.loads(self.program("simuli", "devices", "--json"))
        wanted = self.arguments.device.lower()
        chosen = [d for d in found if d["usable"] and wanted in f"{d['platform']} / {d['name']}".lower()]
        if not chosen:
            raise RuntimeError(f"found no usable device named \"{self.arguments.device}\" among "
                               f"{', '.join(d['name'] for d in found) or 'none'}")
        if self.arguments.as_gpu:
            self.driver.env["SIMULI_DEVICE_TYPE"] = "gpu"
        return found, chosen[0]

    def check(self):
        code, out = self.driver.run("simuli", "devices", "--check", "--json")
        devices = json.loads(out) if out.startswith("[") else []
        if code != 0:
            self.page.fail("check", self.driver.failures.pop())
        return devices, markdown(("device", "check"), [(d["name"], d.get("check", "not usable")) for d in devices])

    def shard(self, program, index, count):
        """Returns (exit code, seconds, output) of a shard of a program's tests; most of the time is compilation."""
        begin = time.monotonic()
        code, text = self.driver.run(program, shard=(index, count))
        return code, time.monotonic() - begin, text

    def tests(self):
        table, data = [], {}
        count = max(1, (os.cpu_count() or 1) // len(TESTS))
        with concurrent.futures.ThreadPoolExecutor(len(TESTS) * count) as pool:
            jobs = {program: [pool.submit(self.shard, program, i, count) for i in range(count)] for program in TESTS}
        for program, of_program in jobs.items():
            shards = [job.result() for job in of_program]
            ended = {end: [name for *_, text in shards for name in re.findall(rf"^\[ *{end} *\] (\S+?),? .*\(\d+ ms\)$", text, re.M)]
                     for end in ("OK", "FAILED", "SKIPPED")}
            # Neither all passed (0) nor some failed (1): the last test crashed.
            cut = [f"exit code {code} in {(re.findall(r'^. RUN      . (.+)', text, re.M) or ['its start'])[-1]}"
                   for code, _, text in shards if code not in (0, 1)]
            data[program] = {"passed": len(ended["OK"]), "failed": ended["FAILED"], "skipped": len(ended["SKIPPED"]), "cut": cut}
            table.append((program, len(ended["OK"]), len(ended["FAILED"]), len(ended["SKIPPED"]), len(cut),
                          f"{max(seconds for _, seconds, _ in shards):.0f}"))
            for what in (*ended["FAILED"], *cut):
                self.page.fail("tests", f"{program}: {what}")
        self.driver.failures.clear()  # reported above, test by test
        return data, markdown(("program", "passed", "failed", "skipped", "shards cut", "seconds"), table)

    def stages(self):
        rows = self.rows("--stages", "--frames", str(self.arguments.frames))
        values = {name: row["value"] for name, row in rows.items()}
        device = self.page.data["device"]["name"]
        card = next((c for c in model.CARDS if re.sub(r"\W", "", c).lower() in re.sub(r"\W", "", device).lower()), None)
        cards = [card] if card else list(model.CARDS)
        text = []
        for base in model.bases(values):
            predicted = {c: model.predict(values, base, model.CARDS[c]) for c in cards}
            table = []
            for stage in (*model.launches(2), "frame"):
                measured = values.get(f"{base}/{stage}")
                table.append((stage, number(measured) if measured else "", *(f"{predicted[c][stage]:.3f}" for c in cards)))
            text += [f"{base}, ms:", "", markdown(("stage", "measured", *(f"predicted, {c}" for c in cards)), table), ""]
        return rows, "\n".join(text) + "\n" + self.row_table(rows)

    def pictures(self):
        processors = [d for d in self.page.data["devices"] if d["kind"] == "cpu" and d["usable"]]
        is_same = processors and processors[0]["name"] == self.page.data["device"]["name"]
        if not processors or (is_same and not self.arguments.as_gpu):
            return {}, "No other driver on the processor to compare with."
        reference = self.driver.work / "pictures.reference"
        chosen = {name: self.driver.env.pop(name) for name in ("SIMULI_DEVICE", "SIMULI_DEVICE_TYPE") if name in self.driver.env}
        self.driver.env["SIMULI_DEVICE"] = str(processors[0]["index"])
        try:
            self.rows("--agreement", str(reference))
        finally:
            self.driver.env.pop("SIMULI_DEVICE")
            self.driver.env.update(chosen)
        rows = self.rows("--agreement", str(reference))
        return rows, f"Against {processors[0]['name']}.\n\n" + self.row_table(rows)

    def training(self):
        rows = self.rows("--training")
        return rows, self.row_table(rows)

    def street(self):
        begin = time.monotonic()
        found = json.loads(self.program("simuli", "demo", "--json", "-o", str(self.driver.work / f"demo_{os.getpid()}")))
        seconds = time.monotonic() - begin
        scores = [(key, number(value)) for key, value in found.items() if isinstance(value, (int, float))]
        return found, f"{seconds:.0f} s in all.\n\n" + markdown(("score", "value"), scores)

    def trade(self):
        rows = self.rows("--trade")
        return rows, self.row_table(rows)

    def peers(self):
        peer = HERE / "gsplat_peer.py"
        command = [sys.executable, str(peer), str(self.driver.bin), "--json"]
        done = subprocess.run(command, env=self.driver.env, capture_output=True, text=True, check=False, timeout=self.arguments.limit)
        if done.returncode == 77:
            return {}, f"Left out: {done.stderr.strip().splitlines()[-1]}"
        if done.returncode != 0:
            raise RuntimeError((done.stderr.strip() or "no message").splitlines()[-1])
        found = json.loads(done.stdout)
        return found, markdown(("what", "value"), [(key, number(value)) for key, value in found.items()])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bin", type=pathlib.Path)
    parser.add_argument("-o", "--output", type=pathlib.Path, default=pathlib.Path("gpu_page"))
    parser.add_argument("--device", default="", help="part of its name; default: the best one")
    parser.add_argument("--as-gpu", action="store_true", help="take the device for a GPU though it is none")
    parser.add_argument("--parts", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--frames", type=int, default=21)
    parser.add_argument("--limit", type=int, default=3600, help="seconds that a program may take")
    arguments = parser.parse_args()
    if not (arguments.bin / "simuli").is_file():
        sys.exit(f"run.py: BIN: found no {arguments.bin / 'simuli'}, allowed a folder of built programs")
    if arguments.frames < 5:  # simuli bench's own limit
        sys.exit(f"run.py: --frames: found {arguments.frames}, allowed at least 5")
    arguments.output.mkdir(parents=True, exist_ok=True)
    page = Page(arguments.output.resolve())
    page.data["as_gpu"] = arguments.as_gpu
    bench = Bench(arguments, page)
    try:
        page.data["devices"], page.data["device"] = bench.devices()
        page.data["version"] = bench.program("simuli", "--version").strip().splitlines()[0]
    except (RuntimeError, json.JSONDecodeError) as error:
        sys.exit(f"run.py: devices: {error}")
    models = [line.split(":", 1)[1].strip() for line in pathlib.Path("/proc/cpuinfo").read_text().splitlines() if line.startswith("model name")]
    page.data["processor"] = f"{models[0] if models else 'unknown'}, {os.cpu_count()} threads"
    for part in PARTS:
        if part not in arguments.parts:
            continue
        print(f"{part} ...", file=sys.stderr, flush=True)
        begin = time.monotonic()
        try:
            data, text = getattr(bench, part)()
            page.add(part, time.monotonic() - begin, data, text)
        except (RuntimeError, OSError, ValueError, KeyError, subprocess.TimeoutExpired) as error:
            page.fail(part, error)
        print(f"{part}: {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)
    print(page.folder / "page.md")
    sys.exit(bool(page.data["failures"]))


if __name__ == "__main__":
    main()
