#include "io/log/camera_mask.hpp"

#include <gtest/gtest.h>

#include "io/base/file.hpp"
#include "io/log/log.hpp"
#include "tests/io/scratch.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;
using test::expect_input_error;
using test::Scratch;

Camera small_camera() {
  Camera camera;
  camera.name = "front";
  camera.width = 8;
  camera.height = 6;
  camera.fx = camera.fy = 6.0;
  camera.cx = 4.0;
  camera.cy = 3.0;
  return camera;
}

/// Returns a mask of the lowest rows.
Image hood(int width, int height, int rows) {
  Image image(width, height, 3);
  for (int y = height - rows; y < height; ++y) {
    for (int x = 0; x < width; ++x) image.data[3 * static_cast<std::size_t>(y * width + x)] = 1.0F / 255.0F;
  }
  return image;
}

int hidden_rows(const CameraMask& mask, int width, int height) {
  int rows = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 1; x < width; ++x)
      EXPECT_EQ(mask.hides(x, y, width, height), mask.hides(0, y, width, height)) << x << ", " << y;
    rows += mask.hides(0, y, width, height) ? 1 : 0;
  }
  return rows;
}

TEST(CameraMask, HidesWhatIsNotZeroInPicturesOfAnySize) {
  const Scratch scratch;
  write_image(scratch / "hood.png", hood(8, 6, 2));
  const CameraMask mask = read_camera_mask(scratch / "hood.png", small_camera());
  EXPECT_EQ(hidden_rows(mask, 8, 6), 2);
  EXPECT_EQ(hidden_rows(mask, 4, 3), 1);
  EXPECT_EQ(hidden_rows(mask, 5, 4), 2);  // 1.33 rows of the mask: all rows with any hidden part
  // Another size with the same aspect ratio.
  write_image(scratch / "half.png", hood(4, 3, 1));
  EXPECT_EQ(read_camera_mask(scratch / "half.png", small_camera()).hidden, mask.hidden);
  write_image(scratch / "large.png", hood(80, 60, 20));
  EXPECT_EQ(read_camera_mask(scratch / "large.png", small_camera()).hidden, mask.hidden);

  Image picture(4, 3, 3);
  std::fill(picture.data.begin(), picture.data.end(), 0.5F);
  hide(mask, picture);
  for (int y = 0; y < 3; ++y) {
    for (int x = 0; x < 4; ++x) {
      for (int c = 0; c < 3; ++c) EXPECT_EQ(picture.at(x, y, c), y == 2 ? kHiddenValue : 0.5F);
    }
  }

  CameraMask both = mask;
  CameraMask corner{8, 6, std::vector<std::uint8_t>(48, 0)};
  corner.hidden[0] = 1;
  both.add(corner);
  EXPECT_TRUE(both.hides(0, 0, 8, 6));
  EXPECT_FALSE(both.hides(1, 0, 8, 6));
  EXPECT_TRUE(both.hides(7, 5, 8, 6));
}

TEST(CameraMask, RefusesOtherShapesAndThoseThatLeaveNothing) {
  const Scratch scratch;
  write_image(scratch / "tall.png", hood(6, 8, 2));
  expect_input_error([&] { (void)read_camera_mask(scratch / "tall.png", small_camera()); },
                     {"tall.png", "6 x 8", "8 x 6 as camera front"});
  write_image(scratch / "vast.png", hood(256, 192, 2));
  expect_input_error([&] { (void)read_camera_mask(scratch / "vast.png", small_camera()); },
                     {"vast.png", "256 x 192", "up to 16 times as wide"});
  write_image(scratch / "all.png", hood(8, 6, 6));
  expect_input_error([&] { (void)read_camera_mask(scratch / "all.png", small_camera()); },
                     {"all.png", "all of the picture"});
  expect_input_error([&] { (void)read_camera_mask(scratch.file("text.png", "hood"), small_camera()); },
                     {"text.png"});
}

/// Returns a log of one camera without frames.
Log log_of_a_camera(const fs::path& folder) {
  Log log;
  log.folder = folder;
  log.cameras.push_back({small_camera(), Pose{}});
  log.world_from_rig = Trajectory({{0.0, Pose{}}, {1.0, Pose{}}});
  return log;
}

TEST(CameraMask, IsPartOfTheLog) {
  const Scratch scratch;
  fs::create_directories(scratch / "plain");
  Log log = log_of_a_camera(scratch / "plain");
  write_log(log);
  EXPECT_TRUE(read_log(scratch / "plain").hidden.empty());
  const std::string plain_hash = log_hash(log);

  write_image(scratch / "hood.png", hood(8, 6, 2));
  write_image(scratch / "roof.png", hood(4, 3, 2));
  log.masks = {{"front", "masks/front/hood.png"}, {"front", "masks/front/roof.png"}};
  copy_log(log,
           scratch / "masked",
           {{"masks/front/hood.png", scratch / "hood.png"}, {"masks/front/roof.png", scratch / "roof.png"}});
  const Log read = read_log(scratch / "masked");
  ASSERT_EQ(read.masks.size(), 2U);
  EXPECT_EQ(read.masks[1].file, "masks/front/roof.png");
  ASSERT_EQ(read.hidden.count("front"), 1U);
  EXPECT_EQ(hidden_rows(*read.hidden.at("front"), 8, 6), 4);  // the union of both masks
  EXPECT_NE(log_hash(read), plain_hash);
  // A separate file: later changes of the source have no effect.
  EXPECT_EQ(fs::hard_link_count(scratch / "masked" / "masks/front/hood.png"), 1U);
  copy_log(read, scratch / "again");
  EXPECT_EQ(hidden_rows(*read_log(scratch / "again").hidden.at("front"), 8, 6), 4);

  const auto refused = [&](const LogMask& mask, const std::vector<std::string>& reported) {
    Log wrong = read;
    wrong.masks = {mask};
    write_log(wrong);
    expect_input_error([&] { (void)read_log(scratch / "masked"); }, reported);
  };
  refused({"rear", "masks/front/hood.png"}, {"masks[0].camera", "rear"});
  refused({"front", "../hood.png"}, {"masks[0].file", "../hood.png"});
  refused({"front", "masks/front/none.png"}, {"none.png"});
}

}  // namespace
}  // namespace simuli
