#include "host/serve/session/hoods.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <system_error>

#include "host/base/error.hpp"
#include "host/serve/session/refusal.hpp"
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

Image multiplied_by_alpha(Image hood) {
  for (std::size_t i = 0; i < hood.data.size(); i += 4) {
    for (std::size_t c = 0; c < 3; ++c) hood.data[i + c] *= hood.data[i + 3];
  }
  return hood;
}

}  // namespace

Hoods::Hoods(const fs::path& folder) {
  for (const fs::path& rig : entries_of(folder)) {
    std::error_code ignored;
    if (!fs::is_directory(rig, ignored)) continue;
    for (const fs::path& file : entries_of(rig)) {
      if (file.extension() != ".png") continue;
      hoods_.emplace(HoodId{rig.filename().string(), file.stem().string()},
                     multiplied_by_alpha(read_image_with_alpha(file)));
    }
  }
}

std::vector<HoodId> Hoods::ids() const {
  std::vector<HoodId> ids;
  for (const auto& [id, hood] : hoods_) ids.push_back(id);
  return ids;
}

void Hoods::need(const HoodId& id) const {
  if (hoods_.contains(id)) return;
  std::vector<std::string> known;
  for (const auto& [there, hood] : hoods_) known.push_back(there.rig + '/' + there.camera);
  throw Refusal(RefusalKind::kNotFound,
                fmt::format("ego_mask_id: found {}/{}, allowed {}",
                            id.rig,
                            id.camera,
                            known.empty() ? "none: the server has no --egocar-hood-dir"
                                          : fmt::format("{}", fmt::join(known, ", "))));
}

void Hoods::lay_over(Image& picture, const HoodId& id) const {
  need(id);
  const Image& stored = hoods_.at(id);
  const bool fits = stored.width == picture.width && stored.height == picture.height;
  const Image scaled = fits ? Image() : resize_area(stored, picture.width, picture.height);
  const Image& hood = fits ? stored : scaled;
  for (std::size_t i = 0; i < hood.data.size() / 4; ++i) {
    const float passed = 1.0F - hood.data[4 * i + 3];
    for (std::size_t c = 0; c < 3; ++c) {
      float& value = picture.data[3 * i + c];
      value = std::clamp(hood.data[4 * i + c] + passed * value, 0.0F, 1.0F);
    }
  }
}

}  // namespace simuli::serve
