#include "io/archive/npz.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "io/base/bytes.hpp"

namespace simuli {
namespace {

/// Returns an array as a .npy file, format 1.0.
std::string npy(const std::string& dtype, const std::vector<std::size_t>& shape, const std::string& data) {
  std::string header = fmt::format("{{'descr': '{}', 'fortran_order': False, 'shape': ({}{}), }}",
                                   dtype,
                                   fmt::join(shape, ", "),
                                   shape.size() == 1 ? "," : "");
  constexpr std::size_t kFrame = 10, kAlignment = 64;  // magic, version and length; alignment of the data
  while ((kFrame + header.size() + 1) % kAlignment != 0) header.push_back(' ');
  header.push_back('\n');
  std::string out("\x93NUMPY\x01\x00", 8);
  append_little_endian(out, header.size(), 2);
  return out + header + data;
}

}  // namespace

void Npz::add(const std::string& name,
              const std::string& dtype,
              const std::vector<std::size_t>& shape,
              const std::string& data) {
  zip_.add(name + ".npy", npy(dtype, shape, data));
}

std::string Npz::finish() const { return zip_.finish(); }

}  // namespace simuli
