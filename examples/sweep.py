"""sweep.py SCENE LIDAR: one turn of any LiDAR on the recorded path, as a range picture (range.png)."""
import sys

import numpy as np
import simuli

scene = simuli.Scene(sys.argv[1])
start_s, end_s = scene.span
sweep = scene.render(sys.argv[2], time_s=start_s)
ranges = sweep.range_m
hit = ranges > 0
points = sweep.points_m[hit]
print(f"{hit.sum()} of {hit.size} rays of {sys.argv[2]} returned; nearest {ranges[hit].min():.2f} m")
print("they lie between", points.min(axis=0).round(1), "and", points.max(axis=0).round(1))

try:
    from matplotlib import pyplot
except ImportError:
    np.save("range.npy", ranges)
else:
    pyplot.imsave("range.png", np.where(hit, np.log(np.maximum(ranges, 0.1)), np.nan), cmap="turbo_r")
