#include "io/base/state_file.hpp"

#include <array>
#include <cstring>
#include <fmt/format.h>
#include <fstream>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"

namespace simuli {
namespace {

// The last character is the version.
constexpr std::array<char, 16> kMagic = {
    'S', 'I', 'M', 'U', 'L', 'I', ' ', 'S', 'T', 'A', 'T', 'E', ' ', ' ', ' ', '1'};
constexpr std::uint32_t kLongestName = 256;

struct Header {
  std::uint64_t name_bytes = 0, bytes = 0, checksum = 0;
};

}  // namespace

// Detects accidental damage: FNV-1a on words of eight bytes, with the high bits mixed down.
std::uint64_t checksum_of(std::span<const std::byte> bytes) {
  std::uint64_t hash = 0xcbf29ce484222325U ^ bytes.size();
  for (std::size_t i = 0; i < bytes.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, std::min<std::size_t>(8, bytes.size() - i));
    hash = (hash ^ word) * 0x100000001b3U;
    hash ^= hash >> 32U;
  }
  return hash;
}

void StateWriter::add(const std::string& name, std::span<const std::byte> bytes) {
  const Header header{name.size(), bytes.size(), checksum_of(bytes)};
  sink_(&header, sizeof header);
  sink_(name.data(), name.size());
  sink_(bytes.data(), bytes.size());
}

void write_state_file(const std::filesystem::path& file, const std::function<void(StateWriter&)>& write) {
  write_atomically(file, [&](const std::filesystem::path& temporary) {
    std::ofstream out(temporary, std::ios::binary);
    const auto put = [&](const void* data, std::size_t bytes) {
      out.write(static_cast<const char*>(data), static_cast<std::streamsize>(bytes));
      if (!out) throw_input_error(file.string(), "content", "a failed write", "a disk with room");
    };
    put(kMagic.data(), kMagic.size());
    StateWriter writer(put);
    write(writer);
    out.close();
    if (!out) throw_input_error(file.string(), "content", "a failed write", "a disk with room");
  });
}

StateFile::StateFile(std::filesystem::path file) : file_(std::move(file)) {
  need_regular_file(file_);
  std::ifstream in(file_, std::ios::binary | std::ios::ate);
  if (!in) throw_input_error(file_.string(), "file", "one that can't be read", "a readable file");
  const auto size = static_cast<std::uint64_t>(in.tellg());
  in.seekg(0);
  std::array<char, kMagic.size()> magic{};
  in.read(magic.data(), magic.size());
  if (!in || !std::equal(magic.begin(), magic.end() - 1, kMagic.begin())) {
    throw_input_error(file_.string(), "first bytes", "others", "those of a training state");
  }
  if (magic.back() != kMagic.back()) {
    throw_input_error(file_.string(), "version", std::string(1, magic.back()), std::string(1, kMagic.back()));
  }
  for (std::uint64_t at = kMagic.size(); at < size;) {
    Header header;
    const bool has_header = size - at >= sizeof header;
    if (has_header) in.read(reinterpret_cast<char*>(&header), sizeof header);
    at += sizeof header;
    const bool fits = has_header && in && header.name_bytes <= kLongestName &&
                      header.name_bytes <= size - at && header.bytes <= size - at - header.name_bytes;
    if (!fits)
      throw_input_error(file_.string(), "length", fmt::format("{} bytes", size), "all of its blocks");
    std::string name(header.name_bytes, '\0');
    in.read(name.data(), static_cast<std::streamsize>(name.size()));
    at += header.name_bytes;
    if (!blocks_.emplace(name, Block{at, header.bytes, header.checksum}).second) {
      throw_input_error(file_.string(), name, "two blocks of that name", "one");
    }
    at += header.bytes;
    in.seekg(static_cast<std::streamoff>(at));
  }
}

std::vector<std::string> StateFile::names() const {
  std::vector<std::string> names;
  for (const auto& [name, block] : blocks_) names.push_back(name);
  return names;
}

std::vector<std::byte> StateFile::block(const std::string& name) const {
  const auto found = blocks_.find(name);
  if (found == blocks_.end()) throw_input_error(file_.string(), name, "no such block", "one");
  const Block& block = found->second;
  std::ifstream in(file_, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(block.offset));
  std::vector<std::byte> bytes(block.bytes);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in || checksum_of(bytes) != block.checksum) {
    throw_input_error(file_.string(), name, "bytes of another checksum", "those that were written");
  }
  return bytes;
}

}  // namespace simuli
