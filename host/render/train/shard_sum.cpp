// Launcher of "kernels/train/shard_sum.cl".
#include "host/render/train/shard_sum.hpp"

#include <fmt/format.h>

#include "host/base/error.hpp"

namespace simuli {
namespace {

constexpr std::uint32_t kCulled = 0xffffffffU;

Program program(const Device& device, Precision precision) {
  BuildOptions options;
  return {device, "kernels/train/shard_sum.cl", options.real(precision)};
}

void need_count(const char* what, std::size_t found, std::size_t allowed) {
  if (found == allowed) return;
  throw Error(ErrorKind::kInternal, fmt::format("{}: found {} numbers, allowed {}", what, found, allowed));
}

}  // namespace

ShardSum::ShardSum(const Device& device, Precision precision)
    : buffers_(device, precision),
      pack_(program(device, precision), "pack_columns"),
      add_(program(device, precision), "add_columns"),
      mark_(program(device, precision), "mark_columns") {}

void ShardSum::start(const ParticleBuffers& particles) {
  particles_ = particles.count;
  stride_ = particles.stride;
  rows_ = particles.params.count() / stride_;
  columns_ = 0;
  buffers_.sums.reserve(rows_ * stride_);
  buffers_.keys.reserve(particles_);
  buffers_.sums.fill(0.0);
  buffers_.keys.fill(kCulled);
}

std::vector<std::uint32_t> ShardSum::columns_of(const Buffer<std::uint32_t>& keys) {
  const std::vector<std::uint32_t> all = keys.download();
  std::vector<std::uint32_t> columns;
  columns.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i] != kCulled) columns.push_back(static_cast<std::uint32_t>(i));
  }
  return columns;
}

void ShardSum::set_columns(std::span<const std::uint32_t> columns) {
  if (!columns.empty() && columns.back() >= particles_) {
    throw Error(ErrorKind::kInternal,
                fmt::format("shard: found particle {}, allowed less than {}", columns.back(), particles_));
  }
  columns_ = columns.size();
  buffers_.order.assign(columns);
  const auto count = static_cast<std::uint32_t>(columns_);
  mark_.run_over(columns_, {{"count", count}, {"order", buffers_.order}, {"keys", buffers_.keys}});
}

std::vector<float> ShardSum::pack(const RealBuffer& matrix, std::size_t rows) {
  buffers_.packed.reserve(rows * columns_);
  pack_.run_over(columns_,
                 {{"count", static_cast<std::uint32_t>(columns_)},
                  {"rows", static_cast<std::uint32_t>(rows)},
                  {"stride", static_cast<std::uint32_t>(matrix.count() / rows)},
                  {"order", buffers_.order},
                  {"from", matrix},
                  {"packed", buffers_.packed}});
  return buffers_.packed.download_float();
}

void ShardSum::add(const RealBuffer& grads, double share) {
  need_count("gradients of a shard", grads.count(), rows_ * stride_);
  add({rows_, stride_}, columns_, grads, share, buffers_.sums);
}

void ShardSum::add_packed(std::span<const float> grads, double share) {
  need_count("packed gradients of a shard", grads.size(), rows_ * columns_);
  buffers_.packed.assign(grads);
  add({.rows = rows_, .stride = stride_, .packed = true}, columns_, buffers_.packed, share, buffers_.sums);
}

void ShardSum::add_errors(const RealBuffer& errors, RealBuffer& sum) {
  need_count("errors of a shard", errors.count(), sum.count());
  add({1, sum.count()}, columns_, errors, 1.0, sum);
}

void ShardSum::add_packed_errors(std::span<const float> errors, RealBuffer& sum) {
  need_count("packed errors of a shard", errors.size(), columns_);
  buffers_.packed.assign(errors);
  add({.rows = 1, .stride = sum.count(), .packed = true}, columns_, buffers_.packed, 1.0, sum);
}

void ShardSum::add_all(std::span<const float> from, double share, RealBuffer& sum) {
  need_count("numbers of a shard", from.size(), sum.count());
  buffers_.packed.assign(from);
  add({.rows = 1, .stride = sum.count(), .listed = false}, sum.count(), buffers_.packed, share, sum);
}

RealBuffer& ShardSum::fresh_errors() {
  buffers_.errors.reserve(particles_);
  buffers_.errors.fill(0.0);
  return buffers_.errors;
}

void ShardSum::add(
    const Matrix& matrix, std::size_t count, const RealBuffer& from, double share, RealBuffer& sum) {
  add_.run_over(count,
                {{"count", static_cast<std::uint32_t>(count)},
                 {"rows", static_cast<std::uint32_t>(matrix.rows)},
                 {"stride", static_cast<std::uint32_t>(matrix.stride)},
                 {"listed", matrix.listed ? 1U : 0U},
                 {"packed", matrix.packed ? 1U : 0U},
                 {"share", share},
                 {"order", buffers_.order},
                 {"from", from},
                 {"sum", sum}});
}

}  // namespace simuli
