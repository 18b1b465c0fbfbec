#pragma once
#include <algorithm>
#include <cstddef>
#include <system_error>
#include <thread>
#include <vector>

#include "host/core/base/interruption.hpp"

namespace simuli {

/// Runs f(begin, end) over [0, count) in equal parts on all cores. For work in which each index is handled
/// alone, so that the split does not show in the result. f must not throw. A part smaller than `smallest` is
/// not worth a thread. Throws what Interruption::ask() does, before any.
template <class F>
void parallel_ranges(std::size_t count, const F& f, std::size_t smallest = 4096) {
  Interruption::ask();
  const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
  const std::size_t parts = std::clamp<std::size_t>(count / smallest, 1, cores);
  std::vector<std::jthread> threads;
  threads.reserve(parts - 1);
  for (std::size_t i = 1; i < parts; ++i) {
    const auto part = [&f, i, parts, count] { f(count * i / parts, count * (i + 1) / parts); };
    try {
      threads.emplace_back(part);
    } catch (const std::system_error&) {  // no memory for another thread's stack
      part();
    }
  }
  f(0, count / parts);
}

}  // namespace simuli
