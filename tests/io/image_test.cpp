#include "io/picture/image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <string>
#include <sys/resource.h>

#include "io/base/file.hpp"
#include "io/picture/sized_image.hpp"
#include "tests/host/expect_error.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::Scratch;

/// Half a step of 8 bits, and float rounding.
constexpr float kEightBitTolerance = 0.5F / 255.0F + 1e-6F;

/// Returns a picture in which all neighbouring pixels and channels differ.
Image pattern(int width, int height, int channels) {
  Image image(width, height, channels);
  for (std::size_t i = 0; i < image.data.size(); ++i) {
    image.data[i] = static_cast<float>((i * 37) % 256) / 255.0F;
  }
  return image;
}

TEST(Image, PngKeepsEightBitValues) {
  const Scratch scratch;
  const Image image = pattern(17, 9, 3);
  write_image(scratch / "a.png", image);
  const Image read = read_image(scratch / "a.png");
  ASSERT_EQ(read.width, 17);
  ASSERT_EQ(read.height, 9);
  ASSERT_EQ(read.channels, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i) EXPECT_NEAR(read.data[i], image.data[i], 1e-6F);
}

TEST(Image, ExrKeepsEveryBit) {
  const Scratch scratch;
  Image image = pattern(8, 5, 3);
  image.at(3, 2, 1) = -17.25F;
  image.at(4, 2, 0) = 1e-7F;
  write_image(scratch / "a.exr", image);
  EXPECT_EQ(read_image(scratch / "a.exr").data, image.data);
}

/// Two writes give equal bits at any time.
TEST(Image, ExrKnowsNoDate) {
  const Scratch scratch;
  write_image(scratch / "a.exr", Image(4, 3, 3));
  const std::string written = read_file(scratch / "a.exr");
  EXPECT_NE(written.find("capDate"), std::string::npos);  // libraries write the current date by default
  EXPECT_NE(written.find("1970:01:01 00:00:00"), std::string::npos);
}

TEST(Image, JpegIsClose) {
  const Scratch scratch;
  Image image(32, 32, 3);
  for (float& value : image.data) value = 0.5F;
  write_image(scratch / "a.jpg", image);
  constexpr float kJpegTolerance = 3.0F / 255.0F;  // a flat picture loses a step or two of 8 bits
  for (const float value : read_image(scratch / "a.jpg").data) EXPECT_NEAR(value, 0.5F, kJpegTolerance);
}

TEST(Image, EncodesPixelsAsItWritesPictures) {
  const Image image = pattern(17, 9, 3);
  std::vector<unsigned char> pixels(image.data.size());
  to_bytes(image.data, pixels);
  EXPECT_EQ(encode_pixels(pixels, 17, 9, ImageCode::kPng), encode_image(image, ImageCode::kPng));
  EXPECT_EQ(encode_pixels(pixels, 17, 9, ImageCode::kJpeg, 80), encode_image(image, ImageCode::kJpeg, 80));
  EXPECT_NE(encode_pixels(pixels, 17, 9, ImageCode::kJpeg, 81), encode_image(image, ImageCode::kJpeg, 80));
  expect_error(ErrorKind::kUsage, "17 x 10 pixels", [&] {
    static_cast<void>(encode_pixels(pixels, 17, 10, ImageCode::kPng));
  });
}

TEST(Image, GreyBecomesThreeEqualChannels) {
  const Scratch scratch;
  const Image image = pattern(7, 3, 1);
  write_image(scratch / "grey.png", image);
  const Image read = read_image(scratch / "grey.png");
  ASSERT_EQ(read.channels, 3);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 7; ++x) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(read.at(x, y, c), image.at(x, y, 0), 1e-6F);
    }
  }
}

TEST(Image, EightBitFormatsClipWhatIsOutside) {
  const Scratch scratch;
  Image image(2, 1, 1);
  image.data = {-0.5F, 3.0F};
  write_image(scratch / "clip.png", image);
  const Image read = read_image(scratch / "clip.png");
  EXPECT_EQ(read.at(0, 0, 0), 0.0F);
  EXPECT_EQ(read.at(1, 0, 0), 1.0F);
}

