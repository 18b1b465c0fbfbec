#include "bench/peers/embree_tracer.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <string>
#include <thread>
#if defined(__SSE3__)
#include <pmmintrin.h>
#endif

#include "bench/peers/embree_state.hpp"
#include "host/core/base/error.hpp"

namespace simuli::bench {

using namespace embree;

namespace embree {

void in_parallel(std::size_t count,
                 std::size_t part,
                 int threads,
                 const std::function<void(std::size_t, std::size_t)>& f) {
  std::atomic<std::size_t> next{0};
  const auto work = [&] {
#if defined(__SSE3__)
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);  // recommended by Embree
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
#endif
    for (std::size_t first = next.fetch_add(part); first < count; first = next.fetch_add(part)) {
      f(first, std::min(first + part, count));
    }
  };
  std::vector<std::jthread> others;
  for (int i = 0; i < threads; ++i) others.emplace_back(work);
}

Constants in_float(const shared::SensorConstants<double>& constants) {
  const auto reals = shared::reals_of(constants);
  std::array<float, reals.size()> rounded{};
  for (std::size_t i = 0; i < reals.size(); ++i) rounded[i] = static_cast<float>(reals[i]);
  return std::bit_cast<Constants>(rounded);
}

}  // namespace embree

namespace {

constexpr std::size_t kBlocksAtOnce = 64;
constexpr float kBoxMargin = 1e-4F;  // relative margin for rounding of a box

/// Evaluates spherical harmonics in a unit direction, with the signs of the 3DGS file format.
void sh_basis(int degree, F x, F y, F z, F* basis) {
  basis[0] = 0.28209479177387814F;
  if (degree < 1) return;
  basis[1] = -0.4886025119029199F * y;
  basis[2] = 0.4886025119029199F * z;
  basis[3] = -0.4886025119029199F * x;
  if (degree < 2) return;
  const F xx = x * x, yy = y * y, zz = z * z;
  basis[4] = 1.0925484305920792F * x * y;
  basis[5] = -1.0925484305920792F * y * z;
  basis[6] = 0.31539156525252005F * (2.0F * zz - xx - yy);
  basis[7] = -1.0925484305920792F * x * z;
  basis[8] = 0.5462742152960396F * (xx - yy);
  if (degree < 3) return;
  basis[9] = -0.5900435899266435F * y * (3.0F * xx - yy);
  basis[10] = 2.890611442640554F * x * y * z;
  basis[11] = -0.4570457994644658F * y * (4.0F * zz - xx - yy);
  basis[12] = 0.3731763325901154F * z * (2.0F * zz - 3.0F * xx - 3.0F * yy);
  basis[13] = -0.4570457994644658F * x * (4.0F * zz - xx - yy);
  basis[14] = 1.445305721320277F * z * (xx - yy);
  basis[15] = -0.5900435899266435F * x * (xx - 3.0F * yy);
}

[[noreturn]] void throw_embree(RTCError error) {
  throw Error(ErrorKind::kDevice,
              "Embree: found error " + std::to_string(static_cast<int>(error)) + ", allowed none");
}

}  // namespace

EmbreeTracer::EmbreeTracer(const TracedSet& set, int threads) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.threads = threads > 0 ? threads : static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  s.sh_degree = set.sh_degree;
  s.clamped_channels = set.clamped_channels;
  s.count = set.count;
  s.padded = (s.count + W - 1) / W * W;
  const std::size_t rows = set.values.size() / std::max<std::size_t>(s.count, 1);
  s.values.assign(rows * s.padded, 0.0F);
  for (std::size_t r = 0; r < rows; ++r) {
    std::copy_n(set.values.data() + r * s.count, s.count, s.values.data() + r * s.padded);
  }
  s.scale2.assign(3 * s.padded, 1.0F);
  s.rotation.assign(9 * s.padded, 0.0F);
  for (std::size_t i = 0; i < s.count; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      s.scale2[k * s.padded + i] = std::exp(2.0F * s.row(SIM_LOG_SCALE + k)[i]);
    }
    float q[4], norm2 = 0.0F;
    for (std::size_t k = 0; k < 4; ++k) {
      q[k] = s.row(SIM_ROTATION + k)[i];
      norm2 += q[k] * q[k];
    }
    for (float& value : q) value /= std::sqrt(norm2);
    const float w = q[0], x = q[1], y = q[2], z = q[3];
    const float r[9] = {1.0F - 2.0F * (y * y + z * z),
                        2.0F * (x * y - w * z),
                        2.0F * (x * z + w * y),
                        2.0F * (x * y + w * z),
                        1.0F - 2.0F * (x * x + z * z),
                        2.0F * (y * z - w * x),
                        2.0F * (x * z - w * y),
                        2.0F * (y * z + w * x),
                        1.0F - 2.0F * (x * x + y * y)};
    for (std::size_t k = 0; k < 9; ++k) s.rotation[k * s.padded + i] = r[k];
  }
  s.particles.resize(s.padded);
  s.half.resize(3 * s.padded);
  s.device = rtcNewDevice(("threads=" + std::to_string(s.threads)).c_str());
  if (s.device == nullptr) throw_embree(rtcGetDeviceError(nullptr));
  if (rtcGetDeviceProperty(s.device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) == 0) {
    throw Error(ErrorKind::kDevice, "Embree: found no native packets of 16 rays, allowed AVX-512 processors");
  }
}

