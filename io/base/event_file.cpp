#include "io/base/event_file.hpp"

#include <array>
#include <bit>
#include <cstdint>
#include <fmt/format.h>
#include <system_error>

#include "host/core/base/error.hpp"
#include "io/base/bytes.hpp"

namespace simuli {
namespace {

// Protobuf's wire format: a key of field number and type, followed by the value.
constexpr unsigned kVarint = 0, kFixed64 = 1, kBytes = 2, kFixed32 = 5;

void append_varint(std::string& out, std::uint64_t value) {
  for (; value >= 0x80U; value >>= 7U) out += static_cast<char>((value & 0x7FU) | 0x80U);
  out += static_cast<char>(value);
}

void append_key(std::string& out, unsigned field, unsigned type) { append_varint(out, field << 3U | type); }

void append_double(std::string& out, unsigned field, double value) {
  append_key(out, field, kFixed64);
  append_little_endian(out, std::bit_cast<std::uint64_t>(value), 8);
}

void append_float(std::string& out, unsigned field, float value) {
  append_key(out, field, kFixed32);
  append_little_endian(out, std::bit_cast<std::uint32_t>(value), 4);
}

void append_bytes(std::string& out, unsigned field, const std::string& bytes) {
  append_key(out, field, kBytes);
  append_varint(out, bytes.size());
  out += bytes;
}

std::array<std::uint32_t, 256> make_crc_table() {
  constexpr std::uint32_t kCastagnoli = 0x82F63B78U;  // reversed bits
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1U ^ ((crc & 1U) != 0 ? kCastagnoli : 0U);
    table[byte] = crc;
  }
  return table;
}

}  // namespace

std::uint32_t masked_crc32c(const std::string& bytes) {
  static const std::array<std::uint32_t, 256> kTable = make_crc_table();
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char c : bytes) crc = crc >> 8U ^ kTable[(crc ^ static_cast<unsigned char>(c)) & 0xFFU];
  crc ^= 0xFFFFFFFFU;
  constexpr std::uint32_t kMaskOffset = 0xA282EAD8U;
  return (crc >> 15U | crc << 17U) + kMaskOffset;
}

EventFile::EventFile(const std::filesystem::path& folder, double start_s)
    : file_(folder / fmt::format("events.out.tfevents.{:010.0f}.simuli", start_s)) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  stream_.open(file_, std::ios::binary | std::ios::trunc);
  if (failed || !stream_)
    throw_input_error(folder.string(), "folder", "not writable", "one that can be written");
  std::string message;
  append_double(message, 1, start_s);
  append_bytes(message, 3, "brain.Event:2");
  record(message);
}

void EventFile::scalar(const std::string& tag, std::int64_t step, double value, double time_s) {
  std::string point;
  append_bytes(point, 1, tag);
  append_float(point, 2, static_cast<float>(value));
  std::string summary;
  append_bytes(summary, 1, point);
  std::string message;
  append_double(message, 1, time_s);
  append_key(message, 2, kVarint);
  append_varint(message, static_cast<std::uint64_t>(step));
  append_bytes(message, 5, summary);
  record(message);
}

void EventFile::record(const std::string& message) {
  std::string length;
  append_little_endian(length, message.size(), 8);
  std::string out = length;
  append_little_endian(out, masked_crc32c(length), 4);
  out += message;
  append_little_endian(out, masked_crc32c(message), 4);
  stream_.write(out.data(), static_cast<std::streamsize>(out.size()));
  if (!stream_.flush()) throw_input_error(file_.string(), "record", "not written", "a writable file");
}

}  // namespace simuli
