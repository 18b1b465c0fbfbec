#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "io/base/file.hpp"
#include "io/splat/splat_file.hpp"
#include "tests/io/scratch.hpp"
#include "tests/io/splat/some_set.hpp"

namespace simuli {
namespace {

using test::expect_input_error;
using test::Scratch;

GaussianSet two_particles() {
  GaussianSet set(SetKind::kCamera, 0, 2);
  set.mean() << 1.0F, 2.0F, 3.0F, -4.0F, 0.5F, 0.25F;
  set.rotation() << 1.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 0.0F, 2.0F;
  set.log_scale().row(1) << 0.0F, 0.0F, std::log(2.0F);
  set.opacity_logit() << 0.0F, 100.0F;
  set.sh(0) << 0.5F, -0.5F, 0.0F, 1.0F, 2.0F, 3.0F;
  return set;
}

TEST(Usda, IsTheTextOfTheSchema) {
  EXPECT_EQ(usda_of(two_particles(), SplatAxes::kZUp, "a.usda"), R"(#usda 1.0
(
    defaultPrim = "Splats"
    metersPerUnit = 1
    upAxis = "Z"
)

def ParticleField3DGaussianSplat "Splats" (
    prepend apiSchemas = ["ColorSpaceAPI"]
)
{
    uniform token colorSpace:name = "srgb_rec709_scene"
    uniform token projectionModeHint = "perspective"
    uniform token sortingModeHint = "cameraDistance"
    uniform int radiance:sphericalHarmonicsDegree = 0
    float3[] extent = [(-10, -5.5, -5.75), (4, 6.5, 6.25)]
    point3f[] positions = [(1, 2, 3), (-4, 0.5, 0.25)]
    quatf[] orientations = [(1, 0, 0, 0), (0, 0, 0, 1)]
    float3[] scales = [(1, 1, 1), (1, 1, 2)]
    float[] opacities = [0.5, 1]
    float3[] radiance:sphericalHarmonicsCoefficients = [(0.5, -0.5, 0), (1, 2, 3)] (
        elementSize = 1
        interpolation = "vertex"
    )
}
)");
}

TEST(Usda, TurnsWhatHasNoZUp) {
  const std::string text = usda_of(two_particles(), SplatAxes::kYDown, "a.usda");
  EXPECT_NE(text.find("upAxis = \"Y\""), std::string::npos);
  EXPECT_NE(text.find("positions = [(1, -2, -3), (-4, -0.5, -0.25)]"), std::string::npos) << text;
}

TEST(Usdz, HoldsTheLayerAsItIs) {
  const Scratch scratch;
  const GaussianSet set = test::some_set(3, 20);
  write_splats(scratch / "a.usdz", set, {SplatAxes::kZUp});
  const std::string zip = read_file(scratch / "a.usdz"), text = usda_of(set, SplatAxes::kZUp, "a.usdz");
  EXPECT_EQ(zip.substr(0, 4), "PK\x03\x04");
  EXPECT_EQ(zip.substr(8, 2), std::string("\0\0", 2));  // stored
  EXPECT_EQ(zip.substr(30, 11), "splats.usda");
  const std::size_t at = zip.find("#usda");
  EXPECT_EQ(at % 64, 0U);
  EXPECT_EQ(zip.substr(at, text.size()), text);
  expect_input_error([&] { write_splats(scratch / "l.usda", GaussianSet(SetKind::kLidar, 0, 0)); },
                     {"l.usda", "kind"});
  EXPECT_FALSE(std::filesystem::exists(scratch / "l.usda"));
}

}  // namespace
}  // namespace simuli
