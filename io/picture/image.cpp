#include "io/picture/image.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <memory>
#include <string_view>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/picture/codec/picture_codec.hpp"
#include "io/picture/exr_header.hpp"
#include "io/picture/sized_image.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

/// 3 GiB as float RGB; larger claims are refused before allocation.
constexpr std::int64_t kMostPixels = std::int64_t{1} << 28U;

/// Joins the library's messages to one line.
std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back())) != 0) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text.empty() ? "an unreadable picture" : text;
}

/// JPEG decoders fill a truncated picture with grey and only warn; check the end marker.
void require_jpeg_end(const fs::path& file) {
  const std::string bytes = read_file(file);
  if (bytes.rfind("\xFF\xD9") == std::string::npos) {
    throw_input_error(file.string(), "content", "no end marker (truncated)", "a whole JPEG");
  }
}

/// The PNG library prints to stderr for truncated files, but an error must be one line; check the chunks first.
/// Accepts files of other formats.
void require_whole_png(const fs::path& file) {
  constexpr std::string_view kSignature("\x89PNG\r\n\x1a\n", 8);
  constexpr std::size_t kChunkFrame = 12;  // length, name, checksum
  std::ifstream stream(file, std::ios::binary);
  std::string head(kSignature.size(), '\0');
  if (!stream.read(head.data(), static_cast<std::streamsize>(head.size())) || head != kSignature) return;
  stream.close();
  const std::string bytes = read_file(file);
  std::size_t place = kSignature.size();
  while (bytes.size() - place >= kChunkFrame) {
    std::size_t length = 0;
    for (std::size_t k = 0; k < 4; ++k) length = length << 8U | static_cast<unsigned char>(bytes[place + k]);
    const std::string name = bytes.substr(place + 4, 4);
    const std::size_t left = bytes.size() - place - kChunkFrame;
    if (length > left) {
      throw_input_error(
          file.string(), "PNG chunk", fmt::format("{} bytes of {} (truncated)", left, length), "all of them");
    }
    if (name == "IEND") return;
    place += kChunkFrame + length;
  }
  throw_input_error(file.string(), "PNG end chunk", "none (truncated)", "a whole picture");
}

/// Formats detected by the first bytes. The library would use the extension and otherwise try all its decoders,
/// including those of videos and raw pictures, on untrusted files.
struct Format {
  std::string_view start;
  const char* name;
};
constexpr std::array<Format, 9> kFormats{{{"\x89PNG", "png"},
                                          {"\xFF\xD8", "jpeg"},
                                          {"\x76\x2F\x31\x01", "exr"},
                                          {std::string_view("II*\0", 4), "tiff"},
                                          {std::string_view("MM\0*", 4), "tiff"},
                                          {"RIFF", "webp"},
                                          {"BM", "bmp"},
                                          {"P5", "pnm"},
                                          {"P6", "pnm"}}};

/// Returns the opened picture and its format's name.
std::pair<std::unique_ptr<PictureInput>, std::string_view> open_picture(const fs::path& file) {
  constexpr std::size_t kStart = 4;
  std::string start(kStart, '\0');
  std::ifstream(file, std::ios::binary).read(start.data(), kStart);
  const auto format = std::find_if(
      kFormats.begin(), kFormats.end(), [&](const Format& f) { return start.starts_with(f.start); });
  const auto refuse = [&](const std::string& found) {
    throw_input_error(file.string(), "picture", one_line(found), "a readable picture");
  };
  if (format == kFormats.end()) {
    std::error_code ignored;
    refuse(fs::exists(file, ignored) ? "neither PNG, JPEG, EXR, TIFF, WebP, BMP nor PNM" : "no such file");
  }
  if (format->name == std::string_view("exr")) require_sound_exr_header(file);
  std::string failure;
  std::unique_ptr<PictureInput> input = picture_codec().open(format->name, file, failure);
  if (!input) refuse(failure);
  return {std::move(input), format->name};
}

void require_size(const fs::path& file, const PictureLayout& layout) {
  for (const auto& [field, side] : {std::pair{"width_px", layout.width}, {"height_px", layout.height}}) {
    if (side < 1 || side > kLargestSide_px) {
      throw_input_error(file.string(), field, std::to_string(side), fmt::format("1 to {}", kLargestSide_px));
    }
  }
  if (layout.depth > 1 || std::int64_t{layout.width} * layout.height > kMostPixels) {
    throw_input_error(file.string(),
                      "size_px",
                      fmt::format("{} x {} x {}", layout.width, layout.height, layout.depth),
                      fmt::format("at most {} pixels in one layer", kMostPixels));
  }
  if (layout.channels < 1 || layout.channels > 4) {
    throw_input_error(file.string(), "channels", std::to_string(layout.channels), "1 to 4");
  }
}

