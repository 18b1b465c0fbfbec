// simuli_list_programs FOLDER: the text of every program of gpu_programs(), expanded, and programs.json.
#include <cstdio>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/core/base/error.hpp"
#include "host/device/runtime/declaration.hpp"
#include "host/device/runtime/source.hpp"
#include "tests/gpu_compile/gpu_programs.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "simuli_list_programs: found {} arguments, allowed one: a folder\n", argc - 1);
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  try {
    std::filesystem::create_directories(folder);
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const simuli::test::GpuProgram& program : simuli::test::gpu_programs()) {
      const std::string stem = std::filesystem::path(program.path).stem();
      const std::string text = simuli::expand_file(program.path);
      std::ofstream(folder / (stem + ".cl")) << text;
      nlohmann::ordered_json kernels = nlohmann::ordered_json::array();
      for (const auto& [name, declaration] : simuli::kernel_declarations(text)) kernels.push_back(name);
      list.push_back({{"name", program.name},
                      {"file", stem + ".cl"},
                      {"options", program.options.text()},
                      {"double", program.options.precision() == simuli::Precision::kDouble},
                      {"kernels", kernels}});
    }
    std::ofstream out(folder / "programs.json");
    out << list.dump(1) << '\n';
    out.close();
    if (!out) throw std::runtime_error((folder / "programs.json").string() + ": can't be written");
  } catch (const std::exception& error) {
    fmt::print(stderr, "simuli_list_programs: {}\n", error.what());
    return 1;
  }
}
