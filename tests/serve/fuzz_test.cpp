// Messages from anybody: a reply or a refusal, never an internal error, in bounded memory.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>
#include <gtest/gtest.h>
#include <iostream>
#include <random>

#include "host/apps/serve/messages/render_message.hpp"
#include "tests/serve/served_scene.hpp"

namespace simuli::serve {
namespace {

using ServedFuzz = test::Served;

constexpr std::chrono::seconds kLong{3};
constexpr std::uint64_t kFewest =
    200;  // messages, however long: one may ask for kernels that nobody has compiled yet

/// $SIMULI_SERVE_FUZZ: as many messages of each kind at the handlers instead of kLong and kFewest, of which
/// one in kRendered is rendered; the others are read, checked and prepared.
std::uint64_t asked_for() {
  const char* const count = std::getenv("SIMULI_SERVE_FUZZ");
  return count == nullptr ? 0 : std::strtoull(count, nullptr, 10);
}
constexpr std::uint64_t kRendered = 1000;

/// Gives up when it is asked the next time after `asks`: a render call asks before each frame that it
/// renders.
Call given_up_after(int asks) {
  return {[left = asks]() mutable { return left-- <= 0; }};
}

/// Bytes flipped, cut, doubled, and numbers that hurt put in.
std::string mutated(std::string bytes, std::mt19937& random) {
  const auto below = [&](std::size_t n) {
    return static_cast<std::size_t>(random()) % std::max<std::size_t>(n, 1);
  };
  static const std::vector<std::string> kHurt{std::string("\x00\x00\xC0\x7F", 4),  // NaN
                                              std::string("\x00\x00\x80\x7F", 4),  // infinity
                                              std::string(8, '\xFF'),
                                              std::string("\x00\x00\x00\x00\x00\x00\xF8\x7F", 8),
                                              std::string("\x00\x00\x00\x00\x00\x00\xF0\xFF", 8),
                                              std::string(4, '\x00')};
  for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
    const std::size_t at = below(bytes.size());
    switch (below(6)) {
      case 0:
        if (!bytes.empty()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(8)));
        break;
      case 1:
        if (!bytes.empty()) bytes[at] = static_cast<char>(random());
        break;
      case 2: {
        const std::string& hurt = kHurt[below(kHurt.size())];
        bytes.replace(at, std::min(hurt.size(), bytes.size() - at), hurt);
        break;
      }
      case 3:
        bytes.erase(at, below(20));
        break;
      case 4:
        bytes.insert(at, bytes.substr(below(bytes.size()), below(60)));
        break;
      default:
        bytes.resize(at);
    }
  }
  return bytes;
}

/// Small where it would be rendered: the time is for messages.
void bound(proto::RGBRenderRequest& request) {
  constexpr std::uint32_t kSide = 64;
  const double pixels = static_cast<double>(request.resolution_w()) * request.resolution_h();
  if (pixels > kMostPixels) return;
  request.set_resolution_w(std::min(request.resolution_w(), kSide));
  request.set_resolution_h(std::min(request.resolution_h(), kSide));
}

struct Counts {
  std::uint64_t answered = 0, refused = 0, unread = 0;
  [[nodiscard]] std::uint64_t handled() const { return answered + refused; }
};

template <class Message, class Handle>
Counts fuzz(const std::vector<Message>& seeds, std::uint32_t seed, const Handle& handle) {
  google::protobuf::SetLogHandler(nullptr);             // of text that is no UTF-8
  for (Message message : seeds) handle(message, true);  // kernels are compiled before the time runs
  std::mt19937 random(seed);
  Counts counts;
  const auto end = std::chrono::steady_clock::now() + kLong;
  const std::uint64_t wanted = asked_for();
  while (wanted > 0 ? counts.handled() < wanted
                    : std::chrono::steady_clock::now() < end || counts.handled() < kFewest) {
    const std::string bytes = mutated(seeds[random() % seeds.size()].SerializeAsString(), random);
    Message message;
    if (!message.ParseFromString(bytes)) {
      ++counts.unread;
      continue;
    }
    try {
      handle(message, wanted == 0 || counts.handled() % kRendered == 0);
      ++counts.answered;
    } catch (...) {
      const Refusal refusal = refusal_of(std::current_exception());
      if (refusal.kind() == RefusalKind::kCancelled) {  // before it was rendered
        ++counts.answered;
        continue;
      }
      EXPECT_NE(static_cast<int>(refusal.kind()), static_cast<int>(RefusalKind::kInternal))
          << refusal.what() << '\n'
          << message.ShortDebugString();
      EXPECT_EQ(std::string(refusal.what()).find('\n'), std::string::npos);
      ++counts.refused;
    }
  }
  if (wanted > 0) {
    std::cout << fmt::format("{} messages handled: {} answered, {} refused, {} unread\n",
                             counts.handled(),
                             counts.answered,
                             counts.refused,
                             counts.unread);
  }
  return counts;
}

void expect_all(const Counts& counts) {
  EXPECT_GT(counts.answered, 10U);
  EXPECT_GT(counts.refused, 10U);
  EXPECT_GT(counts.unread, 10U);
}

