// Tests each key with each class of values in the functions that read settings of frames, trainings and
// evaluations. Programs, Python and C only call these functions.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <gtest/gtest.h>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/device/render/frame/variant.hpp"
#include "host/device/render/options/quality.hpp"
#include "optim/eval/eval_options.hpp"
#include "optim/train/training_options.hpp"

namespace simuli {
namespace doors_test {

struct Door {
  const char* name;
  std::vector<Field> fields;  // listed fields
  std::function<void(const std::vector<std::string>&)> open;
};

/// Fields of options with static lifetime.
template <class Options>
std::vector<Field> listed() {
  static Options options;
  return fields_of(options).all();
}

const std::vector<Door>& doors() {
  static const std::vector<Door> all{
      {"frames", listed<RenderOptions>(), [](const auto& s) { (void)render_options("", s); }},
      {"trainings", listed<TrainingOptions>(), [](const auto& s) { (void)training_options("", s); }},
      {"evaluations", listed<EvalOptions>(), [](const auto& s) { (void)eval_options("", s); }}};
  return all;
}

bool is_whole(const Field& field) {
  return std::holds_alternative<int*>(field.value) || std::holds_alternative<std::size_t*>(field.value);
}
bool is_number(const Field& field) { return is_whole(field) || std::holds_alternative<double*>(field.value); }

std::string text_of(const Field& field, double value) {
  return is_whole(field) ? fmt::format("{}", static_cast<std::int64_t>(value)) : fmt::format("{}", value);
}

bool is_list(const Field& field) { return std::holds_alternative<std::vector<std::string>*>(field.value); }

/// Returns the minimum and maximum value of the key, and all names of an enum.
std::vector<std::string> allowed(const Field& field) {
  if (is_list(field)) return {"", "front", "front,left"};
  if (!is_number(field)) return field.names.empty() ? std::vector<std::string>{"true", "false"} : field.names;
  std::vector<std::string> values;
  for (const double bound : {field.range.least, field.range.most, field.range.also})
    if (field.range.holds(bound)) values.push_back(text_of(field, bound));
  return values;
}

std::vector<std::string> refused(const Field& field) {
  if (is_list(field)) return {",", ",front", "front,", "front,,left"};
  std::vector<std::string> values{"", "nothing", "nan", "1e999", "1 "};
  if (!is_number(field)) return values;
  if (is_whole(field)) values.emplace_back("1.5");
  if (field.range.above) values.push_back(text_of(field, field.range.least));
  for (const double beyond : {field.range.least - 2.0, field.range.most + 2.0})
    if (std::isfinite(beyond) && !field.range.holds(beyond)) values.push_back(text_of(field, beyond));
  return values;
}

/// Returns the error message for the settings; empty: accepted.
std::string answer(const Door& door, const std::vector<std::string>& settings) {
  try {
    door.open(settings);
    return {};
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kUsage) << error.what();
    return error.what();
  }
}

void expect_refused(const std::string& answer, const std::string& key) {
  EXPECT_NE(answer.find(key + ": found "), std::string::npos) << key << ": " << answer;
  EXPECT_NE(answer.find(", allowed "), std::string::npos) << answer;
  EXPECT_EQ(answer.find('\n'), std::string::npos) << answer;
}

TEST(Doors, TakeWhatAKeyAllowsAndRefuseTheRestByItsName) {
  for (const Door& door : doors()) {
    SCOPED_TRACE(door.name);
    EXPECT_GT(door.fields.size(), 10U);
    for (const Field& field : door.fields) {
      const auto answer_to = [&](const std::string& value) {
        return answer(door, {field.key + '=' + value});
      };
      EXPECT_FALSE(allowed(field).empty()) << field.key;
      EXPECT_FALSE(refused(field).empty()) << field.key;
      EXPECT_EQ(answer_to(field.text()), "") << field.key;
      // Another key may have a stricter limit.
      for (const std::string& value : allowed(field)) {
        const std::string said = answer_to(value);
        if (!said.empty()) expect_refused(said, field.key);
      }
      for (const std::string& value : refused(field)) expect_refused(answer_to(value), field.key);
    }
  }
}

TEST(Doors, OfFramesTakeEveryValueOfEveryKey) {
  for (const Field& field : doors()[0].fields) {
    for (const std::string& value : allowed(field))
      EXPECT_EQ(answer(doors()[0], {field.key + '=' + value, "render.extent=unscented"}).substr(0, 18),
                field.key == "render.extent" ? "settings: found re" : "")
          << field.key;
  }
}

TEST(Doors, OfTrainingsRefuseByNameWhatHasNoGradients) {
  const Door& frames = doors()[0];
  const Door& trainings = doors()[1];
  std::vector<std::string> fixed;
  for (const Field& field : frames.fields) {
    const bool is_listed = std::any_of(
        trainings.fields.begin(), trainings.fields.end(), [&](const Field& f) { return f.key == field.key; });
    EXPECT_EQ(is_listed, field.in_training == InTraining::kAny) << field.key;
    if (is_listed) continue;
    fixed.push_back(field.key);
    EXPECT_EQ(answer(trainings, {field.key + '=' + field.text()}), "");
    for (const std::string& value : allowed(field)) {
      if (value != field.text()) expect_refused(answer(trainings, {field.key + '=' + value}), field.key);
    }
    for (const std::string& value : refused(field))
      expect_refused(answer(trainings, {field.key + '=' + value}), field.key);
  }
  EXPECT_EQ(std::count(fixed.begin(), fixed.end(), "render.detail"), 1);
  TrainOptions options;
  options.render.detail = 0.5;
  try {
    (void)checked(options);
    ADD_FAILURE() << "was taken";
  } catch (const Error& error) {
    expect_refused(error.what(), "render.detail");
  }
}

/// The options struct of a key determines the device data that the key changes.
TEST(RenderOptionParts, AloneChangeWhatDependsOnThem) {
  const auto compiled = [](const RenderOptions& options) {
    std::string text;
    for (const SensorType sensor : {SensorType::kCamera, SensorType::kLidar})
      text += Variant{{.sensor = sensor, .sh_degree = 3}, options}.build_options().text();
    return text;
  };
  const RenderOptions usual;
  for (const Field& listed : doors()[0].fields) {
    RenderOptions options;
    const Fields fields = fields_of(options);
    std::vector<std::string> others = allowed(listed);
    others.emplace_back("0.25");  // numbers without limits
    for (const std::string& other : others)
      if (listed.text() == fields.find(listed.key)->text()) (void)fields.find(listed.key)->set(other);
    const auto is_same = [&]<class Part>(const Part& part) {
      return part == static_cast<const Part&>(usual);
    };
    const bool uploads = is_same.operator()<UploadOptions>(options),
               rays = is_same.operator()<RayOptions>(options),
               programs = is_same.operator()<ProgramOptions>(options),
               frames = is_same.operator()<FrameOptions>(options),
               precision = options.precision == usual.precision;
    EXPECT_EQ(uploads + rays + programs + frames + precision, 4) << listed.key;
    // Two keys change the kind of frame: levels of detail, and the median of a LiDAR frame.
    if (listed.key == "render.detail" || listed.key == "render.median_distance") continue;
    EXPECT_EQ(compiled(options) == compiled(usual), programs && precision) << listed.key;
  }
}

}  // namespace doors_test
}  // namespace simuli
