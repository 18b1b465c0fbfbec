#!/usr/bin/env python3
"""Packs the files of bench/gpu/run.py for a machine with only a driver, glibc and Python: bundle.py BIN FOLDER

FOLDER/bin contains the programs, FOLDER/lib their shared libraries (except glibc and OpenCL drivers), FOLDER/bench the scripts. Run on the machine:
  FOLDER/bench/gpu/run.py FOLDER/bin
The programs are scripts that set the library path; debugging symbols are removed.
"""
import pathlib
import shutil
import subprocess
import sys

from run import TESTS

PROGRAMS = ("simuli", "simuli-bench", *TESTS)
SCRIPTS = ("drivers.py", "tensor_reference.py", "gpu/run.py", "gpu/icd.py", "gpu/model.py", "gpu/gsplat_peer.py")
# Libraries that each machine has or must provide.
LEFT = ("linux-vdso.so", "ld-linux", "libc.so", "libm.so", "libpthread.so", "libdl.so", "librt.so", "libresolv.so")
LAUNCHER = """#!/bin/sh
here=$(dirname "$(readlink -f "$0")")
folders="$here/../lib"
# Drivers of a newer system need newer libraries than the packed ones: the system's come first if its C++ library is as new.
theirs=$(PATH="$PATH:/usr/sbin:/sbin" ldconfig -p 2>/dev/null | sed -n 's|.*x86-64.*=> \\(/.*\\)/libstdc++.so.6$|\\1|p' | head -n 1)
if [ -n "$theirs" ]; then
  oldest=$(printf '%s\\n' CPP "$(basename "$(readlink -f "$theirs/libstdc++.so.6")")" | sort -V | head -n 1)
  [ "$oldest" != CPP ] || folders="$theirs:$folders"
fi
LD_LIBRARY_PATH="$folders${LD_LIBRARY_PATH:+:$LD_LIBRARY_PATH}" exec "$here/../programs/NAME" "$@"
"""


def libraries(program):
    out = subprocess.run(["ldd", program], capture_output=True, text=True, check=True).stdout
    for line in out.splitlines():
        words = line.split()
        if "not found" in line:
            sys.exit(f"bundle.py: {program}: library {words[0]}: found none, allowed one that is installed")
        if "=>" in words and not words[0].startswith(LEFT):
            yield words[0], pathlib.Path(words[2])


def pack_libraries(program, folder):
    for library, path in libraries(program):
        if not (folder / library).exists():
            shutil.copy(path, folder / library)


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    programs, folder = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
    if folder.exists():
        sys.exit(f"bundle.py: FOLDER: found {folder}, allowed one that does not exist")
    for part in ("bin", "lib", "programs", "bench/gpu"):
        (folder / part).mkdir(parents=True)
    for name in PROGRAMS:
        if not (programs / name).is_file():
            sys.exit(f"bundle.py: BIN: found no {programs / name}, allowed a folder of built programs")
        packed = folder / "programs" / name
        subprocess.run(["strip", "-o", packed, programs / name], check=True)
        pack_libraries(programs / name, folder / "lib")
        cpp = next(path for library, path in libraries(programs / name) if library == "libstdc++.so.6")
        launcher = folder / "bin" / name
        launcher.write_text(LAUNCHER.replace("NAME", name).replace("CPP", cpp.resolve().name))
        launcher.chmod(0o755)
    for late in (programs.parent / "lib").glob("libsimuli_*.so.*"):  # loaded by the programs on demand
        shutil.copy(late, folder / "lib")
        pack_libraries(late, folder / "lib")
    here = pathlib.Path(__file__).resolve().parent.parent
    for script in SCRIPTS:
        shutil.copy(here / script, folder / "bench" / script)
    size = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    print(f"{folder}: {size / 1e6:.0f} MB")


if __name__ == "__main__":
    main()
