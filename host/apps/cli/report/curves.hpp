#pragma once
// Errors by frame and by range, as curves.
#include "host/apps/cli/draw/html_report.hpp"
#include "optim/eval/evaluation.hpp"

namespace simuli::cli {

/// Adds errors along the drive, one curve per sensor, and errors by range to a report.
void add_curves(HtmlReport& html, const EvalReport& report);

}  // namespace simuli::cli
