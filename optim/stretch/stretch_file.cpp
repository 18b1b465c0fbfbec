// Trained stretches as files of blocks: what a training that goes on finds done.
#include <fmt/format.h>
#include <span>

#include "io/base/state_file.hpp"
#include "optim/state/packed.hpp"
#include "optim/state/state.hpp"
#include "optim/stretch/stretch_parts.hpp"

namespace simuli {
namespace {

constexpr const char* kSettings = "settings";
constexpr const char* kStretch = "stretch";
constexpr const char* kIterationsKey = "iterations=";
constexpr const char* kStretchKey = "stretch=";

}  // namespace

static void pack(Packed& p, TrainReport& v) {
  auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, q, r, s, t, u, w] = v;
  p(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, q, r, s, t, u, w);
}
static void pack(Packed& p, StretchScene& v) { p.all(v, v.scene, v.lidars, v.report); }

std::string stretch_lines(int iterations, std::size_t index, std::size_t count) {
  return fmt::format("{}{}\n{}{} of {}\n", kIterationsKey, iterations, kStretchKey, index, count);
}

std::string stretch_lines(const std::filesystem::path& checkpoint) {
  const std::vector<std::byte> bytes = StateFile(checkpoint).block(kSettings);
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.rfind(std::string("\n") + kStretchKey) == std::string::npos) return "";
  return text.substr(text.rfind(std::string("\n") + kIterationsKey) + 1);
}

std::filesystem::path stretch_file(const std::filesystem::path& checkpoint, std::size_t index) {
  return checkpoint.string() + fmt::format(".{}", index);
}

void write_stretch(const std::filesystem::path& file, const std::string& settings, StretchScene& part) {
  write_state_file(file, [&](StateWriter& out) {
    out.add(kSettings, std::as_bytes(std::span(settings)));
    Packed packed;
    packed(part);
    out.add(kStretch, packed.bytes());
  });
}

StretchScene read_stretch(const std::filesystem::path& path, const std::string& settings) {
  const StateFile file(path);
  StateList::need_text(path.string(), kSettings, file.block(kSettings), settings);
  Packed packed(file.block(kStretch), path.string(), kStretch);
  StretchScene part;
  packed(part);
  packed.need_end();
  return part;
}

const StretchScene& StretchParts::part(std::size_t index) {
  const StoredPart& kept = kept_.at(index);
  if (kept.file.empty()) return kept.part;
  read_ = {};
  read_ = read_stretch(kept.file, kept.settings);
  return read_;
}

}  // namespace simuli
