"""A context and queue of pyopencl's, and frames read through it: opencl_test.py SCENE"""
import sys

import numpy as np
import pyopencl as cl
import simuli

scene = simuli.Scene(sys.argv[1])
device = next(d for p in cl.get_platforms() for d in p.get_devices()
              if scene.device == f"{p.name.strip()} / {d.name.strip()}")
context = cl.Context([device])
queue = cl.CommandQueue(context)
there = simuli.Scene(sys.argv[1], device=simuli.Device.adopt(context, queue))
start_s, _ = scene.span
for name in (*scene.cameras, *scene.lidars):
    frame = there.render(name, time_s=start_s)
    memory = frame.memory
    ready = cl.Event.from_int_ptr(memory["ready"])

    def read(key, count, dtype):
        out = np.empty(count, dtype)
        cl.enqueue_copy(queue, out, cl.Buffer.from_int_ptr(memory[key]), wait_for=[ready])
        return out

    outputs = read("outputs", 6 * memory["slots"], memory["dtype"]).reshape(6, -1)
    slot_of_ray = read("slot_of_ray", memory["rays"], np.int32)
    assert (slot_of_ray >= 0).all()
    by_ray = outputs[:, slot_of_ray]
    assert np.array_equal(by_ray[3], frame.transmittance.ravel()), name
    assert np.array_equal(by_ray[4], frame.distance_sum_m.ravel()), name
    if memory["picture"] is None:
        assert np.array_equal(by_ray[:3].T, frame.feature.reshape(-1, 3)), name
    assert np.array_equal(frame.feature, scene.render(name, time_s=start_s).feature), name
    assert by_ray[3].min() < 0.5, name
for wrong in (None, 0, "queue"):
    try:
        simuli.Device.adopt(context, wrong)
    except simuli.Error as error:
        assert "queue" in str(error)
    else:
        raise AssertionError("nothing was raised")