TEST(Image, CountsKeepSixteenBits) {
  const Scratch scratch;
  Image counts(3, 1, 1);
  counts.data = {0.0F, 7.0F, 65535.0F};
  write_counts(scratch / "a.png", counts);
  const Image read = read_image(scratch / "a.png");
  for (std::size_t i = 0; i < 3; ++i) EXPECT_FLOAT_EQ(65535.0F * read.data[3 * i], counts.data[i]);
  const auto refused = [&](const char* name, const Image& image, const std::vector<std::string>& words) {
    expect_input_error([&] { write_counts(scratch / name, image); }, words);
    EXPECT_FALSE(std::filesystem::exists(scratch / name));
  };
  for (const float bad : {-1.0F, 0.5F, 65536.0F}) {
    counts.data[1] = bad;
    refused("b.png", counts, {"b.png", "0 to 65535"});
  }
  counts.data[1] = 7.0F;
  refused("b.exr", counts, {".png"});
  refused("b.png", Image(1, 1, 2), {"channels"});
  Image colours(1, 1, 3);
  colours.data = {7.0F, 65535.0F, 0.0F};
  write_counts(scratch / "c.png", colours);
  const Image back = read_image(scratch / "c.png");
  for (std::size_t i = 0; i < 3; ++i) EXPECT_FLOAT_EQ(65535.0F * back.data[i], colours.data[i]);
}

TEST(Image, RefusesTruncatedFiles) {
  const Scratch scratch;
  for (const std::string ending : {"png", "jpg", "exr"}) {
    write_image(scratch / ("whole." + ending), pattern(64, 64, 3));
    const std::string bytes = read_file(scratch / ("whole." + ending));
    for (const double share : {0.5, 0.9}) {
      const auto kept = static_cast<std::size_t>(share * static_cast<double>(bytes.size()));
      const fs::path file = scratch.file("cut." + ending, bytes.substr(0, kept));
      expect_input_error([&] { (void)read_image(file); }, {"cut." + ending, "found", "allowed"});
    }
  }
}

TEST(Image, RefusesWhatIsNoPicture) {
  const Scratch scratch;
  expect_input_error([&] { (void)read_image(scratch / "none.png"); }, {"none.png", "found", "allowed"});
  const fs::path text = scratch.file("text.png", "not a picture");
  expect_input_error([&] { (void)read_image(text); }, {"text.png", "found", "allowed"});
  const fs::path empty = scratch.file("empty.jpg", "");
  expect_input_error([&] { (void)read_image(empty); }, {"empty.jpg"});
}

TEST(Image, IsKnownByItsFirstBytes) {
  const Scratch scratch;
  write_image(scratch / "a.png", pattern(4, 4, 3));
  fs::rename(scratch / "a.png", scratch / "really_png.jpg");
  EXPECT_EQ(read_image(scratch / "really_png.jpg").width, 4);
  // Other decoders are not tried: this is a valid Radiance picture.
  const fs::path other =
      scratch.file("a.png", std::string("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x80\x80\x80"));
  expect_input_error([&] { (void)read_image(other); }, {"a.png", "neither PNG", "allowed"});
}

TEST(Image, ChecksTheClaimedSizeBeforeItAllocates) {
  const Scratch scratch;
  write_image(scratch / "small.png", pattern(4, 4, 3));
  std::string bytes = read_file(scratch / "small.png");
  // IHDR: 4 bytes width, 4 bytes height from byte 16, its CRC after 13 bytes of content.
  const auto put = [&](std::size_t at, std::uint32_t value) {
    for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<char>(value >> (24 - 8 * i));
  };
  for (const auto& [side, allowed] : {std::pair{60000U, "allowed at most"}, {16000U, "as many as"}}) {
    put(16, side);
    put(20, side);
    std::uint32_t crc = 0xFFFFFFFFU;
    for (std::size_t i = 12; i < 29; ++i) {
      crc ^= static_cast<unsigned char>(bytes[i]);
      for (int k = 0; k < 8; ++k) crc = (crc >> 1U) ^ ((crc & 1U) != 0U ? 0xEDB88320U : 0U);
    }
    put(29, ~crc);
    const fs::path file = scratch.file("bomb.png", bytes);
    expect_input_error([&] { (void)read_image(file); }, {"bomb.png", std::to_string(side), allowed});
  }
  const fs::path grey = scratch.file("bomb.pgm", "P5 16000 16000 255\n some");
  expect_input_error([&] { (void)read_image(grey); }, {"bomb.pgm", "16000 x 16000", "as many as"});
  write_image(scratch / "black.png", Image(3000, 3000, 1));  // the smallest file with this many pixels
  EXPECT_EQ(read_image(scratch / "black.png").width, 3000);
}

