// SPZ: header and particles as they are when unpacked, then packed again.
#include <array>
#include <cstdint>

#include "host/core/base/error.hpp"
#include "io/base/gzip.hpp"
#include "tests/fuzz/mutate/mutate.hpp"

namespace simuli::test {
namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 20U;
constexpr std::size_t kHeader = 16, kHeaderV4 = 32;
constexpr std::size_t kVersion = 4, kPoints = 8, kDegree = 12, kFraction = 13, kStreams = 15, kTable = 16;

/// Bytes of one particle in each stream.
std::array<std::size_t, 6> particle_bytes(const std::string& header) {
  const auto version = number_at<std::uint32_t>(header, kVersion);
  const std::size_t degree = static_cast<std::uint8_t>(header[kDegree]);
  return {version == 1 ? 6U : 9U, 1, 3, 3, version >= 3 ? 4U : 3U, 3 * ((degree + 1) * (degree + 1) - 1)};
}

/// Another version, count, degree or scale; what follows is as long as that asks for, if it is not too much.
std::string with_another_header(std::string all, Choice& choice) {
  switch (choice.below(5)) {
    case 0:
      all[kVersion] = static_cast<char>(choice.below(6));
      break;
    case 1:
      put_number(all, kPoints, static_cast<std::uint32_t>(choice.below(5)));
      break;
    case 2:
      all[kDegree] = static_cast<char>(choice.below(6));
      break;
    case 3:
      all[kFraction] = static_cast<char>(choice.below(26));
      break;
    default:
      return choice.change(all.substr(0, kHeader)).append(all, kHeader);
  }
  std::size_t needed = 0;
  for (const std::size_t bytes : particle_bytes(all)) needed += bytes;
  needed = kHeader + needed * number_at<std::uint32_t>(all, kPoints);
  if (needed <= kMostBytes && choice.below(4) != 0) all.resize(needed, 'x');
  return all;
}

/// A Zstandard frame of bytes as they are.
std::string zstd_frame(const std::string& bytes) {
  std::string out;
  append_number(out, std::uint32_t{0xFD2FB528U});
  out += '\xA0';  // one segment, its size in four bytes
  append_number(out, static_cast<std::uint32_t>(bytes.size()));
  const auto block = static_cast<std::uint32_t>(bytes.size() << 3U | 1U);  // the last one, raw
  for (const unsigned shift : {0U, 8U, 16U}) out += static_cast<char>(block >> shift & 255U);
  return out + bytes;
}

/// Version 4: one stream changed, or the header.
std::optional<std::string> mutated_v4(const std::string& file, Choice& choice) {
  const std::size_t streams = static_cast<std::uint8_t>(file[kStreams]);
  const std::size_t table = number_at<std::uint32_t>(file, kTable);
  if (table < kHeaderV4 || table > file.size() || streams == 0 || (file.size() - table) / 16 < streams) {
    return std::nullopt;
  }
  std::string head = file.substr(0, kHeaderV4);
  std::array<std::string, 256> contents;
  std::size_t at = table + 16 * streams;
  for (std::size_t i = 0; i < streams; ++i) {
    const auto packed = number_at<std::uint64_t>(file, table + 16 * i);
    const auto size = number_at<std::uint64_t>(file, table + 16 * i + 8);
    if (packed > file.size() - at || size > kMostBytes) return std::nullopt;
    contents.at(i) = unzstd(file.data() + at, packed, size, "input");
    at += packed;
  }
  if (choice.below(4) == 0) {
    const std::string changed = with_another_header(head.substr(0, kHeader), choice).substr(0, kHeader);
    head.replace(0, changed.size(), changed);
    const std::size_t points = number_at<std::uint32_t>(head, kPoints);
    const auto bytes = particle_bytes(head);
    for (std::size_t i = 0; i < bytes.size() && points * bytes.at(i) < kMostBytes; ++i)
      contents.at(i).resize(points * bytes.at(i));
  } else {
    std::string& stream = contents.at(choice.below(streams));
    const std::string changed = choice.change(stream);
    stream = choice.below(4) == 0 ? changed : (changed + stream).substr(0, stream.size());
  }
  put_number(head, kTable, static_cast<std::uint32_t>(kHeaderV4));
  std::string frames;
  for (std::size_t i = 0; i < streams; ++i) {
    const std::string frame = zstd_frame(contents.at(i));
    append_number(head, static_cast<std::uint64_t>(frame.size()));
    append_number(head, static_cast<std::uint64_t>(contents.at(i).size()));
    frames += frame;
  }
  return head + frames;
}

}  // namespace

std::optional<std::string> mutated_spz(const std::string& file, Choice& choice) {
  try {
    const bool packed = is_gzip(file);
    std::string all = packed ? gunzip(file, "input", kMostBytes) : file;
    if (all.size() < kHeader) return std::nullopt;
    if (number_at<std::uint32_t>(all, kVersion) == 4 && all.size() >= kHeaderV4) {
      std::optional<std::string> changed = mutated_v4(all, choice);
      if (changed) return packed ? gzip(*changed) : std::move(changed);
    }
    if (choice.below(3) == 0) {
      all = with_another_header(std::move(all), choice);
    } else {
      // The same length most of the time: it is what the header is checked against.
      const std::string values = all.substr(kHeader), changed = choice.change(values);
      all.resize(kHeader);
      all += choice.below(4) == 0 ? changed : (changed + values).substr(0, values.size());
    }
    return gzip(all);
  } catch (const Error&) {
    return std::nullopt;
  }
}

}  // namespace simuli::test
