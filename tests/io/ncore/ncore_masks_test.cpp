// Tests ego masks to NCore and back.
#include <filesystem>
#include <gtest/gtest.h>
#include <set>

#include "io/base/file.hpp"
#include "io/log/camera_mask.hpp"
#include "io/picture/image.hpp"
#include "tests/io/ncore/ncore_fixture.hpp"

namespace simuli::test {
namespace {

TEST_F(NcoreTest, KeepsMasks) {
  Log log = street();
  Image hood(48, 27, 3);
  hood.data[0] = 1.0F;
  std::filesystem::create_directories(log.folder / "masks/front");
  write_image(log.folder / "masks/front/ego.png", hood);
  log.masks = {{"front", "masks/front/ego.png"}};
  const Log again = there_and_back(log);
  EXPECT_GT(again.hidden.at("front")->hidden_share(), 0.0);
  EXPECT_EQ(read_file(log.folder / "masks/front/ego.png"), read_file(again.folder / "masks/front/ego.png"));
  EXPECT_NE(report_.notes.at(report_.notes.size() - 1).find("masks/front/ego.png"), std::string::npos);
}

// NCore stores masks by a name without extension, and only as PNG.
TEST_F(NcoreTest, KeepsMasksOfOneNameAndOtherFormats) {
  Log log = street();
  std::filesystem::create_directories(log.folder / "masks/front");
  int hidden = 0;
  for (const char* file : {"masks/front/ego.png", "masks/front/ego.bmp", "masks/front/ego.exr"}) {
    Image picture(48, 27, 3);
    ++hidden;
    for (int i = 0; i < 3 * hidden; ++i) picture.data[static_cast<std::size_t>(i)] = 1.0F;
    write_image(log.folder / file, picture);
    log.masks.push_back({"front", file});
  }
  const Log again = there_and_back(log);
  ASSERT_EQ(again.masks.size(), 3U);
  std::set<double> shares;
  for (const LogMask& mask : again.masks)
    shares.insert(read_camera_mask(again.folder / mask.file, again.camera("front").model).hidden_share());
  EXPECT_EQ(shares, (std::set<double>{1.0 / (48 * 27), 2.0 / (48 * 27), 3.0 / (48 * 27)}));
  EXPECT_EQ(again.hidden.at("front")->hidden_share(), 3.0 / (48 * 27));
}

}  // namespace
}  // namespace simuli::test
