#include "io/base/fingerprint.hpp"

#include <algorithm>
#include <cstdint>
#include <fmt/format.h>
#include <sys/stat.h>
#include <system_error>
#include <vector>

#include "host/base/error.hpp"
#include "io/base/regular_file.hpp"
#include "io/base/temporary.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

std::uint64_t hash_of(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325U;  // FNV-1a
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  return hash;
}

bool is_passing(const fs::path& path) {
  const std::string name = path.filename().string();
  return is_temporary(path) || (name.starts_with('.') && name.ends_with(".lock"));
}

}  // namespace

std::string fingerprint(const fs::path& path) {
  std::error_code failed;
  if (!is_there(path)) return {};
  std::vector<fs::path> found;
  if (!fs::is_directory(path, failed)) {
    found.push_back(path);
  } else {
    found.push_back(path);
    for (fs::recursive_directory_iterator at(path, failed), end; !failed && at != end; at.increment(failed)) {
      if (!is_passing(at->path())) found.push_back(at->path());
    }
    if (failed) throw_input_error(path.string(), "folder", failed.message(), "one that can be read");
  }
  std::sort(found.begin(), found.end());
  std::string all;
  std::uint64_t files = 0, bytes = 0;
  for (const fs::path& each : found) {
    struct stat what {};
    const bool is_sound = ::stat(each.c_str(), &what) == 0;  // a link that leads nowhere is one without size
    const std::string name = each.lexically_relative(path).string();
    // What is put into a folder and taken out again changes its time alone.
    if (is_sound && S_ISDIR(what.st_mode)) {
      all += fmt::format("{}/\n", name);
      continue;
    }
    all += fmt::format("{}\n{} {}.{:09}\n", name, what.st_size, what.st_mtim.tv_sec, what.st_mtim.tv_nsec);
    files += 1;
    bytes += static_cast<std::uint64_t>(what.st_size);
  }
  return fmt::format("{} files, {} bytes, {:016x}", files, bytes, hash_of(all));
}

}  // namespace simuli