/// Refuses pictures that few bytes claim to be large. Deflate expands at most 1032 times, to 8256 one-bit
/// pixels per byte; the other formats expand less. EXR, TIFF and WebP may store a picture of one colour in very
/// few bytes.
void require_pixels_for(const fs::path& file, std::string_view format, const PictureLayout& layout) {
  constexpr std::int64_t kPixelsPerByte = 1 << 14;
  if (format == "exr" || format == "tiff" || format == "webp") return;
  const auto bytes = static_cast<std::int64_t>(fs::file_size(file));
  if (std::int64_t{layout.width} * layout.height <= kPixelsPerByte * bytes) return;
  throw_input_error(file.string(),
                    "size_px",
                    fmt::format("{} x {}", layout.width, layout.height),
                    fmt::format("as many as {} bytes hold", bytes));
}

bool has_float_pixels(const fs::path& file) { return file.extension() == ".exr"; }

void require_writable(const fs::path& file, const Image& image) {
  const std::string name = file.string();
  if (image.width < 1 || image.width > kLargestSide_px || image.height < 1 ||
      image.height > kLargestSide_px) {
    throw_input_error(
        name, "size_px", fmt::format("{} x {}", image.width, image.height), "1 to 65536 a side");
  }
  if (image.channels != 1 && image.channels != 3) {
    throw_input_error(name, "channels", std::to_string(image.channels), "1 or 3");
  }
  const std::size_t count = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) *
                            static_cast<std::size_t>(image.channels);
  if (image.data.size() != count) {
    throw_input_error(
        name, "data", fmt::format("{} values", image.data.size()), fmt::format("{} values", count));
  }
  if (has_float_pixels(file)) return;
  const auto bad = std::find_if(image.data.begin(), image.data.end(), [](float v) { return std::isnan(v); });
  if (bad != image.data.end()) {
    const auto pixel = (bad - image.data.begin()) / image.channels;
    throw_input_error(name,
                      fmt::format("pixel ({}, {})", pixel % image.width, pixel / image.width),
                      "NaN",
                      "numbers in an 8-bit picture");
  }
}

void need_jpeg_size(const fs::path& file, int width, int height) {
  if (std::max(width, height) <= kMostJpeg_px) return;
  throw_input_error(file.string(),
                    "picture",
                    fmt::format("{} x {} px", width, height),
                    fmt::format("at most {} px a side of JPEG", kMostJpeg_px));
}

void write_pixels(const fs::path& file, const PictureSamples& picture) {
  const std::string extension = file.extension().string();
  if (extension == ".jpg" || extension == ".jpeg") {
    need_jpeg_size(file, picture.layout.width, picture.layout.height);
  }
  write_atomically(file, [&](const fs::path& temporary) {
    if (const PictureFailure failure = picture_codec().write(temporary, picture)) {
      throw_input_error(file.string(),
                        "picture",
                        one_line(*failure),
                        "a path ending in png, jpg or exr with room for all of it (is the disk full?)");
    }
  });
}

/// Weights of the old pixels [first, first + weights.size()) in a new pixel; their sum is 1.
struct Footprint {
  int first = 0;
  std::vector<float> weights;
};

std::vector<Footprint> footprints(int old_size, int new_size) {
  std::vector<Footprint> out(static_cast<std::size_t>(new_size));
  const double scale = static_cast<double>(old_size) / new_size;
  for (int i = 0; i < new_size; ++i) {
    const double low = i * scale;
    const double high = std::min((i + 1) * scale, static_cast<double>(old_size));
    Footprint& footprint = out[static_cast<std::size_t>(i)];
    footprint.first = std::min(static_cast<int>(low), old_size - 1);
    for (int j = footprint.first; j < old_size && (j < high || j == footprint.first); ++j) {
      const double overlap = std::min(high, j + 1.0) - std::max(low, static_cast<double>(j));
      footprint.weights.push_back(static_cast<float>(std::max(overlap, 0.0) / (high - low)));
    }
  }
  return out;
}

/// Opens a picture whose header is within the limits.
std::pair<std::unique_ptr<PictureInput>, std::string_view> open_sound(const fs::path& file) {
  need_regular_file(file);
  require_whole_png(file);
  auto opened = open_picture(file);
  require_size(file, opened.first->layout());
  require_pixels_for(file, opened.second, opened.first->layout());
  return opened;
}

