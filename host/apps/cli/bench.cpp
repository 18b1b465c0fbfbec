// simuli bench: runs simuli-bench, the program of the benches, which lies beside this one where it was built.
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

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void bench(const std::vector<std::string>& arguments) {
  const std::string program = (fs::read_symlink("/proc/self/exe").parent_path() / "simuli-bench").string();
  std::vector<char*> argv{const_cast<char*>(program.c_str())};  // execv's type; it changes nothing
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(program.c_str(), argv.data());
  const int error = errno;
  std::error_code ignored;
  if (!fs::exists(program, ignored)) {
    throw_usage_error("bench", fmt::format("no {}", program), "a build with -D SIMULI_BENCH=ON");
  }
  throw Error(ErrorKind::kInput, fmt::format("{}: {}", program, std::strerror(error)));
}

}  // namespace

void add_bench(CommandLine& line) {
  line.add_foreign("bench", "measure: times, and the numbers of the paper's tables", bench);
}

}  // namespace simuli::cli
