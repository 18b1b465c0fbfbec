// By itself: the picture library's headers and protobuf's don't go together.
#include "tests/serve/ego_mask_picture.hpp"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>
#include <vector>

namespace simuli::test {

void write_ego_mask(const std::filesystem::path& file) {
  std::filesystem::create_directories(file.parent_path());
  const std::vector<unsigned char> pixels{255, 0, 0, 255, 255, 255, 255, 128, 9, 9, 9, 0, 9, 9, 9, 0};
  OIIO::ImageSpec spec(2, 2, 4, OIIO::TypeDesc::UINT8);
  spec["oiio:UnassociatedAlpha"] = 1;
  const auto output = OIIO::ImageOutput::create(file.string());
  ASSERT_TRUE(output && output->open(file.string(), spec));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
  ASSERT_TRUE(output->close());
}

std::string stored_bytes(const std::filesystem::path& file) {
  const auto input = OIIO::ImageInput::open(file.string());
  if (!input) return {};
  const OIIO::ImageSpec& spec = input->spec();
  std::string bytes(spec.image_bytes(), '\0');
  const bool is_whole = input->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::UINT8, bytes.data());
  return is_whole ? bytes : std::string();
}

}  // namespace simuli::test