/// Reads all channels of the file.
Image read_stored(const fs::path& file, const std::function<void(int, int)>& need_size) {
  const auto [input, format] = open_sound(file);
  const PictureLayout layout = input->layout();
  if (need_size) need_size(layout.width, layout.height);
  Image stored;
  stored.width = layout.width;
  stored.height = layout.height;
  stored.channels = layout.channels;
  if (const PictureFailure failure = input->read(stored.data))
    throw_input_error(file.string(), "pixels", one_line(*failure), "a whole picture");
  if (format == "jpeg") require_jpeg_end(file);
  return stored;
}

std::vector<unsigned char> bytes_of(const Image& image) {
  std::vector<unsigned char> bytes(image.data.size());
  to_bytes(image.data, bytes);
  return bytes;
}

fs::path name_for(ImageCode code) {
  switch (code) {
    case ImageCode::kPng:
      return "picture.png";
    case ImageCode::kJpeg:
      return "picture.jpg";
    case ImageCode::kJpeg2000:
      break;
  }
  return "picture.jp2";
}

std::string encode_bytes(
    std::span<const unsigned char> pixels, int width, int height, int channels, ImageCode code, int quality) {
  const fs::path name = name_for(code);
  // least side for its six resolution levels; smaller files are unreadable
  constexpr int kLeastOfJpeg2000 = 32;
  if (code == ImageCode::kJpeg2000 && std::min(width, height) < kLeastOfJpeg2000) {
    throw_input_error(name.string(),
                      "picture",
                      fmt::format("{} x {} px", width, height),
                      fmt::format("{} a side and more of JPEG 2000", kLeastOfJpeg2000));
  }
  if (code == ImageCode::kJpeg) need_jpeg_size(name, width, height);
  PictureSamples picture{{width, height, 1, channels}, SampleType::kUint8, pixels.data()};
  if (code == ImageCode::kJpeg) picture.attributes = {{"Compression", fmt::format("jpeg:{}", quality)}};
  std::string bytes;
  if (const PictureFailure failure = picture_codec().encode(name.string(), picture, bytes))
    throw_input_error(name.string(), "picture", one_line(*failure), "one that can be encoded");
  return bytes;
}

/// Converts to three colour channels (grey is replicated), followed by alpha if `channels` is 4.
Image as_colors(const Image& stored, int channels) {
  Image out(stored.width, stored.height, channels);
  const bool is_grey = stored.channels < 3, has_alpha = stored.channels % 2 == 0;
  const auto from = static_cast<std::size_t>(stored.channels), to = static_cast<std::size_t>(channels);
  for (std::size_t i = 0; i < stored.data.size() / from; ++i) {
    const float* const pixel = &stored.data[from * i];
    for (std::size_t c = 0; c < 3; ++c) out.data[to * i + c] = pixel[is_grey ? 0 : c];
    if (channels == 4) out.data[to * i + 3] = has_alpha ? pixel[from - 1] : 1.0F;
  }
  return out;
}

}  // namespace

Image read_image(const fs::path& file) { return read_image(file, nullptr); }

std::pair<int, int> size_of_image(const fs::path& file) {
  const PictureLayout layout = open_sound(file).first->layout();
  return {layout.width, layout.height};
}

Image read_image(const fs::path& file, const std::function<void(int, int)>& need_size) {
  Image stored = read_stored(file, need_size);
  return stored.channels == 3 ? stored : as_colors(stored, 3);
}

Image read_image(const fs::path& file, int width, int height, const std::string& whose) {
  return read_image(file, [&](int found_width, int found_height) {
    if (found_width == width && found_height == height) return;
    throw_input_error(file.string(),
                      "size_px",
                      fmt::format("{} x {}", found_width, found_height),
                      fmt::format("{} x {} of {}", width, height, whose));
  });
}

Image read_image_with_alpha(const fs::path& file) { return as_colors(read_stored(file, nullptr), 4); }

void write_image(const fs::path& file, const Image& image) {
  require_writable(file, image);
  const PictureLayout layout{image.width, image.height, 1, image.channels};
  if (has_float_pixels(file)) {
    write_pixels(file, {layout, SampleType::kFloat, image.data.data(), reproducible_exr()});
  } else {
    write_pixels(file, {layout, SampleType::kUint8, bytes_of(image).data()});
  }
}

