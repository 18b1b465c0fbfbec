// Sweep files: one OpenEXR picture per sweep, rows x columns, one float channel per quantity.
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <memory>
#include <numbers>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/log/log.hpp"
#include "io/log/sweep_file.hpp"
#include "io/picture/codec/picture_codec.hpp"
#include "io/picture/exr_header.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

/// A channel of the picture; values outside [minimum, maximum] and NaN are errors.
struct Channel {
  const char* name;
  float minimum;
  float maximum;
  std::vector<float>& (*values)(Sweep&);
};

// Angles may be unwrapped by one revolution; a row's time offset may reach beyond the sweep.
constexpr float kTurn = 2.0F * std::numbers::pi_v<float>;
constexpr float kRight = 0.5F * std::numbers::pi_v<float>;
constexpr std::array<Channel, 5> kChannels{{
    {"range_m", 0.0F, 1e5F, [](Sweep& s) -> std::vector<float>& { return s.range; }},
    {"intensity", 0.0F, 1.0F, [](Sweep& s) -> std::vector<float>& { return s.intensity; }},
    {"azimuth_rad", -kTurn, kTurn, [](Sweep& s) -> std::vector<float>& { return s.rays.azimuth; }},
    {"elevation_rad", -kRight, kRight, [](Sweep& s) -> std::vector<float>& { return s.rays.elevation; }},
    {"time_fraction", -1.0F, 2.0F, [](Sweep& s) -> std::vector<float>& { return s.rays.time_fraction; }},
}};

[[noreturn]] void refuse_value(const fs::path& file,
                               const char* channel,
                               std::size_t i,
                               int columns,
                               float found,
                               const std::string& allowed) {
  const auto width = static_cast<std::size_t>(columns);
  throw_input_error(file.string(),
                    fmt::format("channel {}: row {}, column {}", channel, i / width, i % width),
                    fmt::format("{}", found),
                    allowed);
}

void validate(const fs::path& file, Sweep& sweep) {
  const int columns = sweep.rays.columns;
  for (const Channel& channel : kChannels) {
    const std::vector<float>& values = channel.values(sweep);
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (values[i] >= channel.minimum && values[i] <= channel.maximum) continue;
      refuse_value(file,
                   channel.name,
                   i,
                   columns,
                   values[i],
                   fmt::format("{:.6g} to {:.6g}", channel.minimum, channel.maximum));
    }
  }
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (sweep.range[i] == 0.0F && sweep.intensity[i] != 0.0F) {
      refuse_value(file, "intensity", i, columns, sweep.intensity[i], "0 where nothing returned (range 0)");
    }
  }
}

[[noreturn]] void refuse(const fs::path& file,
                         std::string cause,
                         const char* allowed = "a whole OpenEXR file") {
  while (!cause.empty() && cause.back() == '\n') cause.pop_back();
  throw_input_error(file.string(), "sweep", cause.empty() ? "an unreadable file" : cause, allowed);
}

}  // namespace

SweepShape sweep_shape(const LidarModel& lidar) {
  const std::size_t rows = row_count(lidar);
  return {name_of(lidar), rows, ray_count(lidar) / rows};
}

