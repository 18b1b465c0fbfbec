#pragma once
// The stages of a Renderer: for renderer.cpp alone.
#include <array>
#include <map>
#include <memory>
#include <optional>

#include "host/render/backward/backward_stages.hpp"
#include "host/render/backward/pose_bwd.hpp"
#include "host/render/frame/stages.hpp"
#include "host/render/scene/renderer.hpp"
#include "host/render/train/loss_stages.hpp"

namespace simuli {

struct Renderer::Stages {
  Stages(const Device& device, const Variant& variant)
      : rays(device, variant), project(device, variant), render(device, variant), own(variant) {}
  RaysStage rays;
  ProjectStage project;
  RenderStage render;
  // These when asked for.
  std::optional<RenderBackwardStage> render_back;
  std::optional<ProjectBackwardStage> project_back;
  std::optional<PoseStage> pose;
  Variant own;
};

struct Renderer::AllStages {
  AllStages(const Device& device, Precision precision)
      : bin(device), image_loss(device, precision), lidar_loss(device, precision) {}
  struct ColorGrid {
    ColorGridStage forward;
    std::optional<ColorGridBackwardStage> back;
  };
  ColorGrid& of(const Device& device, const ColorGridBuffers& sizes) {
    const std::array<int, 3> size{sizes.size_x, sizes.size_y, sizes.size_z};
    const auto found = grids.find(size);
    return found != grids.end()
               ? found->second
               : grids.emplace(size, ColorGrid{ColorGridStage(device, sizes), {}}).first->second;
  }
  std::map<Variant, std::unique_ptr<Stages>> of_variant;
  BinStage bin;
  ImageLossStage image_loss;
  LidarLossStage lidar_loss;
  // These when asked for.
  std::optional<EnvironmentStage> environment;
  std::optional<EnvironmentBackwardStage> environment_back;
  std::map<std::array<int, 3>, ColorGrid> grids;
};

}  // namespace simuli
