#include "io/base/npz.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <zlib.h>

#include "host/base/error.hpp"
#include "io/base/bytes.hpp"

namespace simuli {
namespace {

/// As a .npy file, format 1.0.
std::string npy(const std::string& dtype, const std::vector<std::size_t>& shape, const std::string& data) {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}{}), }}",
                                   dtype,
                                   fmt::join(shape, ", "),
                                   shape.size() == 1 ? "," : "");
  constexpr std::size_t kFrame = 10, kAlignment = 64;  // magic, version and length; where the data start
  while ((kFrame + header.size() + 1) % kAlignment != 0) header.push_back(' ');
  header.push_back('\n');
  std::string out("\x93NUMPY\x01\x00", 8);
  append_little_endian(out, header.size(), 2);
  return out + header + data;
}

}  // namespace

/// Into a zip archive, the earliest date zip knows.
void Npz::add(const std::string& name,
              const std::string& dtype,
              const std::vector<std::size_t>& shape,
              const std::string& data) {
  constexpr std::size_t kMost = 0xffffffffU;  // of the format without its extension
  const std::string bytes = npy(dtype, shape, data), file = name + ".npy";
  if (out_.size() + bytes.size() > kMost) {
    throw_input_error(file_, "size", "more than 4 GiB", "less, or another format");
  }
  const auto crc = crc32_z(0, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
  std::string entry;                   // what the local header and the directory share
  append_little_endian(entry, 20, 2);  // version 2.0
  append_little_endian(entry, 0, 2);
  append_little_endian(entry, 0, 2);  // stored
  append_little_endian(entry, 0, 2);
  append_little_endian(entry, 0x21, 2);  // 1 January 1980
  append_little_endian(entry, crc, 4);
  append_little_endian(entry, bytes.size(), 4);
  append_little_endian(entry, bytes.size(), 4);
  append_little_endian(entry, file.size(), 2);
  append_little_endian(entry, 0, 2);
  directory_ += std::string("PK\x01\x02\x14\x00", 6) + entry;
  directory_.append(10, '\0');
  append_little_endian(directory_, out_.size(), 4);
  directory_ += file;
  out_ += "PK\x03\x04" + entry + file + bytes;
  ++count_;
}

std::string Npz::finish() const {
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