/// If the size is known, a picture of another size is not decoded: these pixels are invalid.
TEST(Image, OfAnotherSizeIsRefusedByItsHeader) {
  const Scratch scratch;
  for (const std::string ending : {"png", "exr"}) {
    write_image(scratch / ("a." + ending), pattern(64, 48, 3));
    EXPECT_EQ(read_image(scratch / ("a." + ending), 64, 48, "camera front").width, 64);
    std::string bytes = read_file(scratch / ("a." + ending));
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 4 * 3), bytes.end() - 20, '\xA5');
    const fs::path file = scratch.file("broken." + ending, bytes);
    expect_input_error([&] { (void)read_image(file, 64, 48, "camera front"); }, {"broken.", "pixels"});
    expect_input_error([&] { (void)read_image(file, 48, 64, "camera front"); },
                       {"broken.", "size_px", "64 x 48", "48 x 64 of camera front"});
  }
}

/// A small header claims 2^28 pixels: memory is allocated as rows are read.
TEST(Image, TakesMemoryAsRowsCome) {
  const Scratch scratch;
  write_image(scratch / "small.exr", pattern(4, 4, 3));
  std::string bytes = read_file(scratch / "small.exr");
  for (const std::string window : {"dataWindow", "displayWindow"}) {
    const std::size_t corner =
        bytes.find(window) + window.size() + 1 + std::string("box2i").size() + 1 + 4 + 8;
    const std::int32_t last = 16383;
    for (std::size_t side = 0; side < 2; ++side) std::memcpy(&bytes[corner + 4 * side], &last, sizeof(last));
  }
  bytes.append(std::size_t{1} << 16U, '\0');  // the offsets of its blocks are invalid
  const fs::path file = scratch.file("bomb.exr", bytes);
  const auto peak_kB = [] {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    return used.ru_maxrss;
  };
  const long before_kB = peak_kB();
  expect_input_error([&] { (void)read_image(file); }, {"bomb.exr", "pixels: found"});
  EXPECT_LT(peak_kB() - before_kB, 200'000);  // of 3.2 GB
}

TEST(Image, RefusesWhatCannotBeWritten) {
  const Scratch scratch;
  Image image = pattern(4, 4, 3);
  expect_input_error([&] { write_image(scratch / "a.xyz", image); }, {"a.xyz", "allowed"});
  expect_input_error([&] { write_image(scratch / "a.png", Image(4, 4, 2)); }, {"channels", "found 2"});
  expect_input_error([&] { write_image(scratch / "a.png", Image(0, 4, 3)); }, {"size_px", "found 0 x 4"});
  image.at(2, 1, 0) = std::numeric_limits<float>::quiet_NaN();
  expect_input_error([&] { write_image(scratch / "a.png", image); }, {"pixel (2, 1)", "found NaN"});
  image.data.pop_back();
  expect_input_error([&] { write_image(scratch / "a.png", image); }, {"data", "47 values", "48 values"});
  EXPECT_TRUE(fs::is_empty(scratch.path()));
}

TEST(ResizeArea, HalvingAveragesFourPixels) {
  const Image image = pattern(8, 6, 3);
  const Image half = resize_area(image, 4, 3);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x) {
      for (int c = 0; c < 3; ++c) {
        const float mean = 0.25F * (image.at(2 * x, 2 * y, c) + image.at(2 * x + 1, 2 * y, c) +
                                    image.at(2 * x, 2 * y + 1, c) + image.at(2 * x + 1, 2 * y + 1, c));
        EXPECT_NEAR(half.at(x, y, c), mean, 1e-6F);
      }
    }
  }
}

