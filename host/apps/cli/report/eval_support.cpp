#include "host/apps/cli/report/eval_support.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "optim/base/frames.hpp"

namespace simuli::cli {
namespace {

using Json = nlohmann::ordered_json;

double share_of(const SupportReliability::Bin& bin, const SupportReliability& all) {
  return all.count == 0 ? 0.0 : static_cast<double>(bin.count) / static_cast<double>(all.count);
}

Json json_of(const SupportReliability& found) {
  Json curve = Json::array();
  for (const SupportReliability::Bin& bin : found.bins) {
    curve.push_back({{"share", share_of(bin, found)}, {"support", bin.support}, {"right", bin.right}});
  }
  return {{"count", found.count},
          {"mean", found.mean_support},
          {"right", found.right},
          {"rank_correlation", found.rank_correlation},
          {"calibration_error", found.calibration_error},
          {"curve", std::move(curve)}};
}

std::string line_of(const char* what, const SupportReliability& found, const char* right) {
  return fmt::format("  support of {:<7} mean {:.3f}, {} {:.3f}; rank correlation with errors {:.3f}\n",
                     what,
                     found.mean_support,
                     right,
                     found.right,
                     found.rank_correlation);
}

}  // namespace

EvalSupport eval_support(const Evaluation& evaluation) {
  const SceneFile& file = evaluation.scene();
  const Log& log = evaluation.log();
  SceneOnDevice scene(evaluation.device(), borrowed(file.scene), evaluation.options().render);
  SupportOnDevice support(evaluation.device(), file.support);
  SupportSamples pixels, rays;
  std::set<std::string> trained, unseen;
  for (const SupportSensor& sensor : file.support->sensors) trained.insert(sensor.name);
  for (const std::size_t index : evaluation.frames().images) {
    const ImageFrame& frame = log.images[index];
    const Camera camera =
        scaled_camera(log.camera(frame.camera).model, evaluation.frames().requested.image_scale);
    const Tint tint = trained.count(frame.camera) > 0 ? Tint::kKnown : Tint::kUnknown;
    if (tint == Tint::kUnknown) unseen.insert(frame.camera);
    pixels.add_picture(scene, support, log, frame, camera, kEvalSupportStep, tint);
  }
  for (const std::size_t index : evaluation.frames().sweeps) {
    rays.add_sweep(scene, support, log, log.sweeps[index], kEvalSupportStep);
  }
  return {reliability(pixels, kSupportColour), reliability(rays, kSupportRange_m), std::move(unseen)};
}

Json json_of(const EvalSupport& support) {
  return {
      {"pixels", json_of(support.pixels)}, {"rays", json_of(support.rays)}, {"without_tint", support.unseen}};
}

std::string text_of(const EvalSupport& support) {
  std::string text;
  if (support.pixels.count > 0)
    text += line_of("pixels", support.pixels, fmt::format("within {} of the truth", kSupportColour).c_str());
  if (support.rays.count > 0)
    text += line_of("rays", support.rays, fmt::format("within {:g} cm", 100.0 * kSupportRange_m).c_str());
  if (!support.unseen.empty()) {
    text += fmt::format("  without their pictures' tints, as training had none of them: {}\n",
                        fmt::join(support.unseen, ", "));
  }
  text += "  support          of pixels, right     of rays, right\n";
  for (std::size_t k = 0; k < SupportReliability::kBins; ++k) {
    const SupportReliability::Bin &p = support.pixels.bins[k], &r = support.rays.bins[k];
    text += fmt::format("  {:.1f} to {:.1f}        {:>6.1f} % {:>8.3f}    {:>6.1f} % {:>8.3f}\n",
                        0.1 * static_cast<double>(k),
                        0.1 * static_cast<double>(k + 1),
                        100.0 * share_of(p, support.pixels),
                        p.right,
                        100.0 * share_of(r, support.rays),
                        r.right);
  }
  return text;
}

}  // namespace simuli::cli
