#!/usr/bin/env python3
"""Compiles the programs of simuli_list_programs with the compilers of GPU vendors, without a GPU.

  tests/gpu_compile/run.py [--install] [--targets T,...] [--all] [--filter TEXT] [--table FILE]

NVIDIA: the compiler of its driver and ptxas. AMD: clang's AMDGPU with AMD's device libraries. Intel: ocloc. --install unpacks them
below build/gpu_compile from the distribution's packages (apt-get download and dpkg -x, no root): installed properly,
Intel's would give every program on the machine a further OpenCL device. NVIDIA's is in Debian's non-free part, which is
asked for it alone. ptxas is taken from the PATH, from CUDA's folder, or, where there is pip, from NVIDIA's wheel. A
target without its compiler is skipped by name.

Without --all: of frames those at rest, moving and with actors, alone and with each order; all kernels.
Exit code 1: something does not compile, or is outside of the limits: in float programs no scratch memory and no spilled
registers, but for rays in orders of their own, whose windows and lists are scratch (OWN_ORDER); none in double programs
either of the backward pass of blending; at most 16 KiB of local memory (double: 32), no double in float programs.
NVIDIA's may have 32 bytes (64): ptxas spills as many where it would rather have more warps, and built-in sines have them for
large arguments. And no loop of NVIDIA's with a barrier may begin where another does (nvidia.py).
77: every target was skipped.
"""
import argparse
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import zipfile

import nvidia as nvidia_compiler

PROJECT = pathlib.Path(__file__).resolve().parents[2]
PACKAGES = """clang-19 libllvm19 libclang-cpp19 libclang-common-19-dev rocm-device-libs
intel-opencl-icd libigc1 libigdfcl1 libopencl-clang14 libigdgmm12 libllvm14 libclang-cpp14 libllvmspirvlib14""".split()
NON_FREE = "libnvidia-nvvm4"
WHEEL = "nvidia-cuda-nvcc-cu12"
NVIDIA, AMD, INTEL = ("sm_75", "sm_90"), ("gfx90a", "gfx1030"), ("dg2", "tgllp")
HOT = {"render", "render_bwd", "project", "project_bwd", "radix_count", "radix_scatter", "anchor_search",
       "loss_lidar"}  # those that had, or whose time a frame's is
OWN_ORDER = {"render_window", "replay_window", "render_per_ray", "replay_per_ray"}
MOST_LOCAL = 16384
SINE_DOUBLE = "0d3BF921FB54442D19"  # pi 2^-65
MOST_SCRATCH = {target: 32 for target in NVIDIA}


class Failed(Exception):
    pass


class Tools:
    """The compilers below a folder, and what is missing of them."""

    def __init__(self, folder):
        self.root = folder / "root"
        libraries = self.root / "usr/lib/x86_64-linux-gnu"
        clang = self.root / "usr/lib/llvm-19/bin/clang"
        self.clang = clang if clang.exists() else None
        self.nvvm = next(libraries.glob("**/libnvidia-nvvm.so.*.*"), None)
        self.device_libraries = libraries / "amdgcn/bitcode"
        self.ocloc = self.root / "usr/bin/ocloc"
        places = [shutil.which("ptxas"), "/usr/local/cuda/bin/ptxas", str(folder / "wheel/nvidia/cuda_nvcc/bin/ptxas")]
        self.ptxas = next((p for p in places if p and os.access(p, os.X_OK)), None)
        self.environment = dict(os.environ, LD_LIBRARY_PATH=f"{libraries}:{self.root}/usr/lib/llvm-19/lib")

    def missing(self, target):
        if target in NVIDIA:
            return [n for n, there in ((NON_FREE, self.nvvm), ("ptxas", self.ptxas)) if not there]
        if target in AMD:
            return [n for n, there in (("clang-19", self.clang), ("rocm-device-libs", self.device_libraries.exists())) if not there]
        return [] if self.ocloc.exists() else ["ocloc"]

    def run(self, *command):
        done = subprocess.run([str(c) for c in command], env=self.environment, capture_output=True, text=True, errors="replace")
        if done.returncode != 0:
            raise Failed((done.stderr or done.stdout).strip()[-1500:])
        return done.stdout + done.stderr


