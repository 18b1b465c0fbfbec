"""package_test.py PROGRAM SOURCE BUILD MODULE CMAKE WORK: the versions that pip, apt, program and module tell, and what a wheel holds.

No wheel is made: what pyproject.toml names is put into WORK as its tool would, without compiling anything, and used from there.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib

program, source, build, module = (pathlib.Path(text).resolve() for text in sys.argv[1:5])
cmake, work = sys.argv[5], pathlib.Path(sys.argv[6]).resolve()


def output(*words, **more):
    return subprocess.run(words, capture_output=True, text=True, check=True, **more).stdout


project = tomllib.loads((source / "pyproject.toml").read_text())
how = project["tool"]["scikit-build"]
by_pip = re.search(how["metadata"]["version"]["regex"], (source / how["metadata"]["version"]["input"]).read_text())["value"]
versions = {
    "pip": by_pip,
    "apt": re.search(r'set\(CPACK_PACKAGE_VERSION "(.*)"\)', (build / "CPackConfig.cmake").read_text())[1],
    "simuli --version": output(program, "--version").split()[1],
    "simuli.__version__": output(sys.executable, "-c", "import simuli; print(simuli.__version__)",
                                 env={**os.environ, "PYTHONPATH": str(module)}).strip(),
}
assert len(set(versions.values())) == 1, versions

shutil.rmtree(work, ignore_errors=True)
wheel = work / "wheel"
for component in how["install"]["components"]:
    output(cmake, "--install", build, "--component", component, "--prefix", wheel, "--strip")
for package in how["wheel"]["packages"]:
    shutil.copytree(source / package, wheel / pathlib.Path(package).name, dirs_exist_ok=True,
                    ignore=shutil.ignore_patterns("__pycache__"))
held = {re.sub(r"\.cpython[^/]*\.so|\.so[.\d]*$", ".so", str(file.relative_to(wheel))) for file in wheel.rglob("*") if file.is_file()}
needed = {"simuli/__init__.py", "simuli/__init__.pyi", "simuli/__main__.py", "simuli/gym.py", "simuli/program.py",
          "simuli/torch.py", "simuli/py.typed", "simuli/_simuli.so", "simuli/bin/simuli",
          *(f"simuli/proto/{file.name}" for file in (source / "host/apps/serve/proto").glob("*.proto"))}
libraries = {"simuli/lib/libsimuli.so", "simuli/lib/libsimuli_pictures.so"}  # of builds that have them
assert needed <= held <= needed | libraries, (held - needed - libraries, needed - held)
command, entry = project["project"]["scripts"]["simuli"].split(":")
assert command == "simuli.__main__" and f"def {entry}(" in (wheel / "simuli/__main__.py").read_text(), command

# From there, with nothing of the build folder in reach: both write pictures, so that what is loaded late is found, too.
alone = {**os.environ, "PYTHONPATH": str(wheel)}
alone.pop("LD_LIBRARY_PATH", None)
output(sys.executable, "-m", "simuli", "synth", "street", "-o", work / "street.log", "--frames", "2", "--image-width", "32",
       "--image-height", "18", "--lidar-columns", "36", env=alone, cwd=work)
train = "import simuli; simuli.train('street.log', 'street.scene', settings=['iterations=1']); print(simuli.__file__)"
said = output(sys.executable, "-c", train, env=alone, cwd=work)
assert said.startswith(str(wheel)), said
for binary in (wheel / "simuli/bin/simuli", *(wheel / "simuli").glob("*.so")):
    paths = [line for line in output("objdump", "-p", binary).splitlines() if "RUNPATH" in line or "RPATH" in line]
    assert len(paths) == 1 and str(build) not in paths[0], (binary, paths)
shutil.rmtree(work)
