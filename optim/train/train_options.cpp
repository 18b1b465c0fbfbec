#include <algorithm>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "host/core/base/error.hpp"
#include "host/core/base/fields.hpp"
#include "host/device/render/options/quality.hpp"
#include "host/device/render/options/validate.hpp"
#include "optim/train/training_options.hpp"

namespace simuli {

TrainOptions checked(const TrainOptions& o) {
  check_fields(o);
  validate(o.render);
  return o;
}

TrainingOptions checked(const TrainingOptions& options) {
  check_fields(options.frames);
  check_fields(options.init);
  static_cast<void>(checked(options.train));
  if (options.train.shards.count > 1 && !options.fixer_command.empty()) {
    throw Error(ErrorKind::kUsage,
                "shards: found " + std::to_string(options.train.shards.count) +
                    " with a fixer, allowed 1: repaired pictures belong to no shard");
  }
  return options;
}

int iterations_a_sweep(const TrainingOptions& options, const Log& log) {
  std::set<std::string_view> lidars;
  for (const std::size_t sweep : HeldOutRule(log, options.frames).training(log.sweeps)) {
    lidars.insert(log.sweeps[sweep].lidar);
  }
  const int turns = std::max(1, static_cast<int>(lidars.size()));
  return (options.train.lidar_every - 1) / turns + 1;
}

TrainingOptions training_options(const std::string& quality, const std::vector<std::string>& settings) {
  TrainingOptions options;
  options.train.render = training_options_of(quality_of_name(quality));
  fields_of(options).apply(settings, "settings");
  return checked(options);
}

std::string quality_of(const RenderOptions& options) {
  const std::vector<std::string> lines = lines_of(options);
  for (const Quality quality : {Quality::kBalanced, Quality::kDraft, Quality::kExact, Quality::kReference}) {
    if (lines_of(training_options_of(quality)) == lines) {
      return quality_names()[static_cast<std::size_t>(quality)];
    }
  }
  return "custom";
}

}  // namespace simuli
