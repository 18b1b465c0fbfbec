// Command simuli bench: runs the program simuli-bench from the folder of this program.
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <string>
#include <system_error>
#include <unistd.h>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/refuse.hpp"
#include "host/core/base/error.hpp"
#include "io/base/file.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

std::string bench_program() {
  std::error_code ignored;  // without /proc there is no such program
  return (fs::read_symlink("/proc/self/exe", ignored).parent_path() / "simuli-bench").string();
}

[[noreturn]] void bench(const std::vector<std::string>& arguments) {
  const std::string program = bench_program();
  std::vector<char*> argv{const_cast<char*>(program.c_str())};  // execv() does not change the text
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  const int error = errno;
  if (!is_there(program)) {
    throw_usage_error("bench", fmt::format("no {}", program), "a build with -D SIMULI_BENCH=ON");
  }
  throw Error(ErrorKind::kInput, fmt::format("{}: {}", program, std::strerror(error)));
}

}  // namespace

void add_bench(CommandLine& line) {
  line.add_foreign(
      "bench", is_there(bench_program()) ? "measure times and the numbers of the paper's tables" : "", bench);
}

}  // namespace simuli::cli
