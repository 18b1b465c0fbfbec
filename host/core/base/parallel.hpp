#pragma once
#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

#include "host/core/base/interruption.hpp"

namespace simuli {

/// Runs f(begin, end) over parts of [0, count) on all cores, dynamically scheduled, for work in which each
/// index is independent, so that the division does not affect results. Parts smaller than `smallest` are not
/// worth a thread. Rethrows exceptions of f and of Interruption::ask().
template <class F>
void parallel_ranges(std::size_t count, const F& f, std::size_t smallest = 4096) {
  const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
  const std::size_t parts = std::clamp<std::size_t>(count / smallest, 1, cores);
  constexpr std::size_t kPieces = 8;  // pieces per thread, for balance
  const std::size_t piece = std::clamp<std::size_t>(count / (kPieces * parts), smallest, 16 * smallest);
  std::atomic<std::size_t> next{0};
  std::vector<std::exception_ptr> thrown(parts);
  const auto run = [&](std::size_t i) {
    try {
      for (std::size_t begin = 0; (begin = next.fetch_add(piece)) < count;) {
        if (i == 0) Interruption::ask();  // the caller's thread
        f(begin, std::min(begin + piece, count));
      }
    } catch (...) {
      thrown[i] = std::current_exception();
      next = count;  // stops further pieces
    }
  };
  {
    std::vector<std::jthread> threads;
    threads.reserve(parts - 1);
    for (std::size_t i = 1; i < parts; ++i) {
      const auto part = [&run, i] { run(i); };
      try {
        threads.emplace_back(part);
      } catch (const std::system_error&) {  // no memory for another thread's stack
        part();
      }
    }
    run(0);
  }
  for (const std::exception_ptr& e : thrown) {
    if (e) std::rethrow_exception(e);
  }
}

/// Runs f(index) for each index.
template <class F>
void parallel_each(std::size_t count, const F& f, std::size_t smallest = 4096) {
  const auto range = [&f](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) f(i);
  };
  parallel_ranges(count, range, smallest);
}

}  // namespace simuli
