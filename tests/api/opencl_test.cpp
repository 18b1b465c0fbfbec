// A context and queue of the caller's, and frames as device memory: by rendering.
#include <cstdint>
#include <simuli/opencl.h>
#include <vector>

#include "tests/api/small_scene.hpp"

namespace simuli {
namespace {

/// A context and queue as a program makes them that uses OpenCL by itself.
class OwnQueue {
 public:
  OwnQueue() {
    const cl_device_id device = opencl::device_id(Device::best());
    cl_int code = CL_SUCCESS;
    context_ = clCreateContext(nullptr, 1, &device, nullptr, nullptr, &code);
    EXPECT_EQ(code, CL_SUCCESS);
    queue_ = clCreateCommandQueue(context_, device, 0, &code);
    EXPECT_EQ(code, CL_SUCCESS);
  }
  OwnQueue(const OwnQueue&) = delete;
  OwnQueue& operator=(const OwnQueue&) = delete;
  ~OwnQueue() {
    clReleaseCommandQueue(queue_);
    clReleaseContext(context_);
  }
  [[nodiscard]] cl_context context() const { return context_; }
  [[nodiscard]] cl_command_queue queue() const { return queue_; }

  template <class T>
  [[nodiscard]] std::vector<T> read(cl_mem memory, std::size_t count, cl_event after = nullptr) const {
    std::vector<T> out(count);
    const cl_uint events = after == nullptr ? 0 : 1;
    EXPECT_EQ(clEnqueueReadBuffer(queue_,
                                  memory,
                                  CL_TRUE,
                                  0,
                                  count * sizeof(T),
                                  out.data(),
                                  events,
                                  after ? &after : nullptr,
                                  nullptr),
              CL_SUCCESS);
    return out;
  }

 private:
  cl_context context_ = nullptr;
  cl_command_queue queue_ = nullptr;
};

TEST(OpenClInterop, FramesOnTheCallersQueueAreTheSame) {
  const OwnQueue own;
  SceneFile file = scene_with_actor();
  const SensorRig rig(file);
  SceneOnDevice here(Device::adopt(own.context(), own.queue()), file.scene);
  SceneOnDevice there(Device::best(), file.scene);
  EXPECT_EQ(opencl::context(here.device()), own.context());
  EXPECT_EQ(opencl::queue(here.device()), own.queue());
  for (const Sensor& sensor : rig.sensors()) {
    const Shot shot = Shot::along(file.world_from_rig, sensor, 0.3);
    const Frame frame = here.render(sensor, shot);
    const simuli_frame_memory memory = opencl::memory(frame);
    ASSERT_EQ(memory.rays, sensor.ray_count());
    ASSERT_EQ(memory.is_double, 0);
    EXPECT_EQ(memory.picture, nullptr);
    // Behind the frame's event, before anything asks the frame itself.
    const std::size_t rows = sensor.is_camera() ? 6 : 7;
    const auto outputs = own.read<float>(memory.outputs, rows * memory.slots, memory.ready);
    const auto slot_of_ray = own.read<std::int32_t>(memory.slot_of_ray, memory.rays);
    const auto ray_of_slot = own.read<std::int32_t>(memory.ray_of_slot, memory.slots);
    const RayResults& seen = frame.results();
    const RayResults elsewhere = there.render(sensor, shot).results();
    std::size_t met = 0;
    for (std::size_t ray = 0; ray < memory.rays; ++ray) {
      const auto slot = static_cast<std::size_t>(slot_of_ray[ray]);
      ASSERT_EQ(ray_of_slot[slot], static_cast<std::int32_t>(ray));
      for (std::size_t c = 0; c < 3; ++c) {
        ASSERT_EQ(outputs[c * memory.slots + slot], seen.feature[c][ray]) << sensor.name() << ", ray " << ray;
        ASSERT_EQ(seen.feature[c][ray], elsewhere.feature[c][ray]);
      }
      ASSERT_EQ(outputs[3 * memory.slots + slot], seen.transmittance[ray]);
      ASSERT_EQ(outputs[4 * memory.slots + slot], seen.distance[ray]);
      if (rows == 7) {
        ASSERT_EQ(outputs[6 * memory.slots + slot], seen.drop_logit[ray]);
      }
      met += seen.transmittance[ray] < 0.5F ? 1 : 0;
    }
    EXPECT_GT(met, 0U);
  }
}

TEST(OpenClInterop, AFramesEventCompletes) {
  SceneFile file = small_scene();
  const SensorRig rig(file);
  const Sensor camera = rig.find("front");
  SceneOnDevice scene(Device::best(), file.scene);
  const Frame frame = scene.render(camera, Shot::along(file.world_from_rig, camera, 0.0));
  const cl_event ready = opencl::memory(frame).ready;
  ASSERT_EQ(clWaitForEvents(1, &ready), CL_SUCCESS);
  EXPECT_TRUE(frame.is_ready());
}

TEST(OpenClInterop, GradedPicturesAreAnotherBuffer) {
  SceneFile file = small_scene();
  file.scene.color_grids = ColorGrids::identity(2, 2, 2, {{"front", 0.0}});
  for (std::size_t i = 0; i < file.scene.color_grids.values.size(); ++i) {
    if (i % ColorGrids::kMatrix == 3) file.scene.color_grids.values[i] = 0.25F;  // added to red
  }
  const SensorRig rig(file);
  const Sensor camera = rig.find("front");
  const OwnQueue own;
  SceneOnDevice scene(Device::adopt(own.context(), own.queue()), file.scene);
  const Frame frame = scene.render(camera, Shot::along(file.world_from_rig, camera, 0.0));
  const simuli_frame_memory memory = opencl::memory(frame);
  ASSERT_NE(memory.picture, nullptr);
  const auto picture = own.read<float>(memory.picture, 3 * memory.slots, memory.ready);
  const auto slot_of_ray = own.read<std::int32_t>(memory.slot_of_ray, memory.rays);
  for (std::size_t ray = 0; ray < memory.rays; ++ray) {
    ASSERT_EQ(picture[static_cast<std::size_t>(slot_of_ray[ray])], frame.results().feature[0][ray]);
  }
  EXPECT_GT(frame.results().feature[0][0], 0.2F);
}

TEST(OpenClInterop, InC) {
  const OwnQueue own;
  simuli_device* device = nullptr;
  ASSERT_EQ(simuli_device_adopt(own.context(), own.queue(), &device), SIMULI_OK) << simuli_error();
  cl_context context = nullptr;
  cl_command_queue queue = nullptr;
  ASSERT_EQ(simuli_device_opencl(device, &context, &queue), SIMULI_OK);
  EXPECT_EQ(context, own.context());
  EXPECT_EQ(queue, own.queue());
  simuli_device_close(device);
  EXPECT_EQ(simuli_device_adopt(nullptr, own.queue(), &device), SIMULI_USAGE);
  const OwnQueue other;
  EXPECT_EQ(simuli_device_adopt(own.context(), other.queue(), &device), SIMULI_DEVICE);
  EXPECT_NE(std::string(simuli_error()).find("another context"), std::string::npos) << simuli_error();
}

}  // namespace
}  // namespace simuli
