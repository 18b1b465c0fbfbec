#pragma once
// Errors frame by frame and by range, as curves.
#include "host/apps/cli/draw/html_report.hpp"
#include "optim/eval/evaluation.hpp"

namespace simuli::cli {

/// Parts of a report: errors over the drive, a curve for each sensor, and errors by range.
void add_curves(HtmlReport& html, const EvalReport& report);

}  // namespace simuli::cli
