// Tests that shared structs have the same layout on the device as on the host: a probe kernel reports sizes
// and offsets.
#include "cl/shared/layout.h"

#include <cstddef>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "cl/shared/sensor_constants.h"
#include "host/device/runtime/kernel.hpp"
#include "host/device/runtime/source.hpp"
#include "tests/support/device.hpp"

namespace simuli {
namespace layout_test {

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

// Every field of the structs of reals, and the number of reals of each struct.
#define SIMULI_FIELDS(FIELD)                \
  FIELD(LensConstants, cos_min)             \
  FIELD(LensConstants, angle_max)           \
  FIELD(LensConstants, radius2_max)         \
  FIELD(LensConstants, radius_max)          \
  FIELD(LensConstants, distortion)          \
  FIELD(LensConstants, polynomial)          \
  FIELD(LensConstants, linear)              \
  FIELD(LensConstants, xi)                  \
  FIELD(LensConstants, alpha)               \
  FIELD(LensConstants, beta)                \
  FIELD(ModelConstants, kappa)              \
  FIELD(ModelConstants, t_min)              \
  FIELD(ModelConstants, t_max)              \
  FIELD(ModelConstants, period)             \
  FIELD(ModelConstants, time_step)          \
  FIELD(ModelConstants, height)             \
  FIELD(ModelConstants, lever)              \
  FIELD(ModelConstants, fx)                 \
  FIELD(ModelConstants, fy)                 \
  FIELD(ModelConstants, cx)                 \
  FIELD(ModelConstants, cy)                 \
  FIELD(ModelConstants, picture_width)      \
  FIELD(ModelConstants, picture_height)     \
  FIELD(ModelConstants, first_column)       \
  FIELD(ModelConstants, last_column)        \
  FIELD(ModelConstants, first_row)          \
  FIELD(ModelConstants, last_row)           \
  FIELD(ModelConstants, time_x)             \
  FIELD(ModelConstants, time_y)             \
  FIELD(ModelConstants, time_c)             \
  FIELD(ModelConstants, lens_cone)          \
  FIELD(ModelConstants, lens_slope)         \
  FIELD(ModelConstants, lens_bend)          \
  FIELD(ModelConstants, lens)               \
  FIELD(ModelConstants, azimuth_cut)        \
  FIELD(ModelConstants, spin)               \
  FIELD(ModelConstants, inv_span)           \
  FIELD(ModelConstants, time_first)         \
  FIELD(ModelConstants, time_spread)        \
  FIELD(ModelConstants, row_spread)         \
  FIELD(ModelConstants, lut_first)          \
  FIELD(ModelConstants, lut_scale)          \
  FIELD(ModelConstants, tile_first)         \
  FIELD(ModelConstants, tile_last)          \
  FIELD(ModelConstants, tile_scale)         \
  FIELD(ModelConstants, tile_bins)          \
  FIELD(ModelConstants, mask_scale)         \
  FIELD(ModelConstants, mask_columns)       \
  FIELD(SensorConstants, centre_ref)        \
  FIELD(SensorConstants, centre_step)       \
  FIELD(SensorConstants, rotation_start)    \
  FIELD(SensorConstants, rotation_ref)      \
  FIELD(SensorConstants, turn_axis)         \
  FIELD(SensorConstants, turn_angle)        \
  FIELD(SensorConstants, cos_view)          \
  FIELD(SensorConstants, sin_view)          \
  FIELD(SensorConstants, alpha_cut)         \
  FIELD(SensorConstants, transmittance_cut) \
  FIELD(SensorConstants, background)        \
  FIELD(SensorConstants, model)             \
  FIELD(ActorConstants, centre)             \
  FIELD(ActorConstants, step)               \
  FIELD(ActorConstants, rotation)           \
  FIELD(ActorConstants, turn_axis)          \
  FIELD(ActorConstants, turn_angle)         \
  FIELD(ActorConstants, there)

struct RealField {
  const char* record;
  const char* field;
  std::size_t offset;  // reals
};
std::vector<RealField> real_fields() {
#define SIMULI_FIELD(record, field) \
  {#record, #field, offsetof(shared::record<double>, field) / sizeof(double)},
  return {SIMULI_FIELDS(SIMULI_FIELD)};
#undef SIMULI_FIELD
}

Offsets host_reals() {
  Offsets offsets{shared::kReals<shared::LensConstants>,
                  shared::kReals<shared::ModelConstants>,
                  shared::kReals<shared::SensorConstants>,
                  shared::kReals<shared::ActorConstants>};
  for (const RealField& f : real_fields()) offsets.push_back(static_cast<std::uint32_t>(f.offset));
  return offsets;
}

/// Returns the offsets on the device for a precision.
Offsets device_reals(const std::string& constants, Precision precision) {
  std::string body, structs;
  std::size_t at = 0;
  for (const char* record : {"LensConstants", "ModelConstants", "SensorConstants", "ActorConstants"}) {
    structs += fmt::format("  {0} of_{0};\n", record);
    body += fmt::format("  at[{}] = sizeof({}) / sizeof(real);\n", at++, record);
  }
  for (const RealField& f : real_fields()) {
    body += fmt::format(
        "  at[{0}] = (uint)((__private char*)&of_{1}.{2} - (__private char*)&of_{1}) / sizeof(real);\n",
        at++,
        f.record,
        f.field);
  }
  const std::string text = "#include \"math/lanes.h\"\n" + constants +
                           "\n__kernel void probe(__global uint* at) {\n" + structs + body + "}\n";
  const Device& device = test::device();
  BuildOptions options;
  Kernel probe(Program::from_text(device, "reals.cl", text, options.real(precision)), "probe");
  Buffer<std::uint32_t> offsets(device, "offsets", at);
  offsets.fill(0xffffffffU);
  probe.run(1, 1, {{"at", offsets}});
  return offsets.download();
}

Offsets device_offsets(const std::string& layout) {
  const Device& device = test::device();
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

/// Returns the structs of reals as source text in the root folder.
std::string constants_of_sensors() {
  std::string text = load_source("shared/sensor_constants.h");
  const std::string beside = "#include \"reals.h\"";
  return text.replace(text.find(beside), beside.size(), "#include \"shared/reals.h\"");
}

TEST(Layout, DeviceAndHostAgreeOnStructsOfReals) {
  const std::string constants = constants_of_sensors();
  EXPECT_EQ(device_reals(constants, Precision::kFloat), host_reals());
  if (!test::device().info().fp64) return;
  EXPECT_EQ(device_reals(constants, Precision::kDouble), host_reals());
}

TEST(Layout, TheProbeSeesSwappedReals) {
  const std::string constants = constants_of_sensors();
  EXPECT_NE(device_reals(swapped(constants, "real centre_ref[3];", "real turn_angle;"), Precision::kFloat),
            host_reals());
}

TEST(Layout, TheProbeSeesSwappedFields) {
  const std::string layout = load_source("shared/layout.h");
  EXPECT_NE(device_offsets(swapped(layout, "sim_u32 stride;", "sim_u32 tiles_x;")), host_offsets());
  EXPECT_NE(device_offsets(swapped(layout, "sim_u32 columns;", "sim_u32 others;")), host_offsets());
}

}  // namespace layout_test
}  // namespace simuli
