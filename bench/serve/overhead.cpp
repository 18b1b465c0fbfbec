// Program simuli_serve_bench SCENE CAMERA WIDTH HEIGHT [FRAMES]: overhead of the server relative to
// rendering.
//
// Renders pictures along the recorded trajectory over loopback, planar, and each also without the server, as
// numbers and as bytes, in turns; then the same with an empty view, so that the overhead is not hidden by the
// spread of rendering times; then six pictures of one time as a batch and as six calls. Prints medians and
// half of the interquartile ranges.
#include <algorithm>
#include <cstdlib>
#include <exception>
#include <fmt/format.h>
#include <grpcpp/grpcpp.h>
#include <string>
#include <vector>

#include "host/apps/serve/messages/render_message.hpp"
#include "host/apps/serve/server/server.hpp"
#include "host/core/base/spread.hpp"
#include "host/core/base/stopwatch.hpp"
#include "sensorsim.grpc.pb.h"

namespace simuli::serve {
namespace {

using Service = ::nre::grpc::protos::sensorsim::SensorsimService;

void print(const char* what, const std::vector<double>& ms) {
  const Spread spread = spread_of(ms);
  fmt::print("{:<44} {:8.2f} ms +- {:.2f}\n", what, spread.median, spread.half_iqr);
}

void need(const grpc::Status& status) {
  if (!status.ok()) throw std::runtime_error(status.error_message());
}

int run(const std::vector<std::string>& arguments) {
  if (arguments.size() < 4) throw std::runtime_error("SCENE CAMERA WIDTH HEIGHT [FRAMES]");
  const int frames = arguments.size() > 4 ? std::atoi(arguments[4].c_str()) : 60;
  SessionOptions of_session;
  of_session.scenes = scene_sources({"scene=" + arguments[0]});
  RenderSession session(of_session);
  const Handlers handlers(session, EgoMasks(), "");
  ServerOptions of_server;
  of_server.port = 0;
  Server server(handlers, of_server);
  grpc::ChannelArguments unlimited;
  unlimited.SetMaxReceiveMessageSize(-1);
  const auto stub = Service::NewStub(
      grpc::CreateCustomChannel(server.address(), grpc::InsecureChannelCredentials(), unlimited));

  const auto scene = session.open("scene");
  const Sensor* const own = scene->find_camera(arguments[1]);
  if (own == nullptr) throw std::runtime_error("no camera " + arguments[1]);
  const int width = std::atoi(arguments[2].c_str()), height = std::atoi(arguments[3].c_str());
  const Trajectory& path = scene->world_from_rig();
  const auto request_at = [&](double time_s, float above_m = 0.0F) {
    proto::RGBRenderRequest request;
    request.set_scene_id("scene");
    request.set_resolution_w(static_cast<std::uint32_t>(width));
    request.set_resolution_h(static_cast<std::uint32_t>(height));
    *request.mutable_camera_intrinsics() = spec_of(own->camera());
    const std::uint64_t us = scene->microseconds(time_s);
    request.set_frame_start_us(us);
    request.set_frame_end_us(us);
    auto pose = message_of(scene->local(path.at(time_s) * own->rig_from_sensor()));
    pose.mutable_vec()->set_z(pose.vec().z() + above_m);
    *request.mutable_sensor_pose()->mutable_start_pose() = pose;
    *request.mutable_sensor_pose()->mutable_end_pose() = pose;
    request.set_image_format(proto::RGB_UINT8_PLANAR);
    return request;
  };
  const auto alone = [&](const proto::RGBRenderRequest& request, bool with_results) {
    const FrameMessage frame{
        request.frame_start_us(), request.frame_end_us(), request.sensor_pose(), request.dynamic_objects()};
    const Camera camera = requested_camera(*scene, request);
    std::array<FrameJob, 1> job{FrameJob{Sensor(camera), camera_shot(*scene, frame, camera)}};
    if (with_results) job[0].take = [](const Frame& f) { static_cast<void>(f.results()); };
    const Stopwatch watch;
    session.render(*scene, job);
    if (job[0].error) std::rethrow_exception(job[0].error);
    return watch.ms();
  };
  const auto served = [&](const proto::RGBRenderRequest& request) {
    grpc::ClientContext context;
    proto::RGBRenderReturn reply;
    const Stopwatch watch;
    need(stub->render_rgb(&context, request, &reply));
    return watch.ms();
  };
  struct Times {
    std::vector<double> results, pictures, calls, more;
  };
  // The first frames compile.
  const auto measure = [&](float above_m) {
    Times times;
    for (int i = -2; i < frames; ++i) {
      const double share = std::max(0.0, (i + 0.5) / frames);
      const auto request = request_at(path.start_s() + share * (path.end_s() - path.start_s()), above_m);
      const bool is_first = i % 2 == 0;
      const double results_ms = alone(request, true);
      double picture_ms = is_first ? alone(request, false) : 0.0;
      const double call_ms = served(request);
      if (!is_first) picture_ms = alone(request, false);
      if (i < 0) continue;
      times.results.push_back(results_ms);
      times.pictures.push_back(picture_ms);
      times.calls.push_back(call_ms);
      times.more.push_back(call_ms - picture_ms);
    }
    return times;
  };
  const Times along_path = measure(0.0F);
  constexpr float kAbove_m = 1000.0F;
  const Times in_the_sky = measure(kAbove_m);
  std::vector<double> batches, sixes;
  for (int i = 0; i < frames / 6; ++i) {
    const auto request =
        request_at(path.start_s() + (i + 0.5) / (frames / 6) * (path.end_s() - path.start_s()));
    proto::BatchRGBRenderRequest six;
    for (int k = 0; k < 6; ++k) *six.add_items()->mutable_request() = request;
    grpc::ClientContext context;
    proto::BatchRGBRenderReturn reply;
    const Stopwatch watch;
    need(stub->batch_render_rgb(&context, six, &reply));
    batches.push_back(watch.ms());
    double sum_ms = 0.0;
    for (int k = 0; k < 6; ++k) sum_ms += served(request);
    sixes.push_back(sum_ms);
  }
  fmt::print("{} x {} px, {} particles, {}\n",
             width,
             height,
             scene->scene().camera.size(),
             session.device().info().label());
  const auto print_all = [](const Times& times) {
    print("render, and results on the host", times.results);
    print("render, and the picture's bytes on the host", times.pictures);
    print("render_rgb, planar, over loopback", times.calls);
    print("that less the line above, frame by frame", times.more);
  };
  print_all(along_path);
  fmt::print("{:.0f} m higher, with nothing but sky in view\n", kAbove_m);
  print_all(in_the_sky);
  print("six pictures in a batch", batches);
  print("six calls, one after the other", sixes);
  return 0;
}

}  // namespace
}  // namespace simuli::serve

int main(int argc, char** argv) {
  try {
    return simuli::serve::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "simuli_serve_bench: {}\n", error.what());
    return 2;
  }
}
