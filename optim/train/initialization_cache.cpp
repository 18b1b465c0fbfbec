#include "optim/train/initialization_cache.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <span>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/interruption.hpp"
#include "host/core/base/version.hpp"
#include "host/device/runtime/disk_cache.hpp"
#include "io/base/file.hpp"
#include "io/base/state_file.hpp"
#include "io/base/temporary.hpp"
#include "io/log/camera_mask.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kKey = "key";
constexpr const char* kValue = "value";
constexpr const char* kEnding = ".start";

/// Removes the least recently used file.
void remove_oldest(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, fs::path>> files;
  std::uintmax_t bytes = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != kEnding || is_temporary(entry.path())) continue;
    files.emplace_back(entry.last_write_time(), entry.path());
    bytes += entry.file_size();
  }
  std::sort(files.begin(), files.end());
  for (const auto& [time, file] : files) {
    if (bytes <= InitializationCache::kMost) break;
    bytes -= fs::file_size(file);
    fs::remove(file);
  }
}

}  // namespace

InitializationCache::InitializationCache(bool on) {
  const auto folder = cache_folder();
  if (on && folder && !build_id().empty()) folder_ = *folder / "starts";
}

Packed InitializationCache::key_of(std::string step, const Log& log) {
  Packed key;
  std::string build = build_id(), hash = log_hash(log);  // of the log: names and sizes of its files, and its cameras
  Log read = log;
  key(build, step, hash, read);
  const auto add = [&](const std::string& name) {
    Interruption::ask();
    const auto [file, is_new] = files_.try_emplace(log.folder / name);
    try {
      if (is_new) {
        const std::string bytes = read_file(file->first);
        file->second = checksum_of(std::as_bytes(std::span(bytes)));
      }
    } catch (const Error&) {  // treated as an empty cache; the reader reports the error
    }
    key(file->second);
  };
  for (ImageFrame& frame : read.images) {
    key(frame.time_start_s, frame.time_end_s);  // the hash contains them in whole nanoseconds
    add(frame.file);
  }
  for (SweepFrame& frame : read.sweeps) {
    key(frame.time_start_s, frame.time_end_s);
    add(frame.file);
  }
  if (!log.points.empty()) add(log.points);
  for (const auto& [camera, mask] : log.hidden) {
    std::string name = camera;
    CameraMask hidden = *mask;
    key(name, hidden.width, hidden.height, hidden.hidden);
  }
  return key;
}

fs::path InitializationCache::file_of(const Packed& key) const {
  return folder_ / fmt::format("{:016x}{}", checksum_of(key.bytes()), kEnding);
}

std::optional<Packed> InitializationCache::find(const Packed& key, InitializationReport& report) const {
  const fs::path file = file_of(key);
  std::error_code failed;
  if (!fs::exists(file, failed)) return std::nullopt;
  fs::last_write_time(file, fs::file_time_type::clock::now(), failed);
  try {
    const StateFile kept(file);
    if (kept.block(kKey) != key.bytes()) return std::nullopt;
    return Packed(kept.block(kValue), file.string(), kValue);
  } catch (const Error& error) {
    if (fs::remove(file, failed)) report.damaged.push_back(error.what());
    return std::nullopt;
  }
}

void InitializationCache::keep(const Packed& key, const Packed& value) const {
  try {
    const fs::path file = file_of(key);
    if (fs::exists(file)) return;  // written by another rank
    fs::create_directories(folder_);
    remove_stale_temporaries(file);
    write_state_file(file, [&](StateWriter& out) {
      out.add(kKey, key.bytes());
      out.add(kValue, value.bytes());
    });
    remove_oldest(folder_);
  } catch (const Error&) {
  } catch (const fs::filesystem_error&) {
  }
}

}  // namespace simuli