EmbreeTracer::~EmbreeTracer() = default;

EmbreeTracer::State::~State() {
  if (scene != nullptr) rtcReleaseScene(scene);
  if (device != nullptr) rtcReleaseDevice(device);
}

void EmbreeTracer::State::prepare_block(std::size_t i, const Constants& c) {
  F offset[3], range2 = 0.0F;
  for (std::size_t k = 0; k < 3; ++k) {
    offset[k] = load(row(SIM_MEAN + k) + i) - c.centre_ref[k];
    range2 += offset[k] * offset[k];
  }
  F out[12];
  for (std::size_t j = 0; j < 3; ++j) {
    const F inv = 1.0F / sqrt(load(scale2.data() + j * padded + i) + c.model.kappa * range2);
    F sum = 0.0F;
    for (std::size_t k = 0; k < 3; ++k) {
      out[3 + 3 * j + k] = load(rotation.data() + (3 * k + j) * padded + i) * inv;
      sum -= out[3 + 3 * j + k] * offset[k];
    }
    out[j] = sum;
  }
  const F inv_range = 1.0F / sqrt(range2);
  F basis[16];
  sh_basis(sh_degree, offset[0] * inv_range, offset[1] * inv_range, offset[2] * inv_range, basis);
  const int coefficients = (sh_degree + 1) * (sh_degree + 1);
  F features[3];
  for (int channel = 0; channel < 3; ++channel) {
    F sum = channel < clamped_channels ? 0.5F : 0.0F;
    for (int k = 0; k < coefficients; ++k) {
      sum += basis[k] * load(row(static_cast<std::size_t>(SIM_SH + 3 * k + channel)) + i);
    }
    features[channel] = channel < clamped_channels ? max(sum, F(0.0F)) : sum;
  }
  float lanes[15 * W];
  for (int k = 0; k < 12; ++k) store(out[k], lanes + k * W);
  for (int k = 0; k < 3; ++k) store(features[k], lanes + (12 + k) * W);
  for (int lane = 0; lane < W; ++lane) {
    Particle& p = particles[i + static_cast<std::size_t>(lane)];
    for (int k = 0; k < 3; ++k) p.origin[k] = lanes[k * W + lane];
    for (int k = 0; k < 9; ++k) p.m[k] = lanes[(3 + k) * W + lane];
    for (int k = 0; k < 3; ++k) p.feature[k] = lanes[(12 + k) * W + lane];
  }
}

void EmbreeTracer::State::bound_block(std::size_t i, const Constants& c) {
  F range2 = 0.0F;
  for (std::size_t k = 0; k < 3; ++k) {
    const F offset = load(row(SIM_MEAN + k) + i) - c.centre_ref[k];
    range2 += offset * offset;
  }
  F q_max;
  const float log_cut = std::log(c.alpha_cut);
  for (std::size_t lane = 0; lane < W; ++lane) {
    const float logit = row(SIM_OPACITY)[i + lane];
    q_max[lane] = -2.0F * (std::log(1.0F + std::exp(-logit)) + log_cut);
    particles[i + lane].q_max = q_max[lane];
  }
  for (std::size_t k = 0; k < 3; ++k) {
    F sum = 0.0F;  // covariance of the ellipsoid
    for (std::size_t j = 0; j < 3; ++j) {
      const F r = load(rotation.data() + (3 * k + j) * padded + i);
      sum += r * r * (load(scale2.data() + j * padded + i) + c.model.kappa * range2);
    }
    store(sqrt(max(q_max, F(0.0F)) * sum), half.data() + k * padded + i);
  }
}

void EmbreeTracer::State::bounds(const RTCBoundsFunctionArguments* args) {
  const State& s = *static_cast<const State*>(args->geometryUserPtr);
  float low[3], high[3];
  // An invisible particle has no box.
  const bool seen = s.particles[args->primID].q_max > 0.0F;
  for (std::size_t k = 0; k < 3; ++k) {
    const float mean = s.row(SIM_MEAN + k)[args->primID];
    const float reach = s.half[k * s.padded + args->primID] * (1.0F + kBoxMargin);
    low[k] = seen ? mean - reach : kNowhere;
    high[k] = seen ? mean + reach : -kNowhere;
  }
  *args->bounds_o = {low[0], low[1], low[2], 0.0F, high[0], high[1], high[2], 0.0F};
}

void EmbreeTracer::State::new_scene() {
  if (scene != nullptr) rtcReleaseScene(scene);
  scene = rtcNewScene(device);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(count));
  rtcSetGeometryUserData(geometry, this);
  rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE) throw_embree(error);
}

void EmbreeTracer::build(const TracedFrame& frame) {
  State& s = *state_;
  const Constants c = in_float(frame.constants);
  in_parallel(s.padded / W, kBlocksAtOnce, s.threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) s.bound_block(i * W, c);
  });
  s.new_scene();
}

void EmbreeTracer::prepare(const TracedFrame& frame) {
  State& s = *state_;
  const Constants c = in_float(frame.constants);
  in_parallel(s.padded / W, kBlocksAtOnce, s.threads, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < last; ++i) s.prepare_block(i * W, c);
  });
}

}  // namespace simuli::bench
