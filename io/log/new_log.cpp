#include "io/log/new_log.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <set>
#include <system_error>

#include "host/core/base/error.hpp"
#include "host/core/base/names.hpp"
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
    sort_by_time(log);
  };
  if (!output.empty()) return make_log(output, log, filled);
  log.folder.clear();
  filled();
  return log;
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

void LogMaker::add_sweep(const std::string& lidar,
                         const std::string& stem,
                         const Sweep& sweep,
                         const FrameSpan& span) {
  log_.sweeps.push_back({lidar, "sweeps/" + stem + ".exr", span.time_start_s, span.time_end_s});
  put_file(log_, log_.sweeps.back().file, [&](const std::filesystem::path& to) { write_sweep(to, sweep); });
  rays_ += sweep.range.size();
  returned_ += static_cast<std::size_t>(
      std::count_if(sweep.range.begin(), sweep.range.end(), [](float range) { return range > 0.0F; }));
}

void LogMaker::add_picture(const Camera& camera,
                           const std::string& stem,
                           const std::filesystem::path& from,
                           const std::string& source,
                           const FrameSpan& span) {
  const std::string file = "images/" + stem + from.extension().string();
  log_.images.push_back({camera.name, file, span.time_start_s, span.time_end_s});
  put_file(log_, file, [&](const std::filesystem::path& to) { copy_picture(from, to, camera, source); });
}

void LogMaker::step() {
  if (progress_) progress_(++done_, total_);
}

std::vector<FrameSpan> sweep_spans(const std::vector<double>& stamps_s,
                                   double revolution_s,
                                   SweepStamp stamp) {
  constexpr double kFarthest = 1.5;  // revolutions between a sweep and its neighbour
  const auto gap_before = [&](std::size_t i) {
    if (i == 0 || i >= stamps_s.size()) return revolution_s;
    const double gap_s = stamps_s[i] - stamps_s[i - 1];
    return gap_s > 0.0 && gap_s < kFarthest * revolution_s ? gap_s : revolution_s;
  };
  std::vector<FrameSpan> spans;
  for (std::size_t i = 0; i < stamps_s.size(); ++i) {
    const double before_s = gap_before(i), after_s = gap_before(i + 1),
                 half_s = 0.5 * std::min({before_s, after_s, revolution_s});
    if (stamp == SweepStamp::kStart) spans.push_back({stamps_s[i], stamps_s[i] + after_s});
    if (stamp == SweepStamp::kMiddle) spans.push_back({stamps_s[i] - half_s, stamps_s[i] + half_s});
    if (stamp == SweepStamp::kEnd) spans.push_back({stamps_s[i] - before_s, stamps_s[i]});
  }
  return spans;
}

std::vector<std::string> requested_sensors(const std::vector<std::string>& requested,
                                           const std::vector<std::string>& known,
                                           const char* option) {
  if (requested.empty()) return known;
  std::set<std::size_t> indices;
  for (const std::string& name : requested) indices.insert(index_of_name(name, known, option));
  std::vector<std::string> sensors;
  for (const std::size_t index : indices) sensors.push_back(known[index]);
  return sensors;
}

}  // namespace simuli
