"""Our gradients against PyTorch's autograd of the formulas in bench/tensor_reference.py: tensor_gradients.py BENCH_FOLDER DUMP.json"""
import json
import sys

import torch

sys.path.insert(0, sys.argv[1])
import tensor_reference as reference

GROUPS = {"mean": (0, 3), "log-scale": (3, 6), "rotation": (6, 10), "opacity": (10, 11), "SH": (11, None)}

broken = []
for case in json.load(open(sys.argv[2])):
    p = reference.tensor(case["params"]).T.clone().requires_grad_()
    particles = {"mean": p[:, :3], "scale": p[:, 3:6].exp(), "rotation": reference.rotation(p[:, 6:10]),
                 "opacity": torch.sigmoid(p[:, 10]), "sh": p[:, 11:].unflatten(1, (-1, 3)), "degree": case["sh_degree"],
                 "clamped": case["clamped"]}
    take = lambda key: reference.tensor(case[key])
    feature, left, distance, _ = reference.render(particles, take("origins"), take("directions"), take("centre_m"), case["kappa"],
                                                  take("background"), case["t_min_m"], case["t_max_m"], by_range=True)
    seen = torch.cat([feature, left[:, None], distance[:, None]], 1)
    (take("weights") * seen).sum().backward()
    ours = take("gradient").T
    bound = 1e-9 if case["double"] else 2e-2
    for name, (first, last) in GROUPS.items():
        theirs = p.grad[:, first:last]
        error = float((ours[:, first:last] - theirs).abs().max() / theirs.abs().max())
        print(f"{case['name']:<15} {name:<10} largest {float(theirs.abs().max()):>10.4g}, error {error:.2g} of it (at most {bound:g})")
        if not error <= bound:
            broken.append(f"{case['name']} {name}")
if broken:
    sys.exit("tensor_gradients.py: bounds broken: " + ", ".join(broken))
