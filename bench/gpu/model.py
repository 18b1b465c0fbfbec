#!/usr/bin/env python3
"""What a frame should cost on a GPU that nobody here has: written down before it is measured, to be judged by it.

  bench/gpu/model.py STAGES.json [--card NAME] [--json]

STAGES.json: what `simuli bench --stages --json` wrote, on any device: how many particles a frame sees and how many pairs of a tile and a
particle it has come from there, and what each stage computes and moves at least.

A stage takes launches x the time of a launch, waits x the time of a read-back, and beside those the longer of its arithmetic over what the
card reaches of its peak, and its traffic over what it reaches of its bandwidth. What blending computes is counted as GPUs do it: all rays of
a tile look at all its particles, whoever is hit. Shares of peaks: REACHED, the same for all cards.
"""
import argparse
import json
import pathlib
import sys

TILE_RAYS = 256
# Operations of a ray that looks at a particle and of one that it changes (bench/render/roofline.cpp, camera at rest and with origins).
RESPOND, RESPOND_WITH_ORIGINS, BLEND, BLEND_BACKWARD = 24, 57, 31, 123
BYTES_PER_PAIR = 20  # of a pass of the sort: keys read twice, values once, both written
SORT_BITS, RANGE_BITS = 8, 32

# Peak float arithmetic and memory bandwidth as the vendors' data sheets have them; a launch and a read-back of a few bytes through an in-order
# OpenCL queue as drivers are known for.
CARDS = {
    "H100": {"tflop_s": 66.9, "gbyte_s": 3350.0, "launch_us": 4.0, "wait_us": 20.0},
    "RX 7900 XTX": {"tflop_s": 30.7, "gbyte_s": 960.0, "launch_us": 6.0, "wait_us": 35.0},  # without its dual issue
    "Arc A770": {"tflop_s": 19.7, "gbyte_s": 560.0, "launch_us": 8.0, "wait_us": 40.0},
}
# Of the peak: contraction is off, so that half of the arithmetic is no FMA (x 0.6); by registers a third to two thirds of the waves fit (the
# compile table), tiles are uneven and a wave waits for its slowest ray (x 0.5). Of the bandwidth: streams 70 %, gathers of 64 bytes 35 %.
REACHED = {"project": (0.25, 0.7), "bin": (1.0, 0.35), "sort": (1.0, 0.5), "blend": (0.3, 0.35), "blend_backward": (0.2, 0.35),
           "project_backward": (0.2, 0.5)}


def sort_passes(bits):
    return -(-bits // SORT_BITS)


def launches(tiles):
    """(launches, waits) of each stage: counted in the launchers (host/device/render/frame, host/device/render/device)."""
    passes = sort_passes(RANGE_BITS) + sort_passes(max(1, (tiles - 1).bit_length()))
    return {"rays": (1, 0), "project": (2, 0), "bin": (5 + 4, 1), "sort": (4 * passes, 0), "blend": (1, 0), "blend_backward": (4, 0),
            "project_backward": (1, 0)}


def work_of(rows, base, moving):
    """GFLOP and GB of each stage, as a GPU does it."""
    def row(name):
        return rows[f"{base}/{name}"]
    work = {stage: [row(f"{stage}/arithmetic") * 1e-3 if f"{base}/{stage}/arithmetic" in rows else 0.0, row(f"{stage}/traffic") * 1e-3]
            for stage in REACHED}
    looked = row("instances") * TILE_RAYS
    respond = RESPOND_WITH_ORIGINS if moving else RESPOND
    work["blend"][0] = looked * (respond + BLEND) * 1e-9
    work["blend_backward"][0] = looked * (respond + BLEND_BACKWARD) * 1e-9
    tiles = int(row("rays_in_tiles")) // TILE_RAYS
    passes = row("visible") * sort_passes(RANGE_BITS) + row("instances") * sort_passes(max(1, (tiles - 1).bit_length()))
    work["sort"][1] = passes * BYTES_PER_PAIR * 1e-9
    return work, tiles


def predict(rows, base, card, moving=False):
    """{stage: ms} and what a frame and its backward pass take."""
    work, tiles = work_of(rows, base, moving)
    counts = launches(tiles)
    out = {}
    for stage, (calls, waits) in counts.items():
        gflop, gbyte = work.get(stage, (0.0, 0.0))
        of_flop, of_byte = REACHED.get(stage, (1.0, 0.7))
        busy_ms = max(gflop / (card["tflop_s"] * of_flop), 1e3 * gbyte / (card["gbyte_s"] * of_byte))
        out[stage] = busy_ms + 1e-3 * (calls * card["launch_us"] + waits * card["wait_us"])
    out["frame"] = sum(out[s] for s in ("rays", "project", "bin", "sort", "blend"))
    out["of it launches and waits"] = sum(1e-3 * (counts[s][0] * card["launch_us"] + counts[s][1] * card["wait_us"])
                                          for s in ("rays", "project", "bin", "sort", "blend"))
    out["backward"] = out["blend_backward"] + out["project_backward"]
    return out


def read_rows(file):
    return {row["name"]: row["value"] for row in json.loads(pathlib.Path(file).read_text())}


def bases(rows):
    found = sorted({name.rsplit("/", 1)[0] for name in rows if name.endswith("/instances")})
    if not found:
        sys.exit("model.py: found no rows \"stages/.../instances\", allowed what simuli bench --stages --json writes")
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stages", type=pathlib.Path)
    parser.add_argument("--card", choices=CARDS, action="append", help="again for more; default: all")
    parser.add_argument("--json", action="store_true")
    arguments = parser.parse_args()
    rows = read_rows(arguments.stages)
    cards = arguments.card or list(CARDS)
    predicted = {base: {card: predict(rows, base, CARDS[card]) for card in cards} for base in bases(rows)}
    if arguments.json:
        print(json.dumps(predicted, indent=2))
        return
    for base, by_card in predicted.items():
        print(f"{base}: milliseconds\n\n| stage | {' | '.join(cards)} |\n| --- |{' --- |' * len(cards)}")
        for stage in by_card[cards[0]]:
            print(f"| {stage} | {' | '.join(f'{by_card[card][stage]:.3f}' for card in cards)} |")
        print()


if __name__ == "__main__":
    main()
