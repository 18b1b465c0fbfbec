#!/usr/bin/env python3
"""Measures the size of the code base: lines by folder, settings, public headers, words of pages, included headers.

  bench/weight.py [COMMIT] [--build FOLDER] [--program SIMULI]

Lines are lines of tracked sources (C++, OpenCL C, Python, JavaScript, CMake, protocols), including blank lines and comments.
--build: a build folder of Ninja; adds the median and the maximum number of included own headers per unit.
--program: adds the keys of `train --set help`. Without COMMIT: the working tree as committed.
"""
import argparse
import re
import statistics
import subprocess

SOURCES = re.compile(r"\.(cpp|hpp|h|cl|py|pyi|js|css|html|proto|cmake|txt|c)$")
PRODUCT = ("cl", "host", "optim", "io")


def git(*arguments):
    return subprocess.run(["git", *arguments], capture_output=True, check=True).stdout


def text_of(commit, files):
    """Returns the text of each file at the commit, read by one process."""
    asked = "".join(f"{commit}:{file}\n" for file in files).encode()
    out = subprocess.run(["git", "cat-file", "--batch"], input=asked, capture_output=True, check=True).stdout
    texts, at = {}, 0
    for file in files:
        end = out.index(b"\n", at)
        size = int(out[at:end].split()[2])
        texts[file] = out[end + 1:end + 1 + size].decode("utf-8", "replace")
        at = end + 1 + size + 1
    return texts


def headers_of(build):
    """Returns the number of included own headers per unit, from the dependency database of Ninja."""
    listing = subprocess.run(["ninja", "-C", build, "-t", "deps"], capture_output=True, text=True, check=True).stdout
    counts = []
    for unit in listing.split("\n\n"):
        lines = unit.strip().split("\n")
        own = [line for line in lines[1:] if line.endswith((".hpp", ".h")) and not line.strip().startswith("/usr/")]
        if lines[0].split(":")[0].endswith(".o") and "Unity" not in lines[0]:
            counts.append(len(own))
    return counts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("commit", nargs="?", default="HEAD")
    parser.add_argument("--build")
    parser.add_argument("--program")
    args = parser.parse_args()
    listed = git("ls-tree", "-r", "--name-only", args.commit).decode().split("\n")[:-1]
    texts = text_of(args.commit, [f for f in listed if SOURCES.search(f) or f.endswith(".md")])
    lines = {f: t.count("\n") for f, t in texts.items() if SOURCES.search(f)}

    def total(folder):
        return sum(count for f, count in lines.items() if f.startswith(folder + "/"))

    print(f"{'lines':>8}  folder")
    for folder in (*PRODUCT, "tests", "bench", "examples"):
        print(f"{total(folder):8}  {folder}")
    print(f"{sum(map(total, PRODUCT)):8}  product ({', '.join(PRODUCT)})")
    print(f"{sum(len(t.split()) for f, t in texts.items() if f.endswith('.md')):8}  words of pages")
    print(f"{sum(f.endswith('.md') for f in texts):8}  pages")
    public = texts.get("host/apps/api/public.cmake") or texts.get("host/apps/api/public.cmake", "")
    print(f"{len(re.findall(r'[a-z0-9_/]+[.]hpp', public)):8}  public headers")
    if args.program:
        shown = subprocess.run([args.program, "train", "--set", "help"], capture_output=True, text=True, check=True).stdout
        print(f"{len(re.findall(r'^  [a-z][a-z0-9_.]*=', shown, re.M)):8}  settings that `train --set help` shows")
    if args.build:
        counts = headers_of(args.build)
        print(f"{statistics.median(counts):8.0f}  own headers of a unit, median; most {max(counts)} ({len(counts)} units)")


if __name__ == "__main__":
    main()
