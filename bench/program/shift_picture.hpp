#pragma once
// What `simuli bench --shift` draws.
#include <vector>

#include "bench/paper/shift.hpp"
#include "io/picture/image.hpp"

namespace simuli::bench {

/// A row for each pair: as rendered, the truth beside it. Pictures of one size; at least one.
[[nodiscard]] Image shift_picture(const std::vector<ShiftResult::Pair>& pairs);

}  // namespace simuli::bench
