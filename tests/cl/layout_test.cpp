// Shared structs lie in memory as the host has them: a probe kernel reports sizes and offsets.
#include "cl/shared/layout.h"

#include <cstddef>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "host/runtime/kernel.hpp"
#include "host/runtime/text/source.hpp"

namespace simuli {
namespace {

using Offsets = std::vector<std::uint32_t>;

constexpr const char* kProbe = R"(
#define OFFSET(s, field) (uint)((__private char*)&(s).field - (__private char*)&(s))
__kernel void probe(__global uint* at) {
  FrameParams frame;
  Footprint footprint;
  at[0] = sizeof(FrameParams);
  at[1] = OFFSET(frame, particles);
  at[2] = OFFSET(frame, stride);
  at[3] = OFFSET(frame, tiles_x);
  at[4] = OFFSET(frame, tiles_y);
  at[5] = OFFSET(frame, rows);
  at[6] = OFFSET(frame, tile_rays);
  at[7] = OFFSET(frame, row_slots);
  at[8] = OFFSET(frame, slots);
  at[9] = sizeof(Footprint);
  at[10] = OFFSET(footprint, columns);
  at[11] = OFFSET(footprint, others);
  at[12] = OFFSET(footprint, rows);
  at[13] = OFFSET(footprint, tile_rows);
}
)";

Offsets host_offsets() {
  using shared::Footprint;
  using shared::FrameParams;
  return {sizeof(FrameParams),
          offsetof(FrameParams, particles),
          offsetof(FrameParams, stride),
          offsetof(FrameParams, tiles_x),
          offsetof(FrameParams, tiles_y),
          offsetof(FrameParams, rows),
          offsetof(FrameParams, tile_rays),
          offsetof(FrameParams, row_slots),
          offsetof(FrameParams, slots),
          sizeof(Footprint),
          offsetof(Footprint, columns),
          offsetof(Footprint, others),
          offsetof(Footprint, rows),
          offsetof(Footprint, tile_rows)};
}

Offsets device_offsets(const std::string& layout) {
  const Device device = Device::best();
  Kernel probe(Program::from_text(device, "probe.cl", layout + kProbe), "probe");
  Buffer<std::uint32_t> at(device, "offsets", host_offsets().size());
  at.fill(0xffffffffU);
  probe.run(1, 1, {{"at", at}});
  return at.download();
}

std::string swapped(std::string text, const std::string& a, const std::string& b) {
  const auto exchange = [&text](const std::string& from, const std::string& to) {
    const std::size_t place = text.find(from);
    if (place == std::string::npos) throw std::runtime_error("layout.h has no " + from);
    text.replace(place, from.size(), to);
  };
  exchange(a, "@");
  exchange(b, a);
  exchange("@", b);
  return text;
}

TEST(Layout, DeviceAndHostAgree) {
  EXPECT_EQ(device_offsets(load_source("shared/layout.h")), host_offsets());
}

TEST(Layout, TheProbeSeesSwappedFields) {
  const std::string layout = load_source("shared/layout.h");
  EXPECT_NE(device_offsets(swapped(layout, "sim_u32 stride;", "sim_u32 tiles_x;")), host_offsets());
  EXPECT_NE(device_offsets(swapped(layout, "sim_u32 columns;", "sim_u32 others;")), host_offsets());
}

}  // namespace
}  // namespace simuli
