#include "io/archive/stored_zip.hpp"

#include <zlib.h>

#include "host/core/base/error.hpp"
#include "io/base/bytes.hpp"

namespace simuli {
namespace {

constexpr std::size_t kLocalHeader = 30, kDirectoryEntry = 46;
constexpr std::size_t kExtraHeader = 4;     // id and length of an extra field
constexpr std::uint64_t kPadding = 0xd935;  // id of an extra field for padding, as used by other writers
constexpr std::size_t kMost = 0xffffffffU;  // limit of the format without ZIP64
constexpr std::uint64_t kFirstOfJanuary1980 = 0x21;

}  // namespace

void StoredZip::add(const std::string& name, const std::string& bytes) {
  // Pads between the name and the data with an extra field that readers ignore.
  const std::size_t end = out_.size() + kLocalHeader + name.size();
  std::size_t extra = (alignment_ - end % alignment_) % alignment_;
  while (extra > 0 && extra < kExtraHeader) extra += alignment_;
  if (end + extra + bytes.size() + directory_.size() + kDirectoryEntry + name.size() > kMost) {
    throw_input_error(file_, "size", "more than 4 GiB", "less, or another format");
  }
  const auto crc = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  std::string entry;                   // fields that the local header and the directory share
  append_little_endian(entry, 20, 2);  // version 2.0
  append_little_endian(entry, 0, 2);
  append_little_endian(entry, 0, 2);  // stored
  append_little_endian(entry, 0, 2);
  append_little_endian(entry, kFirstOfJanuary1980, 2);
  append_little_endian(entry, crc, 4);
  append_little_endian(entry, bytes.size(), 4);
  append_little_endian(entry, bytes.size(), 4);
  append_little_endian(entry, name.size(), 2);
  directory_ += std::string("PK\x01\x02\x14\x00", 6) + entry;
  directory_.append(12, '\0');  // no extra field, no comment, first disk, no attributes
  append_little_endian(directory_, out_.size(), 4);
  directory_ += name;
  append_little_endian(entry, extra, 2);
  out_ += "PK\x03\x04" + entry + name;
  if (extra > 0) {
    append_little_endian(out_, kPadding, 2);
    append_little_endian(out_, extra - kExtraHeader, 2);
    out_.append(extra - kExtraHeader, '\0');
  }
  out_ += bytes;
  ++count_;
}

std::string StoredZip::finish() const {
  std::string end = "PK\x05\x06";
  append_little_endian(end, 0, 4);
  append_little_endian(end, count_, 2);
  append_little_endian(end, count_, 2);
  append_little_endian(end, directory_.size(), 4);
  append_little_endian(end, out_.size(), 4);
  append_little_endian(end, 0, 2);
  return out_ + directory_ + end;
}

}  // namespace simuli
