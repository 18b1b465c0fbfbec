// project.cl - kernels/project.cl with the paper's box extents. Launcher: host/device/render/frame/project.cpp
#include "paper/unscented.h"
#include "kernels/project.cl"
