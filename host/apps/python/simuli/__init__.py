"""Camera and LiDAR simulation with 3D Gaussians on any OpenCL device.

    scene = simuli.Scene("drive.scene")                 # a folder that `simuli train` or simuli.train() made
    frame = scene.render("front", time_s=0.5)           # a picture or a sweep, from where it was recorded
    frame.image, frame.depth_m                          # NumPy arrays on the frame's memory

The program of the same name is beside the module: `simuli`, or `python -m simuli`. Errors are simuli.Error, one line
each. Poses are 4 x 4 matrices; metres, radians, seconds; world z up, rig x forward and y left, camera z forward.
"""
from simuli import _simuli
from simuli._simuli import *  # noqa: F401,F403

__version__ = _simuli.__version__
__all__ = [name for name in dir(_simuli) if not name.startswith("_")]
