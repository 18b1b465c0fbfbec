"""agree_test.py SOURCE: pages agree with each other and with the tree.

Lines have at most 120 characters (rows of tables may have more); links, paths, sections and keys of settings that
pages name exist; numbers that stand in several pages are the same in all of them.
"""
import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1]).resolve()
pages = {file.stem: file for file in [source / "README.md", *source.glob("docs/*.md"), *source.glob("bench/*.md")]}
pages["tests"] = source / "tests/README.md"
pages |= {name: source / f"{name}.md" for name in ("CHANGELOG", "CONTRIBUTING")}
words = {name: " ".join(file.read_text().split()) for name, file in pages.items()}
wrong = []

# Groups of an expression are the same wherever it matches, and it matches in each of the pages.
SAME = {
    "boxes": (r"(\d\.\d+) \(camera\) and (\d\.\d+) \(LiDAR\) (?:of the time of exact ext|of balanced's|times as long)",
              ["DECISIONS", "DEVELOPING", "METHOD", "RESULTS"]),
    "anchoring": (r"[Aa]nchoring adds (\d\.\d+) dB|L_anchor\): (\d\.\d+) dB", ["DECISIONS", "METHOD"]),
    "tiles": (r"within (\d+) % of the (?:best|fastest) of the paper's grid", ["DECISIONS", "METHOD", "RESULTS"]),
    "fox": (r"(26\.\d) dB, (?:SSIM )?(0\.\d+)", ["COMING_FROM", "RESULTS"]),
    "a frame": (r"(\d\.\d) (?:ms, a sweep of 64 x 2650 rays|\(26 MP/s\) \|) (\d+\.\d)", ["README", "RESULTS"]),
}
# Columns of README's table, and where RESULTS has them.
NUMBERS = [
    ("PSNR dB / SSIM", r"PSNR, dB; SSIM \|", r"(\d+\.\d) dB, SSIM (\d\.\d+)"),
    ("LiDAR distance error, median", r"median distance error, cm \|", r"LiDAR median (\d\.\d+) cm"),
    ("ray-drop decisions right", r"right drop decisions \(every ray returns\) \|",
     r"right drops (\d\.\d+) \((\d\.\d+) if every ray returned"),
]
GROUPS = ("actors anchor appearance camera chunk densify depth fixer init lidar loss off_trajectory path prune "
          "ray_drop render shards").split()
KEY = rf"(?<![\w.])((?:{'|'.join(GROUPS)})\.[a-z_0-9.]*[a-z_0-9])\b"
FILE = r"\.(?:json|log|scene|ply|png|npz|h|hpp|cpp|cl|py|exr|mcap)$"
FOLDERS = ("bench/", "cl/", "docs/", "examples/", "host/", "io/", "optim/", "tests/")


def check(ok, text):
    if not ok:
        wrong.append(text)


def numbers(text):
    return re.findall(r"\d+(?:\.\d+)?", text)


def titles(name):
    text = pages[name].read_text()
    return set(re.findall(r"^#+ (.*)$", text, re.MULTILINE)) | set(re.findall(r"\*\*([^*]+?)\.?\*\*", text))


def check_sections(name, text):
    """Sections that a page or a comment of the code names."""
    for other, title in re.findall(r"\b([A-Z_]{4,})(?:\.md)?[`)\]]*,? \"([^\"]+)\"", text):
        check(other not in pages or title in titles(other), f'{name}: {other} has no section "{title}"')
    for section in re.findall(r"METHOD(?:\.md)?[`)\]]*,? section (\d+)", text):
        known = any(title.startswith(f"{section}. ") for title in titles("METHOD"))
        check(known, f"{name}: METHOD has no section {section}")


keys = set()
for folder in ("bench", "cl", "host", "io", "optim"):
    for file in source.glob(f"{folder}/**/*"):
        if file.suffix in (".cl", ".cpp", ".h", ".hpp", ".py"):
            text = file.read_text()
            keys.update(re.findall(r'field\(\s*"([a-z0-9_.]+)"', text))
            check_sections(file.name, re.sub(r"\s+(?://+|#)?\s*", " ", text))
assert len(keys) > 20, "no settings found"

for name, file in sorted(pages.items()):
    text = file.read_text()
    for number, line in enumerate(text.splitlines(), 1):
        check(len(line) <= 120 or line.lstrip().startswith("|"), f"{file.name}:{number}: {len(line)} characters")
    fences = re.compile(r"^```.*?^```", re.MULTILINE | re.DOTALL)
    prose, fenced = fences.sub("", text), " ".join(fences.findall(text))
    for link in re.findall(r"\]\(([^)#]+)(?:#[^)]*)?\)", prose):
        check("://" in link or (file.parent / link).exists(), f"{file.name}: link {link}: no such file")
    quoted = [word for span in re.findall(r"`([^`\n]+)`", prose) for word in re.split(r"[\s,]+", span)]
    for word in quoted + re.split(r"[\s,()]+", fenced):
        path = word.rstrip(".:;)").removeprefix("./")
        if path.startswith(FOLDERS) and re.fullmatch(r"[\w./*+-]+", path):
            check(any(source.glob(path.rstrip("/"))), f"{file.name}: {path}: no such file")
    check_sections(file.name, words[name])
    if name not in ("CHANGELOG", "DECISIONS"):  # which name removed settings
        for key in re.findall(KEY, " ".join(quoted + re.findall(r"--set ([^`#]*)", text))):
            # A group alone, as in "prune.*", or the rates of either set, which share their fields.
            known = any(k == key or k.startswith(key + ".") for k in keys) or re.search(FILE, key)
            known = known or (key.startswith(("camera.", "lidar.")) and key.split(".", 1)[1] in keys)
            check(known, f"{file.name}: {key}: no such setting")

for what, (expression, where) in SAME.items():
    found = {name: {tuple(filter(None, m.groups())) for m in re.finditer(expression, words[name])} for name in pages}
    for name in where:
        check(found[name], f"{pages[name].name}: has no '{what}' ({expression})")
    check(len(set().union(*found.values())) <= 1, f"'{what}' differs: { {n: f for n, f in found.items() if f} }")

readme, results = pages["README"].read_text(), pages["RESULTS"].read_text()
for row, table, sentence in NUMBERS:
    ours = re.search(rf"^\| {row}[^|]*\| (.*) \|$", readme, re.MULTILINE)
    theirs = re.search(rf"^\| {table} (.*) \|$", results, re.MULTILINE)
    demo = re.search(sentence, words["RESULTS"])
    if ours and theirs and demo:
        cells = [numbers(cell) for cell in ours[1].split("|")]
        there = [list(demo.groups()), *(numbers(cell) for cell in theirs[1].split("|")[1:])]
        check(cells == there, f"README '{row}': {cells}, RESULTS {there}")
    else:
        wrong.append(f"README or RESULTS: no row '{row}'")

sys.exit("\n".join(wrong) or 0)
