"""python -m simuli ARGUMENTS: the program. The one beside the package where it was built, else the one on the path."""
import os
import sys

from simuli import Error, program


def main():
    try:
        found = program.path()
    except Error as error:
        sys.exit(str(error))
    os.execv(found, ["simuli", *sys.argv[1:]])


if __name__ == "__main__":
    main()
