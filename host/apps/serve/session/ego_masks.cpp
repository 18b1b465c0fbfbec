#include "host/apps/serve/session/ego_masks.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <system_error>

#include "host/apps/serve/session/refusal.hpp"
#include "host/core/base/error.hpp"
#include "io/picture/image.hpp"

namespace simuli::serve {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> entries;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    entries.push_back(it->path());
  }
  if (error) throw_input_error(folder.string(), "folder", error.message(), "one that can be read");
  std::sort(entries.begin(), entries.end());
  return entries;
}

Image multiplied_by_alpha(Image mask) {
  for (std::size_t i = 0; i < mask.data.size(); i += 4) {
    for (std::size_t c = 0; c < 3; ++c) mask.data[i + c] *= mask.data[i + 3];
  }
  return mask;
}

}  // namespace

EgoMasks::EgoMasks(const fs::path& folder) {
  for (const fs::path& rig : entries_of(folder)) {
    std::error_code ignored;
    if (!fs::is_directory(rig, ignored)) continue;
    for (const fs::path& file : entries_of(rig)) {
      if (file.extension() != ".png") continue;
      ego_masks_.emplace(EgoMaskId{rig.filename().string(), file.stem().string()},
                         multiplied_by_alpha(read_image_with_alpha(file)));
    }
  }
}

std::vector<EgoMaskId> EgoMasks::ids() const {
  std::vector<EgoMaskId> ids;
  for (const auto& [id, mask] : ego_masks_) ids.push_back(id);
  return ids;
}

void EgoMasks::need(const EgoMaskId& id) const {
  if (ego_masks_.contains(id)) return;
  std::vector<std::string> known;
  for (const auto& [there, mask] : ego_masks_) known.push_back(there.rig + '/' + there.camera);
  throw Refusal(RefusalKind::kNotFound,
                fmt::format("ego_mask_id: found {}/{}, allowed {}",
                            id.rig,
                            id.camera,
                            known.empty() ? "none: the server has no --egocar-hood-dir"
                                          : fmt::format("{}", fmt::join(known, ", "))));
}

void EgoMasks::lay_over(Image& picture, const EgoMaskId& id) const {
  need(id);
  const Image& stored = ego_masks_.at(id);
  const bool fits = stored.width == picture.width && stored.height == picture.height;
  const Image scaled = fits ? Image() : resize_area(stored, picture.width, picture.height);
  const Image& mask = fits ? stored : scaled;
  for (std::size_t i = 0; i < mask.data.size() / 4; ++i) {
    const float passed = 1.0F - mask.data[4 * i + 3];
    for (std::size_t c = 0; c < 3; ++c) {
      float& value = picture.data[3 * i + c];
      value = std::clamp(mask.data[4 * i + c] + passed * value, 0.0F, 1.0F);
    }
  }
}

}  // namespace simuli::serve
