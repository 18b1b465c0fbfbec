"""Forks, threads, Ctrl-C and exits, as Python programs have them: processes_test.py SCENE LOG"""
import os
import subprocess
import sys
import time

scene_folder, log = sys.argv[1:3]


def child(code, timeout=120, environment=None):
    """What a program prints, with (return code, seconds)."""
    begin = time.time()
    done = subprocess.run([sys.executable, "-c", "import simuli, sys, os, threading, time, signal\n" + code, scene_folder, log],
                          capture_output=True, text=True, timeout=timeout, env={**os.environ, **(environment or {})})
    return done.stdout + done.stderr, done.returncode, time.time() - begin


# A child of fork() refuses whatever needs the device that its parent had, at once, and ends as usual.
said, rc, _ = child("""
scene = simuli.Scene(sys.argv[1])
(name, *_) = scene.cameras
frame = scene.render(name, time_s=scene.span[0])
frame.image
device = simuli.Device()
stop = []
def work():
    while not stop: scene.render(name, time_s=scene.span[0]).image
busy = threading.Thread(target=work, daemon=True); busy.start()
calls = [lambda: scene.render(name, time_s=scene.span[0]), lambda: simuli.Scene(sys.argv[1]), lambda: simuli.devices(),
         lambda: simuli.Device(), lambda: frame.depth_m, lambda: simuli.evaluate(sys.argv[1], sys.argv[2])]
for _ in range(5):
    pid = os.fork()
    if pid == 0:
        signal.alarm(20)
        refused = 0
        for call in calls[:4] + calls[5:]:
            try: call()
            except simuli.Error as error: refused += "use the spawn start method" in str(error)
        del frame, scene
        sys.exit(0 if refused == 5 else 3)
    status = os.waitpid(pid, 0)[1]
    assert status == 0, status
stop.append(1); busy.join()
print("right", float(scene.render(name, time_s=scene.span[0]).image.mean()) > 0)
""")
assert rc == 0 and "right True" in said, (rc, said)

# Files need no device: a log that the parent has read is read in a child, too.
said, rc, _ = child("""
def read():
    log = simuli.Log(sys.argv[2])
    return sum(float(log.image(name, 0).sum()) for name in log.cameras) + sum(float(log.sweep(name, 0)["range_m"].sum()) for name in log.lidars)
scene, right = simuli.Scene(sys.argv[1]), read()
pid = os.fork()
if pid == 0:
    signal.alarm(20)
    os._exit(0 if read() == right else 3)
assert os.waitpid(pid, 0)[1] == 0
""")
assert rc == 0, (rc, said)

# Devices opened first by threads, all at once.
for _ in range(5):
    said, rc, _ = child("""
threads = [threading.Thread(target=lambda: sys.stdout.write(f"{len(simuli.Device().name) > 0}\\n")) for _ in range(8)]
[t.start() for t in threads]; [t.join() for t in threads]
""")
    assert rc == 0 and said.split() == ["True"] * 8, (rc, said)

# Daemon threads that are in the library when the interpreter goes.
for call in ("simuli.Scene(sys.argv[1])", "scene.render(name, time_s=scene.span[0]).image",
             "simuli.train(sys.argv[2], '/nowhere/x.scene')"):
    said, rc, seconds = child(f"""
scene = simuli.Scene(sys.argv[1])
(name, *_) = scene.cameras
def work():
    while True: {call}
for _ in range(2): threading.Thread(target=work, daemon=True).start()
time.sleep(0.7)
""")
    assert rc == 0 and "terminate" not in said, (call, rc, said)

# Ctrl-C is heard wherever a training or an evaluation is, while what a frame shows is worked out, and while another
# thread has the device.
large = "scene.render(simuli.camera('large', 4000, 3000, 2000, 2000, 2000, 1500), time_s=scene.span[0])"
train = "simuli.train(sys.argv[2], '/nowhere/x.scene')"
for first, call in (("", train), ("", "simuli.evaluate(sys.argv[1], sys.argv[2])"), ("", large + ".image"),
                    (f"frame = {large}; frame.image", "frame.normals"),
                    ("scene = simuli.Scene(sys.argv[1], device=device); threading.Thread(daemon=True, target="
                     f"lambda: {train[:-1]}, device=device)).start(); time.sleep(0.5)", "scene.render(name, time_s=scene.span[0])")):
    for after in (0.05, 0.3, 0.8):
        said, rc, _ = child(f"""
scene = simuli.Scene(sys.argv[1])
(name, *_) = scene.cameras
device = simuli.Device()
{first}
sent = []
def interrupt():
    sent.append(time.time()); os.kill(os.getpid(), signal.SIGINT)
try:
    threading.Timer({after}, interrupt).start()
    while True: {call}
except KeyboardInterrupt: print("heard", time.time() - sent[0])
""")
        assert rc == 0 and said.startswith("heard"), (call, rc, said)
        print(call, after, said.strip())
        assert float(said.split()[1]) < 2, said  # 0.5 s on a quiet machine
