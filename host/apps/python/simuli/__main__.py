"""python -m simuli ARGUMENTS: the program. The one beside the package where it was built, else the one on the path."""
import os
import pathlib
import shutil
import sys


def main():
    program = pathlib.Path(__file__).parent / "bin" / "simuli"
    found = str(program) if program.exists() else shutil.which("simuli")
    if found is None:
        sys.exit(f"simuli: found no program, allowed {program} or one on the path")
    os.execv(found, ["simuli", *sys.argv[1:]])


if __name__ == "__main__":
    main()
