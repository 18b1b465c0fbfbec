
# What the page calls the expected depth is the mean: the median of the same frame is another.
seen = render_alphas > 0.5
assert (expected_depth[seen] == frame.mean_depth_m[seen]).all() and (expected_depth[seen] != frame.depth_m[seen]).any()

# One particle at a known place, behind what docs/COMING_FROM.md shows: it is seen where K and viewmat put it.
point = np.array([6.0, -1.5, 1.0])
one = np.zeros((1, rows))
one[0, :3], one[0, 3:6], one[0, 6], one[0, 10] = point - scene.origin_m, np.log(0.02), 1.0, 6.0
scene.set_particles(one)
u, v, w = K @ (viewmat @ [*point, 1.0])[:3]
frame = scene.render(camera, world_from_sensor=np.linalg.inv(viewmat))
row, column = np.unravel_index(np.argmax(frame.opacity), frame.opacity.shape)
assert abs(column + 0.5 - u / w) <= 0.5 and abs(row + 0.5 - v / w) <= 0.5, (column, row, u / w, v / w)
weight = frame.opacity / frame.opacity.sum()
centre = [(weight * (np.arange(n) + 0.5).reshape(s)).sum() for n, s in ((width, (1, -1)), (height, (-1, 1)))]
assert np.allclose(centre, [u / w, v / w], atol=0.02), (centre, u / w, v / w)
assert abs(frame.depth_m[row, column] - w) < 0.02, (frame.depth_m[row, column], w)
