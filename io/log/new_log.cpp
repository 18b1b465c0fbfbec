#include "io/log/new_log.hpp"

#include <system_error>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"

namespace simuli {

Log make_log(const std::filesystem::path& output, Log& log, const std::function<void()>& fill) {
  Log made;
  write_folder_atomically(output, [&](const std::filesystem::path& folder) {
    log.folder = folder;
    for (const char* const kind : {"images", "sweeps"}) std::filesystem::create_directory(folder / kind);
    fill();
    write_log(log);
    for (const char* const kind : {"images", "sweeps"}) {
      std::error_code is_used;
      std::filesystem::remove(folder / kind, is_used);
    }
    made = read_log(folder);
  });
  made.folder = output;
  return made;
}

Log make_import(const std::filesystem::path& output, Log& log, const std::function<void()>& fill) {
  return make_log(output, log, [&] {
    fill();
    if (log.images.empty() && log.sweeps.empty())
      throw_nothing_left(output.string(), "pictures and sweeps", "none", "at least one that is left");
  });
}

}  // namespace simuli
