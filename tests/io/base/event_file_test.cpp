#include "io/base/event_file.hpp"

#include <cstring>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "io/base/file.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

std::uint64_t fixed(const std::string& bytes, std::size_t at, std::size_t size) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < size; ++i) {
    value |= std::uint64_t{static_cast<unsigned char>(bytes.at(at + i))} << (8 * i);
  }
  return value;
}

/// Returns the messages of a file with valid checksums.
std::vector<std::string> records(const std::string& bytes) {
  std::vector<std::string> out;
  for (std::size_t at = 0; at < bytes.size();) {
    const std::uint64_t length = fixed(bytes, at, 8);
    EXPECT_EQ(fixed(bytes, at + 8, 4), masked_crc32c(bytes.substr(at, 8)));
    out.push_back(bytes.substr(at + 12, length));
    EXPECT_EQ(fixed(bytes, at + 12 + length, 4), masked_crc32c(out.back()));
    at += 16 + length;
  }
  return out;
}

TEST(EventFile, ChecksumIsCastagnolis) {
  // The standard check value of CRC-32C is 0xE3069283; masked: rotated by 15 and offset.
  const std::uint32_t crc = 0xE3069283U;
  EXPECT_EQ(masked_crc32c("123456789"), (crc >> 15U | crc << 17U) + 0xA282EAD8U);
}

TEST(EventFile, HoldsEveryPoint) {
  const test::Scratch scratch;
  EventFile events(scratch / "runs" / "one", 1.0e9);
  events.scalar("train/psnr_db", 300, 21.5, 1.0e9 + 2.0);
  // Complete on disk while the file is still open.
  const std::vector<std::string> messages = records(read_file(events.file()));
  ASSERT_EQ(messages.size(), 2U);
  EXPECT_NE(messages[0].find("brain.Event:2"), std::string::npos);
  const std::string& m = messages[1];
  double time_s = 0.0;
  const std::uint64_t time_bits = fixed(m, 1, 8);
  std::memcpy(&time_s, &time_bits, sizeof(time_s));
  EXPECT_EQ(m[0], '\x09');  // field 1, eight bytes
  EXPECT_EQ(time_s, 1.0e9 + 2.0);
  EXPECT_EQ(m.substr(9, 3), std::string("\x10\xAC\x02"));  // field 2: 300
  const std::size_t tag = m.find("train/psnr_db");
  ASSERT_NE(tag, std::string::npos);
  float value = 0.0F;
  const auto value_bits = static_cast<std::uint32_t>(fixed(m, tag + 14, 4));
  std::memcpy(&value, &value_bits, sizeof(value));
  EXPECT_EQ(m[tag + 13], '\x15');  // field 2, four bytes
  EXPECT_EQ(value, 21.5F);
}

}  // namespace
}  // namespace simuli
