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
  const auto filled = [&] {
    fill();
    if (log.images.empty() && log.sweeps.empty())
      throw_nothing_left(log.name, "pictures and sweeps", "none", "at least one that is left");
  };
  if (!output.empty()) return make_log(output, log, filled);
  log.folder.clear();
  filled();
  return log;
}

void put_sweep(const Log& log, const std::string& file, const Sweep& sweep) {
  put_file(log, file, [&](const std::filesystem::path& to) { write_sweep(to, sweep); });
}

void put_picture(const Log& log,
                 const std::filesystem::path& from,
                 const std::string& file,
                 const Camera& camera,
                 const std::string& source) {
  put_file(log, file, [&](const std::filesystem::path& to) { copy_picture(from, to, camera, source); });
}

void put_file(const Log& log,
              const std::string& file,
              const std::function<void(const std::filesystem::path&)>& write) {
  if (log.folder.empty()) return;
  std::filesystem::create_directories((log.folder / file).parent_path());
  write(log.folder / file);
}

}  // namespace simuli