def non_free(folder):
    """apt-get's options for Debian's non-free part of this release, whose lists are fetched into the folder; none elsewhere."""
    release = dict(line.replace('"', "").split("=", 1) for line in pathlib.Path("/etc/os-release").read_text().splitlines() if "=" in line)
    if release.get("ID") != "debian":
        return []
    sources, lists = folder / "non_free.list", folder / "lists"
    (lists / "partial").mkdir(parents=True, exist_ok=True)
    sources.write_text("deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] http://deb.debian.org/debian "
                       f"{release['VERSION_CODENAME']} non-free\n")
    options = [f"-oDir::Etc::SourceList={sources}", "-oDir::Etc::SourceParts=/dev/null", f"-oDir::State::Lists={lists}"]
    subprocess.run(["apt-get", *options, "update"], capture_output=True, check=False)
    return options


def install(folder):
    packages = folder / "packages"
    packages.mkdir(parents=True, exist_ok=True)
    if shutil.which("apt-get"):
        for package in (*PACKAGES, NON_FREE):
            if not list(packages.glob(package + "_*.deb")):
                got = subprocess.run(["apt-get", *(non_free(packages) if package == NON_FREE else ()), "download", "-q", package],
                                     cwd=packages, capture_output=True, text=True)
                if got.returncode != 0:
                    print(f"gpu_compile: {package}: {got.stderr.strip().splitlines()[-1] if got.stderr else 'not found'}")
    for package in sorted(packages.glob("*.deb")):
        subprocess.run(["dpkg", "-x", package, folder / "root"], check=True)
    if Tools(folder).ptxas is None:
        got = subprocess.run([sys.executable, "-m", "pip", "download", "--no-deps", "-q", "-d", packages, WHEEL],
                             capture_output=True, text=True)
        for wheel in packages.glob("nvidia_cuda_nvcc*.whl"):
            zipfile.ZipFile(wheel).extractall(folder / "wheel")
            (folder / "wheel/nvidia/cuda_nvcc/bin/ptxas").chmod(0o755)
        if got.returncode != 0:
            print(f"gpu_compile: {WHEEL}: not found by pip")


