#pragma once
// Where the chunks are that have been trained: as files beside the checkpoint, or in memory.
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "optim/train/chunk/chunk_scene.hpp"

namespace simuli {

/// What the settings of a training say of a chunk, behind those of a training in one piece; and of the one
/// whose state a checkpoint holds, empty where that is no chunk's. Error{kInput} for what is no checkpoint.
[[nodiscard]] std::string chunk_lines(int iterations, std::size_t index, std::size_t count);
[[nodiscard]] std::string chunk_lines(const std::filesystem::path& checkpoint);
/// Where a training that is stored in `checkpoint` keeps its chunk number `index` when that is done.
[[nodiscard]] std::filesystem::path chunk_file(const std::filesystem::path& checkpoint, std::size_t index);
/// Keeps a part in a file, by the text that tells which training's it is. Atomic.
void write_chunk(const std::filesystem::path& file, const std::string& settings, ChunkScene& part);
/// The part again, the same bits. Error{kInput} for what is no such file, or of another training.
[[nodiscard]] ChunkScene read_chunk(const std::filesystem::path& file, const std::string& settings);

/// Those that are done, in their order.
class ChunkParts {
 public:
  /// In memory.
  void keep(ChunkScene part) { kept_.push_back({std::move(part), {}, {}}); }
  /// In the file that write_chunk() has made of it: memory stays one chunk's.
  void keep(std::filesystem::path file, std::string settings) {
    kept_.push_back({{}, std::move(file), std::move(settings)});
  }
  [[nodiscard]] std::size_t count() const { return kept_.size(); }
  /// Good until the next one is asked for. Errors as in read_chunk().
  [[nodiscard]] const ChunkScene& part(std::size_t index);

 private:
  struct StoredPart {
    ChunkScene part;
    std::filesystem::path file;  // empty: it is in memory
    std::string settings;
  };
  std::vector<StoredPart> kept_;
  ChunkScene read_;
};

}  // namespace simuli
