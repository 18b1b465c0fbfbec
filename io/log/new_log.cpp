#include "io/log/new_log.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <system_error>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/picture/image.hpp"

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

std::vector<std::string> hide_lowest(Log& log, const std::string& camera, double share) {
  const auto found = std::find_if(
      log.cameras.begin(), log.cameras.end(), [&](const LogCamera& c) { return c.model.name == camera; });
  if (found == log.cameras.end() || found->model.width == 0) return {};
  const int width = found->model.width, height = found->model.height;
  const int from = static_cast<int>(std::floor((1.0 - share) * height + 1e-6));
  Image mask(width, height, 1);
  const auto first = static_cast<std::ptrdiff_t>(from) * width;
  std::fill(mask.data.begin() + first, mask.data.end(), 1.0F);
  log.masks.push_back({camera, fmt::format("masks/{}/vehicle.png", camera)});
  put_file(log, log.masks.back().file, [&](const std::filesystem::path& to) { write_image(to, mask); });
  return {fmt::format("{}: rows {} to {} show the vehicle and are hidden", camera, from, height - 1)};
}

void put_file(const Log& log,
              const std::string& file,
              const std::function<void(const std::filesystem::path&)>& write) {
  if (log.folder.empty()) return;
  std::filesystem::create_directories((log.folder / file).parent_path());
  write(log.folder / file);
}

}  // namespace simuli
