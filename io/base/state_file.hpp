#pragma once
// A file of named blocks of bytes: what checkpoints are made of.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace simuli {

/// What a block's bytes are known by again: tells accidents from content.
[[nodiscard]] std::uint64_t checksum_of(std::span<const std::byte> bytes);

/// Writes blocks one after the other, so that only one is in memory at a time.
class StateWriter {
 public:
  using Sink = std::function<void(const void*, std::size_t)>;
  explicit StateWriter(Sink sink) : sink_(std::move(sink)) {}
  void add(const std::string& name, std::span<const std::byte> bytes);

 private:
  Sink sink_;
};

/// Lets `write` add all blocks of `file`. Atomic: written under another name, synced, renamed; whoever is
/// killed meanwhile leaves the old file as it was. Error{kInput} when it can't be written.
void write_state_file(const std::filesystem::path& file, const std::function<void(StateWriter&)>& write);

/// A file of blocks, indexed on opening; each is read when asked for.
class StateFile {
 public:
  /// Error{kInput} for what is not such a file, another version, or a file cut short.
  explicit StateFile(std::filesystem::path file);
  [[nodiscard]] bool has(const std::string& name) const { return blocks_.contains(name); }
  [[nodiscard]] std::vector<std::string> names() const;
  /// Error{kInput} when there is no such block, or its bytes are not those that were written.
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
