// Tests cameras of each lens to JSON and back, and strict reading.
#include <gtest/gtest.h>
#include <numbers>

#include "cl/shared/sensor_constants.h"
#include "host/core/base/error.hpp"
#include "io/log/log_json.hpp"
#include "tests/host/windshields.hpp"

namespace simuli {
namespace camera_json_test {

LogCamera camera_of(LensKind kind) {
  LogCamera camera;
  Camera& model = camera.model;
  model.name = "front";
  model.width = 640;
  model.height = 320;
  model.fx = kind == LensKind::kEquirectangular ? 640 / (2 * std::numbers::pi) : 301.7;
  model.fy = 299.1;
  model.cx = 322.3;
  model.cy = 158.9;
  model.shutter = ShutterKind::kTopToBottom;
  if (kind == LensKind::kPinhole) return camera;
  std::vector<double> parameters;
  for (const std::string& name : lens_parameter_names(kind)) {
    const bool large =
        name == "a1" || name == "b1" || name == "c" || name == "beta" || name == "max_angle_rad";
    parameters.push_back(large ? 1.1 : 0.01 + 0.001 * static_cast<double>(parameters.size()));
  }
  model.lens = Lens(kind, parameters);
  return camera;
}

LogCamera read(const Json& json) {
  return read_json_text(json.dump(), "log.json", [](JsonObject& object) { return camera_from_json(object); });
}

std::string error_of(const Json& json) {
  try {
    (void)read(json);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kInput);
    return error.what();
  }
  return "nothing was thrown";
}

TEST(CameraJson, EveryLensComesBackBitForBit) {
  for (const std::string& name : lens_names()) {
    const LogCamera camera = camera_of(lens_from_string(name, "f", "model"));
    const Json json = to_json(camera);
    EXPECT_EQ(json["model"], name);
    const LogCamera back = read(json);
    EXPECT_EQ(back.model.lens.kind(), camera.model.lens.kind());
    EXPECT_EQ(back.model.lens.parameters(), camera.model.lens.parameters()) << name;
    EXPECT_EQ(shared::reals_of(back.model.lens.constants()), shared::reals_of(camera.model.lens.constants()))
        << name;
    EXPECT_EQ(back.model.fx, camera.model.fx);
    EXPECT_EQ(to_json(back), json) << name;
  }
}

TEST(CameraJson, WindshieldsComeBackBitForBit) {
  for (const Windshield& glass : {test::glass_before_the_lens(), test::glass_by_its_way_back()}) {
    for (const LensKind kind : {LensKind::kPinhole, LensKind::kOpencvFisheye}) {
      LogCamera camera = camera_of(kind);
      camera.model.lens = camera.model.lens.behind(glass);
      const LogCamera back = read(to_json(camera));
      EXPECT_EQ(back.model, camera.model);
      EXPECT_EQ(shared::reals_of(back.model.lens.constants()),
                shared::reals_of(camera.model.lens.constants()));
    }
  }
  LogCamera camera = camera_of(LensKind::kOpencvFisheye);
  camera.model.lens = camera.model.lens.behind(test::glass_before_the_lens());
  Json json = to_json(camera);
  json["windshield"]["reference"] = "sideways";
  EXPECT_NE(error_of(json).find("windshield.reference: found \"sideways\", allowed forward or backward"),
            std::string::npos)
      << error_of(json);
  json = to_json(camera);
  json["windshield"]["vertical"] = {0.0, 1.0};
  EXPECT_NE(error_of(json).find("windshield.vertical: found 2 coefficients"), std::string::npos)
      << error_of(json);
}

TEST(CameraJson, WithoutAModelItIsAPinhole) {
  Json json = to_json(camera_of(LensKind::kPinhole));
  json.erase("model");
  EXPECT_EQ(read(json).model.lens.kind(), LensKind::kPinhole);
}

TEST(CameraJson, RefusesByName) {
  const Json good = to_json(camera_of(LensKind::kOpencvFisheye));
  Json json = good;
  json["model"] = "fov";
  EXPECT_NE(error_of(json).find("log.json: model: found \"fov\", allowed pinhole, "), std::string::npos);
  json = good;
  json.erase("k3");
  EXPECT_NE(error_of(json).find("k3"), std::string::npos) << error_of(json);
  json = good;
  json["k5"] = 0.0;  // parameter of another model
  EXPECT_NE(error_of(json).find("k5"), std::string::npos) << error_of(json);
  json = good;
  json["max_angle_rad"] = 7.0;
  EXPECT_NE(error_of(json).find("log.json: max_angle_rad: found 7"), std::string::npos) << error_of(json);
}

}  // namespace camera_json_test
}  // namespace simuli
