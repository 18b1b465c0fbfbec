#include <cstdint>
#include <cstring>
#include <gtest/gtest.h>
#include <string>

#include "io/archive/npz.hpp"
#include "io/archive/stored_zip.hpp"

namespace simuli {
namespace {

template <class T>
T number_at(const std::string& bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

/// "123456789" is the standard test of checksums: its CRC-32 is cbf43926.
TEST(StoredZip, IsByteForByteAsTheFormatSays) {
  StoredZip zip("a.zip");
  zip.add("a", "123456789");
  const std::string entry =
      std::string("\x14\0\0\0\0\0\0\0\x21\0\x26\x39\xf4\xcb\x09\0\0\0\x09\0\0\0\x01\0\0\0", 26);
  EXPECT_EQ(zip.finish(),
            "PK\x03\x04" + entry + "a123456789" + std::string("PK\x01\x02\x14\0", 6) + entry +
                std::string("\0\0\0\0\0\0\0\0\0\0\0\0\0\0", 14) + "a" +
                std::string("PK\x05\x06\0\0\0\0\x01\0\x01\0\x2f\0\0\0\x28\0\0\0\0\0", 22));
}

TEST(StoredZip, AlignsWhatFilesHold) {
  for (const std::size_t name_length : {1U, 2U, 30U, 31U, 32U, 33U, 34U, 35U, 100U}) {
    StoredZip zip("a.usdz", 64);
    for (const char first : {'a', 'b'})
      zip.add(std::string(name_length, first), std::string(first == 'a' ? 5 : 70, '#'));
    const std::string bytes = zip.finish();
    std::size_t at = 0;
    for (int i = 0; i < 2; ++i) {
      ASSERT_EQ(number_at<std::uint32_t>(bytes, at), 0x04034b50U);
      const std::size_t extra = number_at<std::uint16_t>(bytes, at + 28);
      EXPECT_TRUE(extra == 0 || extra >= 4);
      const std::size_t from = at + 30 + name_length + extra;
      EXPECT_EQ(from % 64, 0U) << name_length;
      EXPECT_EQ(bytes[from], '#');
      if (extra >= 4) {
        EXPECT_EQ(number_at<std::uint16_t>(bytes, at + 30 + name_length + 2), extra - 4);
      }
      at = from + number_at<std::uint32_t>(bytes, at + 18);
    }
  }
}

}  // namespace
}  // namespace simuli