void write_counts(const fs::path& file, const Image& image) {
  require_writable(file, image);
  if (image.channels != 1 && image.channels != 3)
    throw_input_error(file.string(), "channels", std::to_string(image.channels), "1 or 3");
  if (file.extension() != ".png")
    throw_input_error(file.string(), "extension", file.extension().string(), ".png");
  std::vector<std::uint16_t> counts;
  counts.reserve(image.data.size());
  for (const float value : image.data) {
    if (!(value >= 0.0F && value <= 65535.0F) || value != std::floor(value)) {
      throw_input_error(file.string(), "pixels", fmt::format("{}", value), "whole numbers, 0 to 65535");
    }
    counts.push_back(static_cast<std::uint16_t>(value));
  }
  write_pixels(file, {{image.width, image.height, 1, image.channels}, SampleType::kUint16, counts.data()});
}

std::string encode_image(const Image& image, ImageCode code, int quality) {
  require_writable(name_for(code), image);
  return encode_bytes(bytes_of(image), image.width, image.height, image.channels, code, quality);
}

std::string encode_pixels(
    std::span<const unsigned char> pixels, int width, int height, ImageCode code, int quality) {
  if (width < 1 || height < 1 ||
      pixels.size() != std::size_t{3} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format(
            "pixels: found {} bytes, allowed 3 for each of {} x {} pixels", pixels.size(), width, height));
  }
  return encode_bytes(pixels, width, height, 3, code, quality);
}

void to_bytes(std::span<const float> values, std::span<unsigned char> bytes) {
  if (values.size() != bytes.size()) {
    throw Error(ErrorKind::kUsage,
                fmt::format("bytes: found room for {}, allowed {}", bytes.size(), values.size()));
  }
  // Half a step is rounded up, values below it are not: adding 0.5 would round some values just below it up.
  // Blocks of constant length are vectorised.
  const auto byte_of = [](float value) {
    const float above = value > 0.0F ? value : 0.0F;  // also for NaN
    const float steps = (above < 1.0F ? above : 1.0F) * 255.0F;
    const int whole = static_cast<int>(steps);
    return static_cast<unsigned char>(whole + (steps - static_cast<float>(whole) >= 0.5F ? 1 : 0));
  };
  constexpr std::size_t kBlock = 16;
  const float* from = values.data();
  unsigned char* to = bytes.data();
  std::size_t left = values.size();
  for (; left >= kBlock; left -= kBlock, from += kBlock, to += kBlock) {
    for (std::size_t k = 0; k < kBlock; ++k) to[k] = byte_of(from[k]);
  }
  for (std::size_t k = 0; k < left; ++k) to[k] = byte_of(from[k]);
}

Image resize_area(const Image& image, int width, int height) {
  if (width < 1 || width > kLargestSide_px || height < 1 || height > kLargestSide_px) {
    throw_input_error("resize", "size_px", fmt::format("{} x {}", width, height), "1 to 65536 a side");
  }
  if (image.width < 1 || image.height < 1) {
    throw_input_error("resize", "picture", fmt::format("{} x {}", image.width, image.height), "not empty");
  }
  const std::vector<Footprint> across = footprints(image.width, width);
  const std::vector<Footprint> down = footprints(image.height, height);
  Image out(width, height, image.channels);
  std::vector<float> mixed_row(static_cast<std::size_t>(image.width) *
                               static_cast<std::size_t>(image.channels));
  for (int y = 0; y < height; ++y) {
    const Footprint& rows = down[static_cast<std::size_t>(y)];
    std::fill(mixed_row.begin(), mixed_row.end(), 0.0F);
    for (std::size_t j = 0; j < rows.weights.size(); ++j) {
      const std::size_t start = (static_cast<std::size_t>(rows.first) + j) * mixed_row.size();
      for (std::size_t i = 0; i < mixed_row.size(); ++i) {
        mixed_row[i] += rows.weights[j] * image.data[start + i];
      }
    }
    for (int x = 0; x < width; ++x) {
      const Footprint& columns = across[static_cast<std::size_t>(x)];
      for (int c = 0; c < image.channels; ++c) {
        float sum = 0.0F;
        for (std::size_t j = 0; j < columns.weights.size(); ++j) {
          const std::size_t column = static_cast<std::size_t>(columns.first) + j;
          sum += columns.weights[j] *
                 mixed_row[column * static_cast<std::size_t>(image.channels) + static_cast<std::size_t>(c)];
        }
        out.at(x, y, c) = sum;
      }
    }
  }
  return out;
}

}  // namespace simuli
