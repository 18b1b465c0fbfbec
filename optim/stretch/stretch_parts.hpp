#pragma once
// Where the stretches are that have been trained: as files beside the checkpoint, or in memory.
#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "optim/stretch/stretch_scene.hpp"

namespace simuli {

/// What the settings of a training say of a stretch, behind those of a training in one piece; and of the one
/// whose state a checkpoint holds, empty where that is no stretch's. Error{kInput} for what is no checkpoint.
[[nodiscard]] std::string stretch_lines(int iterations, std::size_t index, std::size_t count);
[[nodiscard]] std::string stretch_lines(const std::filesystem::path& checkpoint);
/// Where a training that is stored in `checkpoint` keeps its stretch number `index` when that is done.
[[nodiscard]] std::filesystem::path stretch_file(const std::filesystem::path& checkpoint, std::size_t index);
/// Keeps a part in a file, by the text that tells which training's it is. Atomic.
void write_stretch(const std::filesystem::path& file, const std::string& settings, StretchScene& part);
/// The part again, the same bits. Error{kInput} for what is no such file, or of another training.
[[nodiscard]] StretchScene read_stretch(const std::filesystem::path& file, const std::string& settings);

/// Those that are done, in their order.
class StretchParts {
 public:
  /// In memory.
  void keep(StretchScene part) { kept_.push_back({std::move(part), {}, {}}); }
  /// In the file that write_stretch() has made of it: memory stays one stretch's.
  void keep(std::filesystem::path file, std::string settings) {
    kept_.push_back({{}, std::move(file), std::move(settings)});
  }
  [[nodiscard]] std::size_t count() const { return kept_.size(); }
  /// Good until the next one is asked for. Errors as in read_stretch().
  [[nodiscard]] const StretchScene& part(std::size_t index);

 private:
  struct StoredPart {
    StretchScene part;
    std::filesystem::path file;  // empty: it is in memory
    std::string settings;
  };
  std::vector<StoredPart> kept_;
  StretchScene read_;
};

}  // namespace simuli