Sweep read_recorded_sweep(const fs::path& file, const SweepShape& shape) {
  need_regular_file(file);
  const std::size_t rows = shape.rows, columns = shape.columns, count = rows * columns;
  require_sound_exr_header(file);
  // The format is given, because the library would try all its decoders on a file that is not OpenEXR.
  std::string failure;
  const std::unique_ptr<PictureInput> input = picture_codec().open("exr", file, failure);
  if (!input) refuse(file, failure);
  const PictureLayout layout = input->layout();
  if (layout.height != static_cast<int>(rows) || layout.width != static_cast<int>(columns) ||
      layout.depth > 1) {
    throw_input_error(file.string(),
                      "rows x columns",
                      fmt::format("{} x {}", layout.height, layout.width),
                      fmt::format("{} x {} of lidar {}", rows, columns, shape.lidar));
  }
  const std::vector<std::string>& names = layout.channel_names;
  std::array<std::size_t, kChannels.size()>
      place{};  // of kChannels in the file, which sorts channels by name
  for (std::size_t c = 0; c < kChannels.size(); ++c) {
    const auto found = std::find(names.begin(), names.end(), kChannels[c].name);
    if (found == names.end() || names.size() != kChannels.size()) {
      throw_input_error(file.string(),
                        fmt::format("channel {}", kChannels[c].name),
                        fmt::format("channels {}", fmt::join(names, ", ")),
                        "range_m, intensity, azimuth_rad, elevation_rad, time_fraction");
    }
    place[c] = static_cast<std::size_t>(found - names.begin());
  }
  Sweep sweep;
  sweep.rays.rows = layout.height;
  sweep.rays.columns = layout.width;
  std::vector<float> pixels;
  if (const PictureFailure incomplete = input->read(pixels)) refuse(file, *incomplete);
  for (std::size_t c = 0; c < kChannels.size(); ++c) {
    std::vector<float>& values = kChannels[c].values(sweep);
    values.resize(count);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = pixels[i * kChannels.size() + place[c]];
  }
  validate(file, sweep);
  return sweep;
}

Sweep as_measured(Sweep sweep, const fs::path& file, const LidarModel& lidar) {
  for (std::size_t i = 0; i < sweep.range.size(); ++i) {
    if (sweep.range[i] == 0.0F) continue;
    if (hits_ego_vehicle(lidar, sweep.rays, i)) {
      sweep.range[i] = sweep.intensity[i] = 0.0F;
      continue;
    }
    const float distance_m = distance_of(lidar, sweep.rays, i, sweep.range[i]);
    if (!(distance_m > 0.0F)) {
      refuse_value(file,
                   "range_m",
                   i,
                   sweep.rays.columns,
                   sweep.range[i],
                   fmt::format("more than the row's bias of {} m", sweep.range[i] - distance_m));
    }
    sweep.range[i] = distance_m;
  }
  return sweep;
}

Sweep read_sweep(const fs::path& file, const LidarModel& lidar) {
  return as_measured(read_recorded_sweep(file, sweep_shape(lidar)), file, lidar);
}

void write_sweep(const fs::path& file, const Sweep& sweep) {
  if (file.extension() != ".exr") {
    throw_input_error(file.string(), "file", file.extension().string(), "a name ending in .exr");
  }
  Sweep checked = sweep;
  const int rows = sweep.rays.rows;
  const int columns = sweep.rays.columns;
  if (rows < 1 || columns < 1) {
    throw_input_error(
        file.string(), "rows x columns", fmt::format("{} x {}", rows, columns), "at least 1 x 1");
  }
  const std::size_t count = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
  PictureLayout layout{columns, rows, 1, static_cast<int>(kChannels.size())};
  std::vector<float> pixels(count * kChannels.size());
  for (std::size_t c = 0; c < kChannels.size(); ++c) {
    const std::vector<float>& values = kChannels[c].values(checked);
    if (values.size() != count) {
      throw_input_error(file.string(),
                        fmt::format("channel {}", kChannels[c].name),
                        fmt::format("{} values", values.size()),
                        fmt::format("{} ({} rows x {} columns)", count, rows, columns));
    }
    layout.channel_names.emplace_back(kChannels[c].name);
    for (std::size_t i = 0; i < count; ++i) pixels[i * kChannels.size() + c] = values[i];
  }
  validate(file, checked);
  write_atomically(file, [&](const fs::path& temporary) {
    const PictureSamples picture{layout, SampleType::kFloat, pixels.data(), reproducible_exr()};
    if (const PictureFailure failure = picture_codec().write(temporary, picture))
      refuse(file, *failure, "a path with room for all of it (is the disk full?)");
  });
}

}  // namespace simuli
