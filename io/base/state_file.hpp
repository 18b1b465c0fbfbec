#pragma once
// A file of named blocks of bytes, the format of checkpoints.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace simuli {

/// Returns a checksum that detects accidental damage.
[[nodiscard]] std::uint64_t checksum_of(std::span<const std::byte> bytes);

/// Writes blocks in sequence, with one block in memory at a time.
class StateWriter {
 public:
  using Sink = std::function<void(const void*, std::size_t)>;
  explicit StateWriter(Sink sink) : sink_(std::move(sink)) {}
  void add(const std::string& name, std::span<const std::byte> bytes);

 private:
  Sink sink_;
};

/// Calls `write` to add all blocks of `file`. Atomic: written under another name, synced and renamed; a killed
/// process leaves the old file unchanged. Throws Error{kInput} if it cannot be written.
void write_state_file(const std::filesystem::path& file, const std::function<void(StateWriter&)>& write);

/// A file of blocks, indexed on opening; blocks are read on request.
class StateFile {
 public:
  /// Throws Error{kInput} for another file type, another version, or a truncated file.
  explicit StateFile(std::filesystem::path file);
  [[nodiscard]] bool has(const std::string& name) const { return blocks_.contains(name); }
  [[nodiscard]] std::vector<std::string> names() const;
  /// Throws Error{kInput} for an unknown block and for a wrong checksum.
  [[nodiscard]] std::vector<std::byte> block(const std::string& name) const;
  [[nodiscard]] const std::filesystem::path& path() const { return file_; }

 private:
  struct Block {
    std::uint64_t offset = 0, bytes = 0, checksum = 0;
  };
  std::filesystem::path file_;
  std::map<std::string, Block> blocks_;
};

}  // namespace simuli