TEST_F(ServedFuzz, Pictures) {
  std::vector<proto::RGBRenderRequest> seeds;
  for (const char* const camera : {"front", "rolling", "fisheye", "wide", "mirror"}) {
    for (const bool is_own : {true, false}) {
      seeds.push_back(picture_request(camera, 0.5, 0.75));
      if (!is_own && seeds.back().camera_intrinsics().camera_param_case() != 0) {
        seeds.back().mutable_camera_intrinsics()->set_logical_id("x");
      }
    }
  }
  expect_all(fuzz(seeds, 1, [&](proto::RGBRenderRequest& request, bool is_rendered) {
    if (!is_rendered) {
      proto::RGBRenderReturn reply;
      handlers_->render_rgb(given_up_after(0), request, reply);
      return;
    }
    bound(request);
    const std::string picture = rendered(request);
    if (request.image_format() == proto::RGB_UINT8_PLANAR) {
      EXPECT_EQ(picture.size(), std::size_t{3} * request.resolution_w() * request.resolution_h());
    }
  }));
}

TEST_F(ServedFuzz, Batches) {
  proto::BatchRGBRenderRequest batch;
  for (const char* const camera : {"front", "wide"}) {
    *batch.add_items()->mutable_request() = picture_request(camera, 0.5, 0.75);
  }
  // Items tell of their errors themselves: what is refused as a whole is too much of them.
  const Counts counts = fuzz<proto::BatchRGBRenderRequest>(
      {batch}, 2, [&](proto::BatchRGBRenderRequest& request, bool is_rendered) {
        for (auto& item : *request.mutable_items()) bound(*item.mutable_request());
        proto::BatchRGBRenderReturn reply;
        handlers_->batch_render_rgb(
            is_rendered ? Call{} : given_up_after(request.items_size()), request, reply);
        EXPECT_EQ(reply.items_size(), request.items_size());
        for (const auto& item : reply.items()) {
          EXPECT_EQ(item.success(), item.error_message().empty());
          EXPECT_EQ(item.error_message().find("internal error"), std::string::npos) << item.error_message();
        }
      });
  EXPECT_GT(counts.answered, 10U);
  EXPECT_GT(counts.unread, 10U);
}

TEST_F(ServedFuzz, Sweeps) {
  auto filtered = sweep_request(0.5, 0.625);
  filtered.mutable_render_filter()->set_raydrop_threshold(0.7F);
  filtered.mutable_render_filter()->set_opacity_threshold(0.7F);
  expect_all(fuzz<proto::LidarRenderRequest>({sweep_request(0.5, 0.625), filtered},
                                             3,
                                             [&](const proto::LidarRenderRequest& request, bool is_rendered) {
                                               if (!is_rendered) {
                                                 Call call = given_up_after(0);
                                                 call.lidar = "top";
                                                 proto::LidarRenderReturn reply;
                                                 handlers_->render_lidar(call, request, reply);
                                                 return;
                                               }
                                               const auto reply = rendered(request);
                                               EXPECT_EQ(reply.point_xyzs_buffer().size(),
                                                         12U * reply.num_points());
                                             }));
}

TEST_F(ServedFuzz, Edits) {
  const Handlers handlers(*session_, EgoMasks(), "", {.allows_edits = true, .most_more_particles = 1000});
  proto::EditAssetsRequest edits;
  edits.set_scene_id(test::kSceneId);
  proto::ReplaceAssetAction& replace = *edits.add_replace();
  replace.set_original_id("van");
  replace.set_replacement_id("car");
  proto::DynamicObjectTrack& object = *edits.add_insert();
  object.set_id("second");
  object.set_asset_id("car");
  object.mutable_object_size()->set_size_x(8.0F);
  object.mutable_object_size()->set_size_y(4.0F);
  object.mutable_object_size()->set_size_z(3.0F);
  for (const KeyPose& key : file_.scene.actors[0].track) {
    auto& pose = *object.mutable_trajectory()->add_poses();
    pose.set_timestamp_us(scene_->microseconds(key.time_s));
    *pose.mutable_pose() = message_of(scene_->local(key.world_from_actor));
  }
  const auto request = picture_request("front", 0.5, 0.5);
  const std::string before = rendered(request);
  proto::RestoreModelParametersRequest restore;
  restore.set_scene_id(test::kSceneId);
  int right = 0, wrong = 0;
  const Counts counts = fuzz<proto::EditAssetsRequest>(
      {edits}, 4, [&](const proto::EditAssetsRequest& requested, bool is_rendered) {
        proto::EditAssetsResponse reply;
        handlers.edit_assets({}, requested, reply);
        ++(reply.success() ? right : wrong);
        EXPECT_EQ(reply.success(), reply.message().empty());
        if (is_rendered) static_cast<void>(rendered(request));
        if (reply.success()) handlers.restore_model_parameters({}, restore);
      });
  EXPECT_GT(right, 10);
  EXPECT_GT(wrong, 10);
  EXPECT_GT(counts.refused, 10U);
  handlers.restore_model_parameters({}, restore);
  EXPECT_EQ(rendered(request), before);
}

}  // namespace
}  // namespace simuli::serve
