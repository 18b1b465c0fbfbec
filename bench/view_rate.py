"""Measures pictures per second of the viewer: view_rate.py URL CAMERA WIDTH [QUALITY]

URL: address of `simuli view SCENE`; CAMERA: a camera of the scene or a built-in camera. Requests 60 pictures along the
trajectory, one after the other as the page does in motion, and prints the times of the device and of the JPEG encoder and the rate.
"""
import json
import statistics
import struct
import sys
import time
import urllib.request

PICTURES = 60


def main(url, camera, width, quality="balanced"):
    scene = json.load(urllib.request.urlopen(url + "api/scene"))
    start, end = scene["time_start_s"], scene["time_end_s"]

    def picture(time_s):
        request = {"sensor": camera, "quality": quality, "time_s": time_s, "width": int(width), "forward_m": 0, "left_m": 0,
                   "up_m": 0, "yaw_rad": 0, "pitch_rad": 0, "removed": [], "moved": {}}
        reply = urllib.request.urlopen(urllib.request.Request(url + "api/picture", data=json.dumps(request).encode())).read()
        length, = struct.unpack("<I", reply[:4])
        return json.loads(reply[4:4 + length])

    picture(start)  # compiles
    begin = time.time()
    infos = [picture(start + (end - start) * i / PICTURES) for i in range(PICTURES)]
    seconds = time.time() - begin
    median = lambda key: statistics.median(info[key] for info in infos)
    print(f"{camera}, {width} px wide, {quality}: {PICTURES / seconds:.1f} pictures/s "
          f"(device {median('render_ms'):.1f} ms, JPEG {median('encode_ms'):.1f} ms)")


if __name__ == "__main__":
    if len(sys.argv) not in (4, 5):
        sys.exit(__doc__)
    main(*sys.argv[1:])
