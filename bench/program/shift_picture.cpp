#include "bench/program/shift_picture.hpp"

#include "host/cli/draw/pictures.hpp"

namespace simuli::bench {

Image shift_picture(const std::vector<ShiftResult::Pair>& pairs) {
  Image all;
  for (const ShiftResult::Pair& pair : pairs) {
    const Image row = cli::joined(pair.rendered, pair.truth, cli::Layout::kBeside);
    all = all.height == 0 ? row : cli::joined(all, row, cli::Layout::kBelow);
  }
  return all;
}

}  // namespace simuli::bench
