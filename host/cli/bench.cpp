// simuli bench: the numbers the README claims, as commands.
#include <iostream>
#include <memory>

#include "bench/stages.hpp"
#include "host/base/error.hpp"
#include "host/cli/commands.hpp"

namespace simuli::cli {

void add_bench(CLI::App& app, const Globals& globals) {
  struct Options {
    bool stages = false;
    bench::StagesOptions stage_options;
  };
  auto options = std::make_shared<Options>();
  CLI::App* command = app.add_subcommand("bench", "measure: times of the stages of a frame");
  command->add_flag(
      "--stages", options->stages, "each stage of a camera and a LiDAR frame, forward and backward");
  command->add_option("--particles", options->stage_options.particles, "Gaussians of the synthetic street")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{16'000'000}))
      ->capture_default_str();
  command->add_option("--frames", options->stage_options.frames, "frames timed; the median is told")
      ->check(CLI::Range(5, 10'000))
      ->capture_default_str();
  command->callback([options, &globals] {
    if (!options->stages) throw Error(ErrorKind::kUsage, "bench: found no table, allowed --stages");
    const auto rows = bench::run_stages(
        globals.device, options->stage_options, [](const std::string& line) { std::cerr << line << '\n'; });
    std::cout << (globals.json ? bench::to_json(rows) : bench::to_text(rows));
  });
}

}  // namespace simuli::cli
