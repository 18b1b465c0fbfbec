#include "host/apps/cli/simuli.hpp"

#include "host/apps/cli/base/program.hpp"

namespace simuli::cli {
namespace {

void add_commands(CommandLine& line, const Globals& globals) {
  const Command root = line.root();
  root.require_command();
  add_actors(root, globals);
  add_align(root, globals);
  add_bench(line);
  add_completion(line);
  add_demo(root, globals);
  add_devices(root, globals);
  add_eval(root, globals);
  add_export(root, globals);
  add_fit(root, globals);
  add_import(root, globals);
  add_info(root, globals);
  add_manual(line);
  add_mask(root, globals);
  add_render(root, globals);
  add_serve(root, globals);
  add_synth(root, globals);
  add_train(root, globals);
  add_view(root, globals);
}

}  // namespace

int run_simuli(int argc, char** argv, const std::string& commit) {
  return run_program("simuli",
                     "Camera and LiDAR simulation with 3D Gaussians on any OpenCL device",
                     argc,
                     argv,
                     add_commands,
                     commit);
}

}  // namespace simuli::cli
