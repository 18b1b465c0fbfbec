// Launcher of "kernels/environment.cl" and "kernels/environment_bwd.cl".
#include <bit>

#include "host/base/error.hpp"
#include "host/render/frame/picture_stages.hpp"
#include "host/render/options/lane_shape.hpp"
#include "host/render/options/validate.hpp"

namespace simuli {
namespace {

constexpr std::size_t kLocalSize = 32;

Program environment_program(const Device& device, const char* path, Precision precision, int lanes) {
  return {device, path, BuildOptions().real(precision).define("V", lanes)};
}

std::size_t vectors_of(const shared::FrameParams& frame, int lanes) {
  return round_up(frame.slots / static_cast<std::size_t>(lanes), kLocalSize);
}

}  // namespace

EnvironmentBuffers::EnvironmentBuffers(const Device& device, const EnvironmentMap& map, Precision precision)
    : width(static_cast<std::uint32_t>(map.width)),
      height(static_cast<std::uint32_t>(map.height)),
      texture(device, "environment", precision) {
  const std::size_t texels = std::size_t{width} * height;
  if (width < 2 || height < 2 || map.texels.size() != 3 * texels) {
    throw Error(ErrorKind::kInternal, "environment: 2 x 2 texels of 3 values at least are needed");
  }
  need_numbers(map.texels, kLargestColor, "environment map");
  std::vector<float> padded(4 * texels, 0.0F);
  for (std::size_t i = 0; i < texels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) padded[4 * i + c] = map.texels[3 * i + c];
  }
  texture.assign(padded);
}

EnvironmentMap EnvironmentBuffers::download() const {
  EnvironmentMap map{static_cast<int>(width), static_cast<int>(height), {}};
  const std::vector<float> padded = texture.download_float();
  map.texels.reserve(padded.size() / 4 * 3);
  for (std::size_t i = 0; i < padded.size(); ++i) {
    if (i % 4 < 3) map.texels.push_back(padded[i]);
  }
  return map;
}

EnvironmentStage::EnvironmentStage(const Device& device, Precision precision, int lanes)
    : device_(device),
      lanes_(lanes == 0 ? lane_shape_of(device, precision).lanes : lanes),
      cell_(device, "environment cells"),
      slot_(device, "environment slots"),
      cell_scratch_(device, "environment cells, sorting"),
      slot_scratch_(device, "environment slots, sorting"),
      first_(device, "environment ranges"),
      fraction_(device, "environment fractions", precision),
      forward_(environment_program(device, "kernels/environment.cl", precision, lanes_), "environment"),
      cells_(environment_program(device, "kernels/environment_bwd.cl", precision, lanes_),
             "environment_cells"),
      ranges_(Program(device, "kernels/bin.cl"), "tile_ranges"),
      gather_(environment_program(device, "kernels/environment_bwd.cl", precision, lanes_),
              "environment_gather") {}

void EnvironmentStage::run(const shared::FrameParams& frame,
                           const EnvironmentBuffers& environment,
                           FrameBuffers& b) {
  forward_.launch(vectors_of(frame, lanes_),
                  kLocalSize,
                  frame,
                  environment.width,
                  environment.height,
                  b.sensor,
                  b.world_ray,
                  environment.texture,
                  b.out);
}

void EnvironmentStage::run_backward(const shared::FrameParams& frame,
                                    const EnvironmentBuffers& environment,
                                    double tv_scale,
                                    const FrameBuffers& b,
                                    SortStage& sort,
                                    ScanStage& scan,
                                    RealBuffer& grads) {
  const std::uint32_t cells = environment.width * environment.height + 1;  // the last: sees none of it
  cell_.reserve(frame.slots);
  slot_.reserve(frame.slots);
  fraction_.reserve(std::size_t{2} * frame.slots);
  first_.reserve(std::size_t{cells} + 1);
  grads.reserve(environment.texture.count());
  cells_.launch(vectors_of(frame, lanes_),
                kLocalSize,
                frame,
                environment.width,
                environment.height,
                b.sensor,
                b.world_ray,
                b.out,
                cell_,
                slot_,
                fraction_);
  sort.run(cell_, slot_, cell_scratch_, slot_scratch_, frame.slots, std::bit_width(cells - 1), scan);
  const Chunks chunks = chunks_of(device_, frame.slots);
  ranges_.launch(chunks.work_items, 1, cell_, frame.slots, chunks.chunk, cells, first_);
  gather_.launch(round_up(std::size_t{cells} - 1, kLocalSize),
                 kLocalSize,
                 frame,
                 environment.width,
                 environment.height,
                 tv_scale,
                 first_,
                 slot_,
                 fraction_,
                 b.out,
                 b.grad_out,
                 environment.texture,
                 grads);
}

}  // namespace simuli