TEST(ResizeArea, KeepsTheMeanAtAnySize) {
  const Image image = pattern(31, 17, 1);
  const auto mean = [](const Image& i) {
    double sum = 0.0;
    for (const float value : i.data) sum += value;
    return sum / static_cast<double>(i.data.size());
  };
  for (const auto& [w, h] : {std::pair{7, 5}, {31, 17}, {40, 33}, {1, 1}, {30, 1}}) {
    const Image resized = resize_area(image, w, h);
    constexpr double kFloatSums = 1e-6;
    EXPECT_NEAR(mean(resized), mean(image), kFloatSums) << w << " x " << h;
  }
  EXPECT_EQ(resize_area(image, 31, 17).data, image.data);
}

TEST(ResizeArea, WeighsPartlyCoveredPixels) {
  Image image(3, 1, 1);
  image.data = {0.0F, 0.3F, 0.9F};
  const Image two = resize_area(image, 2, 1);  // 1.5 old pixels each
  EXPECT_NEAR(two.at(0, 0, 0), (0.0F + 0.5F * 0.3F) / 1.5F, 1e-6F);
  EXPECT_NEAR(two.at(1, 0, 0), (0.5F * 0.3F + 0.9F) / 1.5F, 1e-6F);
  expect_input_error([&] { (void)resize_area(image, 0, 1); }, {"size_px", "found 0 x 1"});
}

TEST(Image, WholeStepsOfEightBitsAreRounded) {
  const Scratch scratch;
  Image image(1, 1, 1);
  image.data = {100.4F / 255.0F};
  write_image(scratch / "a.png", image);
  EXPECT_NEAR(read_image(scratch / "a.png").at(0, 0, 0), image.data[0], kEightBitTolerance);
}

TEST(ImageFile, BytesAreThoseOfAPng) {
  const Scratch scratch;
  std::vector<float> values{-1.0F, 0.0F, 1.0F, 2.0F};
  for (int step = 0; step < 255; ++step) {  // at and next to the limit between two bytes
    const float edge = (static_cast<float>(step) + 0.5F) / 255.0F;
    values.insert(values.end(), {std::nextafter(edge, 0.0F), edge, std::nextafter(edge, 1.0F)});
  }
  Image image(static_cast<int>(values.size()), 1, 1);
  image.data = values;
  write_image(scratch / "steps.png", image);
  const Image stored = read_image(scratch / "steps.png");
  std::vector<unsigned char> bytes(values.size());
  to_bytes(values, bytes);
  for (std::size_t i = 0; i < values.size(); ++i) {
    EXPECT_EQ(bytes[i], std::lround(255.0F * stored.data[3 * i])) << values[i];
    std::vector<unsigned char> alone(1);
    to_bytes(std::span(values).subspan(i, 1), alone);
    EXPECT_EQ(alone[0], bytes[i]) << values[i];  // at any position
    const double steps = 255.0 * static_cast<double>(std::clamp(values[i], 0.0F, 1.0F));
    EXPECT_LE(std::abs(steps - bytes[i]), 0.5 + 1e-5) << values[i];
  }
  expect_error(
      ErrorKind::kUsage, "bytes: found room for 1", [&] { to_bytes(values, std::span(bytes).first(1)); });
}

/// libjpeg would end the process.
TEST(Image, JpegHasALargestSize) {
  const Scratch scratch;
  for (const auto& [width, height] : {std::pair(65501, 1), std::pair(1, 65501)}) {
    Image image(width, height, 3);
    expect_error(ErrorKind::kInput, "at most 65500 px", [&] { (void)encode_image(image, ImageCode::kJpeg); });
    expect_error(ErrorKind::kInput, "at most 65500 px", [&] { write_image(scratch / "a.jpg", image); });
    EXPECT_FALSE(encode_image(image, ImageCode::kPng).empty());
  }
}

}  // namespace
}  // namespace simuli
