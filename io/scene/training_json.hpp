#pragma once
#include "io/base/json_reader.hpp"
#include "io/scene/training_record.hpp"

namespace simuli {

/// Non-finite values become null.
[[nodiscard]] Json to_json(const HeldOutScores& scores);
[[nodiscard]] Json to_json(const TrainingRecord& record);
/// Errors as in io/base/json_reader.hpp.
[[nodiscard]] TrainingRecord training_from_json(JsonObject& object);

}  // namespace simuli
