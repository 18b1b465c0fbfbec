#pragma once
// Records the support of a trained scene by its training frames.
#include <cstddef>
#include <memory>

#include "host/core/record/support_record.hpp"
#include "host/device/render/options/options.hpp"
#include "host/device/runtime/device.hpp"
#include "io/log/frame_selection.hpp"
#include "io/log/log.hpp"
#include "io/scene/scene_folder.hpp"

namespace simuli {

/// Largest number of recorded frames per sensor, evenly spread over its training frames.
inline constexpr std::size_t kMostRecordedViews = 240;

/// Renders the training frames (`frames`) of each sensor, mounted as in `scene`, and compares them with the
/// recorded ones: for each cell of viewing directions the distance, the scene's error and the contrast of the
/// recorded colours. Throws Error{kInput} when a frame cannot be read.
[[nodiscard]] std::shared_ptr<const SupportRecord> record_support(const Device& device,
                                                                  const Log& log,
                                                                  const SceneFile& scene,
                                                                  const FrameSelection& frames,
                                                                  const RenderOptions& render);

}  // namespace simuli
