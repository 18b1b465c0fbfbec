"""The program from Python, for all that it does on the command line: imports, align, export, info, ...

    simuli.program.run("import", "kitti", "2011_09_26_drive_0013_sync", "-o", "drive.log")
    simuli.program.run("align", "drive.log", "--keep-path", "--camera", "front", as_json=True)["cameras"]
"""
import json
import os
import pathlib
import shutil
import subprocess

from simuli import Error


def path():
    """The program beside the package where it was built, else the one on the path. simuli.Error where there is none."""
    beside = pathlib.Path(__file__).parent / "bin" / "simuli"
    found = str(beside) if beside.exists() else shutil.which("simuli")
    if found is None:
        raise Error(f"simuli: found no program, allowed {beside} or one on the path")
    return found


def run(*arguments, as_json=False):
    """What `simuli ARGUMENTS` prints, with as_json the object that --json prints. simuli.Error with its line when it fails."""
    words = [path(), *(["--json"] if as_json else []), *(os.fspath(a) if isinstance(a, os.PathLike) else str(a) for a in arguments)]
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, errors="backslashreplace",
                          stdin=subprocess.DEVNULL)
    if done.returncode != 0:
        said = [line for line in done.stderr.splitlines() if line.startswith("simuli: ")]
        raise Error(said[-1][len("simuli: "):] if said else f"simuli: ended by {done.returncode}")
    return json.loads(done.stdout) if as_json else done.stdout
