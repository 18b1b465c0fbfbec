// Tests each check of user options, by its key.
#include <functional>
#include <limits>
#include <set>

#include "host/core/base/fields.hpp"
#include "host/device/render/options/quality.hpp"
#include "host/device/render/options/validate.hpp"
#include "optim/eval/eval_options.hpp"
#include "optim/init/init_options.hpp"
#include "optim/train/training_options.hpp"
#include "tests/host/expect_error.hpp"

namespace simuli {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

template <class Options>
void expect_checked(const std::string& message, const std::function<void(Options&)>& spoil) {
  Options options;
  spoil(options);
  expect_error(ErrorKind::kUsage, message, [&] {
    if constexpr (std::is_same_v<Options, RenderOptions>) {
      validate(options);
    } else if constexpr (std::is_same_v<Options, TrainOptions>) {
      (void)checked(options);
    } else if constexpr (std::is_same_v<Options, InitOptions>) {
      check_fields(options);
    } else {
      check(options);
    }
  });
}

TEST(Options, DefaultsAreSound) {
  EXPECT_NO_THROW(validate(RenderOptions{}));
  EXPECT_NO_THROW(check_fields(InitOptions{}));
  EXPECT_NO_THROW((void)checked(TrainOptions{}));
  EXPECT_NO_THROW(check(EvalOptions{}));
  for (const Quality quality : {Quality::kDraft, Quality::kBalanced, Quality::kExact, Quality::kReference}) {
    EXPECT_NO_THROW(validate(options_of(quality)));
    TrainOptions train;
    train.render = training_options_of(quality);
    EXPECT_NO_THROW((void)checked(train));
  }
}

TEST(Options, KeysAreDifferentAndHaveAMeaning) {
  TrainingOptions training;
  const Fields all = fields_of(training);
  std::set<std::string> keys;
  for (const Field& field : all.all()) {
    EXPECT_TRUE(keys.insert(field.key).second) << field.key;
    EXPECT_FALSE(field.help.empty()) << field.key;
    EXPECT_TRUE(field.is_sound()) << field.key;
  }
}

TEST(Options, OfRenderingAreCheckedByKey) {
  const auto refused = expect_checked<RenderOptions>;
  refused("render.alpha_cut: found 2, allowed 1e-30 to 0.5", [](auto& o) { o.alpha_cut = 2.0; });
  refused("render.alpha_cut: found nan", [](auto& o) { o.alpha_cut = kNaN; });
  refused("render.shutter_iterations: found 65, allowed 0 to 64", [](auto& o) { o.shutter_iterations = 65; });
  refused("render.transmittance_cut: found -1", [](auto& o) { o.transmittance_cut = -1.0; });
  refused("render.camera_filter_px2: found 101", [](auto& o) { o.camera_filter_px2 = 101.0; });
  refused("render.camera_near_m: found 0, allowed 0.01 to 1000", [](auto& o) { o.camera_near_m = 0.0; });
  refused("render.max_pairs: found 0, allowed 1 or more", [](auto& o) { o.max_pairs = 0; });
  refused("render.projection: found another value than unscented with render.extent=exact", [](auto& o) {
    o.extent = Extent::kExact;
    o.projection = Projection::kLinearized;
  });
}

TEST(Options, OfInitialisationAreCheckedByKey) {
  const auto refused = expect_checked<InitOptions>;
  refused("init.voxel_m: found 0, allowed 0.001 to 50", [](auto& o) { o.voxel_m = 0.0; });
  refused("init.camera_sh_degree: found 4, allowed 0 to 3", [](auto& o) { o.camera_sh_degree = 4; });
  refused("init.environment_width: found 9, allowed 0, or 8 to 7200 and even",
          [](auto& o) { o.environment_width = 9; });
}

TEST(Options, OfTrainingAreCheckedByKey) {
  const auto refused = expect_checked<TrainOptions>;
  refused("camera.rate.sh: found -1, allowed 0 or more", [](auto& o) { o.camera.sh = -1.0; });
  refused("loss.ssim: found -1", [](auto& o) { o.image.dissimilarity = -1.0; });
  refused("loss.drop: found -1", [](auto& o) { o.weights.drop = -1.0; });
  refused("anchor.weight: found -1, allowed 0 or more", [](auto& o) { o.anchor.weight = -1.0; });
  refused("prune.weight: found 2, allowed 0 to 1", [](auto& o) { o.prune.weight = 2.0; });
  refused("iterations: found -1", [](auto& o) { o.iterations = -1; });
  refused("render.alpha_cut: found 1", [](auto& o) { o.render.alpha_cut = 1.0; });
}

TEST(Options, OfFramesAreCheckedByKey) {
  const auto refused = [](const std::string& message, const std::function<void(FrameSelection&)>& spoil) {
    TrainingOptions options;
    spoil(options.frames);
    expect_error(ErrorKind::kUsage, message, [&] { (void)checked(options); });
  };
  refused("held_out_every: found 1, allowed 0, or 2 or more", [](auto& o) { o.held_out_every = 1; });
  refused("held_out_every: found -5", [](auto& o) { o.held_out_every = -5; });
  refused("held_out_last: found 1, allowed 0 to 0.9", [](auto& o) { o.held_out_last = 1.0; });
  refused("held_out_middle: found 1, allowed 0 to 0.9", [](auto& o) { o.held_out_middle = 1.0; });
  refused("held_out_last: found nan", [](auto& o) { o.held_out_last = kNaN; });
  refused("image_scale: found 0, allowed above 0, at most 1", [](auto& o) { o.image_scale = 0.0; });
  refused("image_scale: found nan", [](auto& o) { o.image_scale = kNaN; });
}

TEST(Options, OfEvaluationAreCheckedByKey) {
  const auto refused = expect_checked<EvalOptions>;
  refused("timed_renders: found 0, allowed 1 or more", [](auto& o) { o.timed_renders = 0; });
  refused("render.window: found 1", [](auto& o) { o.render.window = 1; });
}

}  // namespace
}  // namespace simuli