def nvidia(tools, target, source, options, folder):
    ptx = folder / "program.ptx"
    tools.run(sys.executable, nvidia_compiler.__file__, tools.nvvm, source, ptx, target, *options)
    text = tools.run(tools.ptxas, "-v", f"-arch={target}", ptx, "-o", folder / "program.cubin")
    kernels = {}
    for part in text.split("Compiling entry function '")[1:]:
        stack, stores, loads = map(int, re.search(r"(\d+) bytes stack frame, (\d+) bytes spill stores, (\d+) bytes spill loads", part).groups())
        local = re.search(r"(\d+) bytes smem", part)
        registers = int(re.search(r"Used (\d+) registers", part).group(1))
        kernels[part.split("'")[0]] = {
            "registers": registers, "scratch": stack, "spills": stores + loads, "local": int(local.group(1)) if local else 0,
            "fp64": False, "heads": [], "occupancy": min(100, 100 * (65536 // (-(-registers // 8) * 8 * 32)) // (32 if target == "sm_75" else 64))}
    code = re.sub(r"//.*", "", ptx.read_text())
    for part in code.split(".entry ")[1:]:
        # Three of each built-in sine, on its path for large arguments.
        kernels[re.match(r"\w+", part).group(0)]["fp64"] = \
            len(re.findall(r"^(?!.*\.reg).*\.f64\b", part, re.M)) > 3 * part.count(SINE_DOUBLE)
    for name, heads in nvidia_compiler.shared_heads(code).items():
        kernels[name]["heads"] = heads
    return kernels


def amd(tools, target, source, options, folder):
    code = folder / "program.s"
    text = tools.run(tools.clang, "-x", "cl", *options, "--target=amdgcn-amd-amdhsa", f"-mcpu={target}", "-mcode-object-version=5",
                     "-O3", f"--rocm-device-lib-path={tools.device_libraries}", "-Rpass-analysis=kernel-resource-usage", "-S",
                     source, "-o", code)
    kernels = {}
    for part in text.split("Function Name: ")[1:]:
        value = lambda name: int(re.search(re.escape(name) + r"[^:]*: (\d+)", part).group(1))
        kernels[re.match(r"\w+", part).group(0)] = {
            "registers": value("VGPRs") + (value("AGPRs") if "AGPRs" in part else 0), "scratch": value("ScratchSize"),
            "spills": value("VGPRs Spill"),  # those of SGPRs go to VGPRs
            "local": value("LDS Size"), "fp64": False,
            "occupancy": 100 * value("Occupancy") // (8 if target == "gfx90a" else 16)}
    for part in re.split(r"\n\t\.globl\t", code.read_text())[1:]:
        name = re.match(r"\w+", part).group(0)
        if name in kernels:
            kernels[name]["fp64"] = bool(re.search(r"\tv_\w+_f64", part.split(".end_amdhsa_kernel")[0]))
    return kernels


def section(binary, name):
    """Bytes of a section of an ELF64 file."""
    data = binary.read_bytes()
    offset, = struct.unpack_from("<Q", data, 0x28)
    count, names_at = struct.unpack_from("<HH", data, 0x3C)
    headers = [struct.unpack_from("<IIQQQQIIQQ", data, offset + 64 * i) for i in range(count)]
    names = data[headers[names_at][4]:headers[names_at][4] + headers[names_at][5]]
    for header in headers:
        if names[header[0]:names.index(b"\0", header[0])].decode() == name:
            return data[header[4]:header[4] + header[5]]
    raise Failed(f"{binary.name} has no section {name}")


def intel(tools, target, source, options, folder):
    device = {"dg2": "dg2-g10"}.get(target, target)
    text = tools.run(tools.ocloc, "compile", "-file", source, "-device", device, "-options", " ".join(options), "-internal_options",
                     "-cl-intel-allow-zebin", "-out_dir", folder)
    info = section(next(folder.glob("*.bin")), ".ze_info").decode().split("kernels_misc_info")[0]
    kernels = {}
    for part in info.split("  - name: ")[1:]:
        def value(name):
            found = re.search(name + r": +(\d+)", part)
            return int(found.group(1)) if found else 0
        buffers = re.findall(r"- type: +scratch\n.*?usage: +(\w+)\n.*?size: +(\d+)", part, re.S)
        private = sum(int(size) for usage, size in buffers if usage == "private_space")
        spills = sum(int(size) for usage, size in buffers if usage == "spill_fill_space")
        private += sum(int(size) for size in re.findall(r"- type: +global\n *usage: +private_space\n *size: +(\d+)", part))
        lanes = value("simd_size")
        # Older devices tell what a thread has of both, rounded up to a power of two.
        private += sum(int(size) // lanes for usage, size in buffers if usage == "single_space")
        kernels[part.split()[0]] = {"registers": lanes, "scratch": private, "spills": spills, "local": value("slm_size"),
                                    "fp64": False, "occupancy": 100 * lanes // 32}
    if "spill" in text and not any(k["spills"] for k in kernels.values()):
        for kernel in kernels.values():
            kernel["spills"] = 1  # said, not counted
    return kernels


def is_base(program):
    parts = [p for p in program["name"].split(", ") if p not in ("window", "per ray", "errors", "ray gradients", "double")]
    return len(parts) == 1


def compiled(tools, target, folder, program, done):
    """[(kernel, numbers)]; a text that was compiled before is not compiled again."""
    options = [o for o in program["options"].split() if o not in ("-cl-kernel-arg-info", "-w")] + ["-w"]
    source = folder / program["file"]
    plain = subprocess.run([tools.clang or "clang", "-E", "-P", "-x", "cl", *options, source], env=tools.environment,
                           capture_output=True, check=True).stdout
    key = hashlib.sha256(plain).hexdigest()
    if key not in done:
        with tempfile.TemporaryDirectory(prefix="simuli_gpu_compile_") as own:
            compile_for = nvidia if target in NVIDIA else amd if target in AMD else intel
            done[key] = compile_for(tools, target, source, options, pathlib.Path(own))
    return done[key]


def complaints(target, program, kernel, numbers):
    out = []
    wide = 2 if program["double"] else 1
    if kernel not in OWN_ORDER and (not program["double"] or kernel == "render_bwd"):
        if numbers["scratch"] > MOST_SCRATCH.get(target, 0) * wide:
            out.append(f"{numbers['scratch']} bytes of scratch")
        if numbers["spills"] and target not in MOST_SCRATCH:
            out.append(f"{numbers['spills']} spilled")
    if numbers["local"] > MOST_LOCAL * wide:
        out.append(f"{numbers['local']} bytes of local memory")
    if numbers["fp64"] and not program["double"]:
        out.append("double in a float program")
    if numbers.get("heads"):
        out.append(f"a loop with a barrier begins where another does: {', '.join(numbers['heads'])}")
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--install", action="store_true", help="unpack the compilers first")
    parser.add_argument("--targets", default=",".join(NVIDIA + AMD + INTEL))
    parser.add_argument("--all", action="store_true", help="every program, not the usual frames alone")
    parser.add_argument("--hot", action="store_true", help="kernels with limits alone")
    parser.add_argument("--filter", default="", help="only programs whose name or file has this text")
    parser.add_argument("--folder", type=pathlib.Path, default=PROJECT / "build/gpu_compile")
    parser.add_argument("--list", type=pathlib.Path, default=PROJECT / "build/dev/bin/simuli_list_programs")
    parser.add_argument("--table", type=pathlib.Path, help="Markdown file to write")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    targets = arguments.targets.split(",")
    for target in targets:
        if target not in NVIDIA + AMD + INTEL:
            parser.error(f"--targets: found {target}, allowed {', '.join(NVIDIA + AMD + INTEL)}")
    if arguments.install:
        install(arguments.folder)
    tools = Tools(arguments.folder)
    usable = []
    for target in targets:
        missing = tools.missing(target)
        if missing:
            print(f"skipped {target}: no {', '.join(missing)} (--install, or ./run gpu-compile, fetches them)")
        else:
            usable.append(target)
    if not usable:
        return 77
    rows, wrong = {}, 0
    with tempfile.TemporaryDirectory(prefix="simuli_programs_") as folder:
        folder = pathlib.Path(folder)
        subprocess.run([arguments.list, folder], check=True)
        programs = [p for p in json.loads((folder / "programs.json").read_text())
                    if (arguments.all or is_base(p)) and (not arguments.hot or HOT & set(p["kernels"])) and arguments.filter in f"{p['file']} {p['name']}"]
        for target in usable:
            done = {}
            # Intel's two have no double.
            fitting = [p for p in programs if not (p["double"] and target in INTEL)]
            with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
                jobs = [pool.submit(compiled, tools, target, folder, p, done) for p in fitting]
                for program, job in zip(fitting, jobs):
                    try:
                        for kernel, numbers in job.result().items():
                            rows.setdefault((program["file"], kernel, program["name"]), {})[target] = numbers
                            for complaint in complaints(target, program, kernel, numbers):
                                wrong += 1
                                print(f"{target}: {kernel}, {program['name']}: {complaint}")
                    except Failed as failure:
                        wrong += 1
                        print(f"{target}: {program['file']}, {program['name']} does not compile: {failure}")
            print(f"{target}: {len(fitting)} programs, {len(done)} different texts", flush=True)
    lines = ["| kernel | program | " + " | ".join(usable) + " |", "| --- | --- |" + " --- |" * len(usable)]
    for (_, kernel, name), of_targets in rows.items():
        cells = []
        for target in usable:
            n = of_targets.get(target)
            cells.append("-" if n is None else f"{n['registers']}, {n['scratch']}{'+' + str(n['spills']) if n['spills'] else ''}, {n['local']}, {n['occupancy']} %")
        lines.append(f"| {kernel} | {name} | " + " | ".join(cells) + " |")
    if arguments.table:
        arguments.table.write_text("\n".join(lines) + "\n")
    else:
        print("\n".join(lines))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
