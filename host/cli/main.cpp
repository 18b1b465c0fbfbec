// simuli: the program.
#include "host/cli/base/program.hpp"

int main(int argc, char** argv) {
  using namespace simuli::cli;
  return run_program("simuli",
                     "Camera and LiDAR simulation with 3D Gaussians on any OpenCL device",
                     argc,
                     argv,
                     [](CommandLine& line, const Globals& globals) {
                       const Command root = line.root();
                       root.require_command();
                       add_align(root, globals);
                       add_bench(root, globals);
                       add_convert(root, globals);
                       add_demo(root, globals);
                       add_devices(root, globals);
                       add_eval(root, globals);
                       add_fit(root, globals);
                       add_import(root, globals);
                       add_info(root, globals);
                       add_render(root, globals);
                       add_synth(root, globals);
                       add_tile(root, globals);
                       add_train(root, globals);
                       add_view(root, globals);
                     });
}
