#include <algorithm>
#include <string>
#include <system_error>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/base/temporary.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& path,
                         const char* why,
                         const fs::path& folder,
                         std::string_view file,
                         std::string_view field) {
  throw_input_error(
      file, field, '"' + path.string() + '"' + why, "a path inside the folder " + folder.string());
}

}  // namespace

fs::path below(const fs::path& folder, const fs::path& path, std::string_view file, std::string_view field) {
  const bool leads_out = path.is_absolute() || std::find(path.begin(), path.end(), "..") != path.end();
  if (path.empty() || leads_out) refuse(path, "", folder, file, field);
  return folder / path;
}

fs::path inside(const fs::path& folder, const fs::path& path, std::string_view file, std::string_view field) {
  fs::path whole = below(folder, path, file, field);
  std::error_code failed;
  // Relative to the working folder, so that a missing folder becomes absolute as well.
  const fs::path target = fs::weakly_canonical("." / whole, failed);
  const fs::path root =
      failed ? fs::path() : fs::weakly_canonical("." / without_trailing_slash(folder), failed);
  if (failed) refuse(path, ", which can't be followed", folder, file, field);
  const auto [end, unused] = std::mismatch(root.begin(), root.end(), target.begin(), target.end());
  if (end != root.end()) refuse(path, ", a link that leads out", folder, file, field);
  return whole;
}

}  // namespace simuli
