// OpenEXR pictures of lines: attributes, or what is in the blocks of lines, unpacked and packed again where
// they are by zip.
#include <algorithm>
#include <cstdint>
#include <vector>
#include <zlib.h>

#include "tests/fuzz/mutate/mutate.hpp"

namespace simuli::test {
namespace {

constexpr std::size_t kMagicAndVersion = 8;
constexpr std::size_t kBlockHead = 8;  // the first line's number, bytes

struct Attribute {
  std::string name, type, value;
};

struct Block {
  std::int32_t line = 0;
  std::string bytes;
};

struct Picture {
  std::string start;  // magic number and version
  std::vector<Attribute> attributes;
  std::vector<Block> blocks;
  bool zip = false;
};

std::optional<std::string> text_at(const std::string& file, std::size_t& at) {
  const std::size_t end = file.find('\0', at);
  if (end == std::string::npos) return std::nullopt;
  std::string out = file.substr(at, end - at);
  at = end + 1;
  return out;
}

/// Nothing for what is not whole, or no picture of lines.
std::optional<Picture> picture_of(const std::string& file) {
  if (file.size() < kMagicAndVersion || !file.starts_with("\x76\x2f\x31\x01")) return std::nullopt;
  Picture picture{file.substr(0, kMagicAndVersion), {}, {}, false};
  std::size_t at = kMagicAndVersion;
  for (;;) {
    const std::optional<std::string> name = text_at(file, at);
    if (!name) return std::nullopt;
    if (name->empty()) break;
    const std::optional<std::string> type = text_at(file, at);
    if (!type || file.size() - at < 4) return std::nullopt;
    const auto bytes = number_at<std::uint32_t>(file, at);
    at += 4;
    if (bytes > file.size() - at) return std::nullopt;
    picture.attributes.push_back({*name, *type, file.substr(at, bytes)});
    at += bytes;
    if (*name == "compression" && bytes == 1) picture.zip = file[at - 1] == 2 || file[at - 1] == 3;
  }
  // The first offset tells where the table ends.
  if (file.size() - at < 8) return std::nullopt;
  const auto first = number_at<std::uint64_t>(file, at);
  if (first <= at || first > file.size()) return std::nullopt;
  for (at = first; file.size() - at >= kBlockHead;) {
    const auto line = number_at<std::int32_t>(file, at);
    const auto bytes = number_at<std::uint32_t>(file, at + 4);
    at += kBlockHead;
    if (bytes > file.size() - at) return std::nullopt;
    picture.blocks.push_back({line, file.substr(at, bytes)});
    at += bytes;
  }
  return picture.blocks.empty() ? std::nullopt : std::optional(picture);
}

std::string written(const Picture& picture) {
  std::string out = picture.start;
  for (const Attribute& a : picture.attributes) {
    out.append(a.name.c_str(), a.name.size() + 1).append(a.type.c_str(), a.type.size() + 1);
    append_number(out, static_cast<std::uint32_t>(a.value.size()));
    out += a.value;
  }
  out += '\0';
  std::uint64_t at = out.size() + 8 * picture.blocks.size();
  for (const Block& block : picture.blocks) {
    append_number(out, at);
    at += kBlockHead + block.bytes.size();
  }
  for (const Block& block : picture.blocks) {
    append_number(out, block.line);
    append_number(out, static_cast<std::uint32_t>(block.bytes.size()));
    out += block.bytes;
  }
  return out;
}

void change_attributes(std::vector<Attribute>& attributes, Choice& choice) {
  if (attributes.empty()) return;
  const std::size_t at = choice.below(attributes.size());
  switch (choice.below(8)) {
    case 0:
      attributes.erase(attributes.begin() + static_cast<std::ptrdiff_t>(at));
      break;
    case 1:
      attributes.push_back(Attribute(attributes[at]));
      break;
    case 2:
      attributes[at].name = choice.change(attributes[at].name);
      break;
    case 3:
      attributes[at].type = attributes[choice.below(attributes.size())].type;
      break;
    default:
      attributes[at].value = choice.below(2) == 0 ? mutated_numbers(attributes[at].value, 4, choice)
                                                  : choice.change(attributes[at].value);
  }
  for (Attribute& a : attributes) {  // they end at zero bytes
    std::erase(a.name, '\0');
    std::erase(a.type, '\0');
    if (a.name.empty()) a.name.push_back('a');
  }
}

std::string zipped(const std::string& bytes) {
  uLongf size = compressBound(bytes.size());
  std::string out(size, '\0');
  if (compress(reinterpret_cast<Bytef*>(out.data()),
               &size,
               reinterpret_cast<const Bytef*>(bytes.data()),
               bytes.size()) != Z_OK) {
    return bytes;
  }
  out.resize(size);
  return out;
}

/// A block's numbers; they are stored as they are where zip does not make them smaller.
std::string changed_block(const std::string& bytes, bool zip, Choice& choice) {
  constexpr std::size_t kMost = std::size_t{1} << 16U;
  std::string plain(kMost, '\0');
  uLongf size = kMost;
  const bool is_zipped = zip && uncompress(reinterpret_cast<Bytef*>(plain.data()),
                                           &size,
                                           reinterpret_cast<const Bytef*>(bytes.data()),
                                           bytes.size()) == Z_OK;
  plain = is_zipped ? plain.substr(0, size) : bytes;
  std::string changed = mutated_numbers(plain, sizeof(float), choice);
  if (choice.below(8) != 0) changed.resize(plain.size());
  return is_zipped ? zipped(changed) : changed;
}

}  // namespace

std::optional<std::string> mutated_exr(const std::string& file, Choice& choice) {
  std::optional<Picture> picture = picture_of(file);
  if (!picture) return std::nullopt;
  const std::size_t at = choice.below(picture->blocks.size());
  Block& block = picture->blocks[at];
  switch (choice.below(8)) {
    case 0:
    case 1:
    case 2:
      change_attributes(picture->attributes, choice);
      break;
    case 3:
      block.line = static_cast<std::int32_t>(choice.below(40)) - 4;
      break;
    case 4:
      if (picture->blocks.size() > 1 && choice.below(2) == 0) {
        picture->blocks.erase(picture->blocks.begin() + static_cast<std::ptrdiff_t>(at));
      } else {
        picture->blocks.push_back(Block(block));
      }
      break;
    default:
      block.bytes = changed_block(block.bytes, picture->zip, choice);
  }
  return written(*picture);
}

}  // namespace simuli::test
