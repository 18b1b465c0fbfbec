#pragma once
// Support compared with the errors of an evaluation's frames.
#include <nlohmann/json_fwd.hpp>
#include <set>
#include <string>

#include "optim/complete/support_reliability.hpp"
#include "optim/eval/evaluation.hpp"

namespace simuli::cli {

struct EvalSupport {
  SupportReliability pixels, rays;
  std::set<std::string> unseen;  // cameras without training pictures; reported without their tints
};
/// Evaluates every kEvalSupportStep-th pixel and ray of the compared frames. Throws Error{kUsage} for a scene
/// without a record of its training frames.
[[nodiscard]] EvalSupport eval_support(const Evaluation& evaluation);
inline constexpr std::size_t kEvalSupportStep = 7;

/// {"pixels": {"count", "mean", "right", "rank_correlation", "calibration_error", "curve": [{"share",
/// "support", "right"}, ...]}, "rays": ..., "without_tint": names of cameras}
[[nodiscard]] nlohmann::ordered_json json_of(const EvalSupport& support);
/// Returns two lines and a table of both curves.
[[nodiscard]] std::string text_of(const EvalSupport& support);

}  // namespace simuli::cli
