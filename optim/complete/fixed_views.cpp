#include "optim/complete/fixed_views.hpp"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <fmt/format.h>
#include <utility>

#include "host/core/base/splitmix.hpp"
#include "host/device/render/scene/scene_on_device.hpp"
#include "host/device/support/support.hpp"
#include "io/log/camera_mask.hpp"
#include "optim/base/frames.hpp"
#include "optim/complete/record_support.hpp"
#include "optim/complete/run_fixer.hpp"

namespace simuli {

constexpr double kFirstShare =
    0.5;  // share of the iterations before the program is first called, when scenes are complete
constexpr int kEvery = 2;  // iterations per repaired picture

FixedViews::FixedViews(const Device& device,
                       const Log& log,
                       const FrameSelection& frames,
                       const FixerOptions& options,
                       std::string command,
                       const RenderOptions& render)
    : device_(device),
      log_(log),
      frames_(frames),
      options_(options),
      command_(std::move(command)),
      render_(render) {}

bool FixedViews::is_due(int iteration, int iterations) const {
  if (command_.empty()) return false;
  for (int round = 0; round < options_.rounds; ++round) {
    const double share = kFirstShare + (1.0 - kFirstShare) * static_cast<double>(round) / options_.rounds;
    if (iteration == static_cast<int>(share * iterations)) return true;
  }
  return false;
}

std::vector<FixedView> FixedViews::planned() const {
  const std::vector<std::size_t> training = HeldOutRule(log_, frames_).training(log_.images);
  const std::size_t count = std::min(training.size(), static_cast<std::size_t>(options_.views));
  std::vector<FixedView> views;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t index = training[(2 * i + 1) * training.size() / (2 * count)];
    const ImageFrame& frame = log_.images[index];
    for (const double left_m : {options_.shift_m, -options_.shift_m}) {
      const Pose& rig_from_camera = log_.camera(frame.camera).rig_from_camera;
      views.push_back({.camera = frame.camera,
                       .shot = shot_of(log_, frame).shifted_left(rig_from_camera, left_m),
                       .left_m = left_m,
                       .frame = index,
                       .values = {},
                       .known = 0});
    }
  }
  return views;
}

void FixedViews::repair(const SceneFile& scene, int iteration) {
  SceneOnDevice on_device(device_, borrowed(scene.scene), render_);
  SupportOnDevice support(device_, record_support(device_, log_, scene, frames_, render_));
  std::vector<FixedView> views = planned();
  std::vector<FixerView> requested;
  for (const FixedView& view : views) {
    const Camera camera = scaled_camera(log_.camera(view.camera).model, frames_.image_scale);
    const Frame frame = on_device.render(Sensor(camera), view.shot, {.graded = false});
    requested.push_back({.name = fmt::format("{:06d}", requested.size()),
                         .camera = camera,
                         .world_from_camera = view.shot.pose_at(0.5),
                         .time_s = view.shot.middle_s(),
                         .left_m = view.left_m,
                         .rendered = frame.image(),
                         .support = support.image_of(frame, scene.scene),
                         .recorded = load_image(log_, log_.images[view.frame], camera)});
  }
  const std::vector<Image> repaired = run_fixer(command_, requested, iteration);
  for (std::size_t k = 0; k < views.size(); ++k) {
    FixedView& view = views[k];
    view.values = planar(repaired[k]);
    const std::vector<float>& known = requested[k].support.data;
    for (std::size_t i = 0; i < known.size(); ++i) {
      if (drawn(frames_.seed, k, i) >= static_cast<double>(known[i])) {
        ++view.known;
        continue;
      }
      for (std::size_t c = 0; c < 3; ++c) view.values[c * known.size() + i] = kHiddenValue;
    }
  }
  views_ = std::move(views);
}

const FixedView* FixedViews::turn(int iteration) const {
  if (views_.empty() || iteration % kEvery != 0) return nullptr;
  const FixedView& view = views_[static_cast<std::size_t>(iteration / kEvery) % views_.size()];
  return view.known > 0 ? &view : nullptr;
}

void FixedViews::add_state(StateList& list) {
  if (command_.empty()) return;
  list.add(
      "fixer/pictures",
      [this] {
        std::vector<float> all;
        for (const FixedView& view : views_) all.insert(all.end(), view.values.begin(), view.values.end());
        StateList::Bytes bytes(all.size() * sizeof(float));
        if (!bytes.empty()) std::memcpy(bytes.data(), all.data(), bytes.size());
        return bytes;
      },
      [this](const std::string& file, std::span<const std::byte> saved) {
        views_.clear();
        if (saved.empty()) return;
        std::vector<FixedView> views = planned();
        std::size_t at = 0;
        for (FixedView& view : views) {
          const Camera camera = scaled_camera(log_.camera(view.camera).model, frames_.image_scale);
          const std::size_t pixels =
              static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
          view.values.resize(3 * pixels);
          if (at + view.values.size() * sizeof(float) > saved.size()) break;
          std::memcpy(view.values.data(), saved.data() + at, view.values.size() * sizeof(float));
          at += view.values.size() * sizeof(float);
          view.known = static_cast<std::size_t>(std::count_if(
              view.values.begin(), view.values.begin() + static_cast<std::ptrdiff_t>(pixels), [](float v) {
                return v >= 0.0F;
              }));
        }
        if (at != saved.size() || views.back().values.empty()) {
          throw_input_error(file,
                            "fixer/pictures",
                            fmt::format("{} bytes", saved.size()),
                            "all pictures of the log's views");
        }
        views_ = std::move(views);
      });
}

}  // namespace simuli
