#!/usr/bin/env python3
"""Predicts the time of a frame on GPUs from data sheets, before a measurement is available.

  bench/gpu/model.py STAGES.json [--card NAME] [--json]

STAGES.json: output of `simuli bench --stages --json` on any device: the numbers of visible particles and tile-particle pairs of a frame,
and the minimum arithmetic and traffic of each stage.

The time of a stage is launches x the time of a launch + waits x the time of a read-back + the maximum of arithmetic over the reached share of
the card's peak and traffic over the reached share of its bandwidth. The arithmetic of blending is counted as on GPUs: each ray of a tile
tests all particles of the tile. REACHED: shares of the peaks, the same for all cards.
"""
import argparse
import json
import pathlib
import sys

TILE_RAYS = 256
# Operations per tested particle of a ray and per particle that changes it (bench/render/roofline.cpp, camera at rest and with origins).
RESPOND, RESPOND_WITH_ORIGINS, BLEND, BLEND_BACKWARD = 24, 57, 31, 123
BYTES_PER_PAIR = 20  # per sort pass: keys are read twice, values once, both are written
SORT_BITS, RANGE_BITS = 8, 32

# Peak float arithmetic and memory bandwidth from the vendors' data sheets; typical times of a launch and of a read-back of a few bytes in an
# in-order OpenCL queue.
CARDS = {
    "H100": {"tflop_s": 66.9, "gbyte_s": 3350.0, "launch_us": 4.0, "wait_us": 20.0},
    "RX 7900 XTX": {"tflop_s": 30.7, "gbyte_s": 960.0, "launch_us": 6.0, "wait_us": 35.0},  # without its dual issue
    "Arc A770": {"tflop_s": 19.7, "gbyte_s": 560.0, "launch_us": 8.0, "wait_us": 40.0},
}
# Share of the peak: contraction is off, so half of the arithmetic is no FMA (x 0.6); registers limit occupancy to a third to two thirds (the
# compile table), tiles are uneven and a wave waits for its slowest ray (x 0.5). Share of the bandwidth: streams 70 %, gathers of 64 bytes 35 %.
REACHED = {"project": (0.25, 0.7), "bin": (1.0, 0.35), "sort": (1.0, 0.5), "blend": (0.3, 0.35), "blend_backward": (0.2, 0.35),
           "project_backward": (0.2, 0.5)}


def sort_passes(bits):
    return -(-bits // SORT_BITS)


def launches(tiles):
    """Returns (launches, waits) of each stage, counted in the launchers (host/device/render/frame, host/device/render/device)."""
    passes = sort_passes(RANGE_BITS) + sort_passes(max(1, (tiles - 1).bit_length()))
    return {"rays": (1, 0), "project": (2, 0), "bin": (5 + 4, 1), "sort": (4 * passes, 0), "blend": (1, 0), "blend_backward": (4, 0),
            "project_backward": (1, 0)}


def work_of(rows, base, moving):
    """Returns GFLOP and GB of each stage on a GPU."""
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
    """Returns {stage: ms} and the times of a frame and its backward pass."""
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
