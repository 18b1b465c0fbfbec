// Files of trained chunks. A resumed training reads the chunks that it has finished.
#include <fmt/format.h>
#include <span>

#include "io/base/state_file.hpp"
#include "optim/base/packed.hpp"
#include "optim/base/state.hpp"
#include "optim/train/chunk/chunk_parts.hpp"

namespace simuli {
namespace {

constexpr const char* kSettings = "settings";
constexpr const char* kChunk = "stretch";
constexpr const char* kIterationsKey = "iterations=";
constexpr const char* kChunkKey = "stretch=";

}  // namespace

static void pack(Packed& p, TrainReport& v) {
  auto& [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, q, r, s, t, u, w] = v;
  p(a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, q, r, s, t, u, w);
}
static void pack(Packed& p, ChunkScene& v) { p.all(v, v.scene, v.lidars, v.report); }

std::string chunk_lines(int iterations, std::size_t index, std::size_t count) {
  return fmt::format("{}{}\n{}{} of {}\n", kIterationsKey, iterations, kChunkKey, index, count);
}

std::string chunk_lines(const std::filesystem::path& checkpoint) {
  const std::vector<std::byte> bytes = StateFile(checkpoint).block(kSettings);
  const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.rfind(std::string("\n") + kChunkKey) == std::string::npos) return "";
  return text.substr(text.rfind(std::string("\n") + kIterationsKey) + 1);
}

std::filesystem::path chunk_file(const std::filesystem::path& checkpoint, std::size_t index) {
  return checkpoint.string() + fmt::format(".{}", index);
}

void write_chunk(const std::filesystem::path& file, const std::string& settings, ChunkScene& part) {
  write_state_file(file, [&](StateWriter& out) {
    out.add(kSettings, std::as_bytes(std::span(settings)));
    Packed packed;
    packed(part);
    out.add(kChunk, packed.bytes());
  });
}

ChunkScene read_chunk(const std::filesystem::path& path, const std::string& settings) {
  const StateFile file(path);
  StateList::need_text(path.string(), kSettings, file.block(kSettings), settings);
  Packed packed(file.block(kChunk), path.string(), kChunk);
  ChunkScene part;
  packed(part);
  packed.need_end();
  return part;
}

const ChunkScene& ChunkParts::part(std::size_t index) {
  const StoredPart& kept = kept_.at(index);
  if (kept.file.empty()) return kept.part;
  read_ = {};
  read_ = read_chunk(kept.file, kept.settings);
  return read_;
}

}  // namespace simuli
