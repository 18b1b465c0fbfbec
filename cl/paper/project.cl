// project.cl - kernels/project.cl with the paper's box extents. Launcher: host/device/render/frame/project.cpp
// Bounds from projected points, which the kernels call:
#include "paper/unscented.h"
// The kernels:
#include "kernels/project.cl"
