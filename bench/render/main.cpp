// Program simuli_bench: only the stage benchmark, for machines that can build only the core.
#include <cstdlib>
#include <exception>
#include <iostream>
#include <string>

#include "bench/render/stages.hpp"
#include "host/core/base/error.hpp"

int main(int argc, char** argv) {
  try {
    const bool json = argc > 1 && std::string(argv[1]) == "--json";
    const auto rows =
        simuli::bench::run_stages("", {}, [](const std::string& line) { std::cerr << line << '\n'; });
    std::cout << (json ? simuli::bench::to_json(rows) : simuli::bench::to_text(rows));
    return 0;
  } catch (const simuli::Error& error) {
    std::cerr << "simuli_bench: " << error.what() << '\n';
    return error.exit_code();
  } catch (const std::exception& error) {
    std::cerr << "simuli_bench: " << error.what() << '\n';
    return static_cast<int>(simuli::ErrorKind::kInternal);
  }
}
