#include "host/apps/serve/session/ego_masks.hpp"

#include <gtest/gtest.h>

#include "host/apps/serve/messages/render_message.hpp"
#include "tests/serve/ego_mask_picture.hpp"
#include "tests/serve/served_scene.hpp"

namespace simuli::serve {
namespace {

using test::expect_refusal;
using EgoMask = test::Served;

TEST_F(EgoMask, LiesOverThePicture) {
  test::write_ego_mask(scratch_ / "ego_masks" / "rig" / "front.png");
  const EgoMasks ego_masks(scratch_ / "ego_masks");
  ASSERT_EQ(ego_masks.ids(), (std::vector<EgoMaskId>{{"rig", "front"}}));
  Image picture(4, 4, 3);
  std::fill(picture.data.begin(), picture.data.end(), 0.25F);
  ego_masks.lay_over(picture, {"rig", "front"});
  EXPECT_EQ(picture.at(1, 1, 0), 1.0F);
  EXPECT_EQ(picture.at(1, 1, 1), 0.0F);
  EXPECT_NEAR(picture.at(3, 0, 1), 128.0 / 255.0 + 0.25 * 127.0 / 255.0, 1e-6);
  EXPECT_EQ(picture.at(0, 3, 2), 0.25F);
  expect_refusal(RefusalKind::kNotFound, "allowed rig/front", [&] { ego_masks.need({"rig", "rear"}); });
}

TEST_F(EgoMask, IsListedAndAskedFor) {
  test::write_ego_mask(scratch_ / "ego_masks" / "rig" / "front.png");
  const Handlers handlers(*session_, EgoMasks(scratch_ / "ego_masks"), "");
  proto::AvailableEgoMasksReturn masks;
  handlers.get_available_ego_masks(masks);
  ASSERT_EQ(masks.ego_mask_metadata_size(), 1);
  auto request = picture_request("front", 0.5, 0.5);
  proto::RGBRenderReturn plain, covered, png;
  handlers.render_rgb({}, request, plain);
  request.set_insert_ego_mask(true);
  *request.mutable_ego_mask_id() = masks.ego_mask_metadata(0).ego_mask_id();
  handlers.render_rgb({}, request, covered);
  ASSERT_EQ(covered.image_bytes().size(), plain.image_bytes().size());
  const std::size_t pixels = plain.image_bytes().size() / 3, lower_half = pixels / 2;
  EXPECT_EQ(static_cast<unsigned char>(covered.image_bytes()[0]), 255);
  EXPECT_EQ(static_cast<unsigned char>(covered.image_bytes()[pixels]), 0);
  EXPECT_EQ(covered.image_bytes().substr(lower_half, lower_half),
            plain.image_bytes().substr(lower_half, lower_half));
}

TEST_F(EgoMask, FoldersAreRead) {
  EXPECT_TRUE(EgoMasks().ids().empty());
  test::expect_input_error([&] { static_cast<void>(EgoMasks(scratch_ / "nowhere")); }, {"nowhere", "folder"});
  std::filesystem::create_directories(scratch_ / "bad" / "rig");
  static_cast<void>(scratch_.file("bad/rig/front.png", "no picture"));
  test::expect_input_error([&] { static_cast<void>(EgoMasks(scratch_ / "bad")); }, {"front.png", "picture"});
}

}  // namespace
}  // namespace simuli::serve
