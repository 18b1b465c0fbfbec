#pragma once
// What a trained scene keeps of the frames that it was trained on.
#include <cstddef>
#include <memory>

#include "host/core/record/support_record.hpp"
#include "host/device/render/options/options.hpp"
#include "host/device/runtime/device.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli {

/// Frames that are kept of a sensor, at most: evenly spread over those that it recorded.
inline constexpr std::size_t kMostRecordedViews = 240;

/// Renders the training frames of each sensor with the scene and compares them with what was recorded: for
/// each cell of a frame's directions how far what is there is, how wrong the scene is and how much the
/// recorded colours change. A sensor's frames are those from which training learned (`frames`); it sits where
/// `scene` says. Error{kInput} when a frame can't be read.
[[nodiscard]] std::shared_ptr<const SupportRecord> record_support(const Device& device,
                                                                  const Log& log,
                                                                  const SceneFile& scene,
                                                                  const FrameSelection& frames,
                                                                  const RenderOptions& render);

}  // namespace simuli
