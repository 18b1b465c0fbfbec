#include "host/device/runtime/tuning.hpp"

#include <fmt/format.h>
#include <sstream>
#include <string>

#include "host/core/base/error.hpp"
#include "host/device/runtime/disk_cache.hpp"

namespace simuli {
namespace {

/// As program_key(): another driver may want to be used otherwise.
std::string key_of(const DeviceInfo& device) { return program_key(device, "tuning 1", ""); }

std::string text_of(const DeviceTuning& t) {
  return fmt::format("{} {} {} {}", t.lanes, t.vectors, t.work_items, t.group);
}

}  // namespace

std::optional<DeviceTuning> stored_tuning(const DeviceInfo& device) {
  const std::optional<ProgramBinary> bytes = load_binary(key_of(device));
  if (!bytes) return std::nullopt;
  std::istringstream text(std::string(bytes->begin(), bytes->end()));
  DeviceTuning t;
  if (!(text >> t.lanes >> t.vectors >> t.work_items >> t.group) || t == DeviceTuning{}) return std::nullopt;
  return t;
}

void save_tuning(const DeviceInfo& device, const DeviceTuning& tuning) {
  const std::string text = text_of(tuning);
  save_binary(key_of(device), ProgramBinary(text.begin(), text.end()));
  if (stored_tuning(device).value_or(DeviceTuning{}) == tuning) return;
  const auto folder = cache_folder();
  throw_input_error(folder ? folder->string() : "SIMULI_CACHE_DIR",
                    "tuning",
                    folder ? "a folder that can't be written" : "no folder for the cache",
                    "one that can be written");
}

}  // namespace simuli
