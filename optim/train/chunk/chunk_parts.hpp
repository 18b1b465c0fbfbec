#pragma once
// Storage of trained chunks: files next to the checkpoint, or memory.
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "optim/train/chunk/chunk_scene.hpp"

namespace simuli {

/// Returns the settings lines that identify a chunk of a training, appended to the lines of a training in one
/// run. The second function returns the lines of the chunk whose state a checkpoint holds; empty if it holds no
/// chunk. Throws Error{kInput} when the file is not a checkpoint.
[[nodiscard]] std::string chunk_lines(int iterations, std::size_t index, std::size_t count);
[[nodiscard]] std::string chunk_lines(const std::filesystem::path& checkpoint);
/// Returns the file of chunk `index` of a training that is saved in `checkpoint`.
[[nodiscard]] std::filesystem::path chunk_file(const std::filesystem::path& checkpoint, std::size_t index);
/// Writes a chunk to a file, together with the settings text that identifies its training. Atomic.
void write_chunk(const std::filesystem::path& file, const std::string& settings, ChunkScene& part);
/// Reads the same bits back. Throws Error{kInput} for another kind of file or another training.
[[nodiscard]] ChunkScene read_chunk(const std::filesystem::path& file, const std::string& settings);

/// The finished chunks in order.
class ChunkParts {
 public:
  /// Stores a chunk in memory.
  void keep(ChunkScene part) { kept_.push_back({std::move(part), {}, {}}); }
  /// Refers to the file that write_chunk() wrote, so that memory holds only one chunk.
  void keep(std::filesystem::path file, std::string settings) {
    kept_.push_back({{}, std::move(file), std::move(settings)});
  }
  [[nodiscard]] std::size_t count() const { return kept_.size(); }
  /// The reference is valid until the next call. Errors as in read_chunk().
  [[nodiscard]] const ChunkScene& part(std::size_t index);

 private:
  struct StoredPart {
    ChunkScene part;
    std::filesystem::path file;  // empty: stored in memory
    std::string settings;
  };
  std::vector<StoredPart> kept_;
  ChunkScene read_;
};

}  // namespace simuli
