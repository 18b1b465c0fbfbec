"""write_splats.py OUT.ply: a traffic cone of 3D Gaussians in the layout that every splat program reads.

Shows the conventions of the file: scales are logarithms, opacities logits, colours (colour - 0.5) / Y_00, rotations w, x, y, z; x is
right, y down, z forward. For instance: simuli view cone.ply; simuli render SCENE --add cone.ply:cone --move cone:15,1,0 -o with_cone
"""
import math
import struct
import sys

Y_00 = 0.28209479177387814
ORANGE, WHITE, BLACK = (0.95, 0.35, 0.05), (0.95, 0.95, 0.92), (0.08, 0.08, 0.09)
HEIGHT_M, RADIUS_M, RINGS, AROUND = 0.75, 0.17, 40, 36
PROPERTIES = ["x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
              "rot_0", "rot_1", "rot_2", "rot_3"]


def particle(right, up, forward, colour, scales_m, rotation=(1.0, 0.0, 0.0, 0.0), opacity=0.95):
    return [right, -up, forward, *((c - 0.5) / Y_00 for c in colour), math.log(opacity / (1.0 - opacity)),
            *(math.log(s) for s in scales_m), *rotation]


def cone():
    for ring in range(RINGS):
        share = (ring + 0.5) / RINGS
        radius = RADIUS_M * (1.0 - 0.85 * share)
        colour = WHITE if 0.30 < share < 0.50 or 0.68 < share < 0.82 else ORANGE
        for k in range(AROUND):
            angle = 2.0 * math.pi * k / AROUND
            # Flat: thin along its own z, which is turned about the vertical to look outwards.
            outwards = (math.cos(angle / 2), 0.0, math.sin(angle / 2), 0.0)
            wide = math.pi * radius / AROUND
            yield particle(radius * math.sin(angle), 0.03 + HEIGHT_M * share, radius * math.cos(angle), colour,
                           (1.1 * wide, 0.6 * HEIGHT_M / RINGS, 0.004), outwards)
    for i in range(16):
        for k in range(16):
            yield particle((i - 7.5) * 0.028, 0.02, (k - 7.5) * 0.028, BLACK, (0.018, 0.012, 0.018))


def main(out):
    rows = list(cone())
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}",
              *(f"property float {name}" for name in PROPERTIES), "end_header", ""]
    with open(out, "wb") as file:
        file.write("\n".join(header).encode())
        for row in rows:
            file.write(struct.pack(f"<{len(row)}f", *row))


if __name__ == "__main__":
    main(sys.argv[1])
