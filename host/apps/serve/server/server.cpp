#include "host/apps/serve/server/server.hpp"

#include <atomic>
#include <condition_variable>
#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>
#include <grpc/grpc.h>
#include <grpc/support/log.h>
#include <grpcpp/ext/health_check_service_server_builder_option.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/resource_quota.h>
#include <grpcpp/support/server_interceptor.h>
#include <mutex>
#include <thread>

#include "host/apps/serve/session/refusal.hpp"
#include "host/apps/serve/session/shared_work.hpp"
#include "host/apps/serve/session/unread_replies.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/stopwatch.hpp"
#include "io/base/file.hpp"
#include "nurec_sensorsim.grpc.pb.h"
#include "sensorsim.grpc.pb.h"

namespace simuli::serve {
namespace {

using NreService = ::nre::grpc::protos::sensorsim::SensorsimService;
using NurecService = ::nurec::grpc::protos::sensorsim::SensorsimService;
using grpc::ServerContext;
using grpc::Status;

constexpr int kMostStreams = 64;      // of a connection, at the same time
constexpr int kWaitingThreads = 128;  // of requests that wait for a worker
// Of incomplete requests of all connections; the server cancels them beyond this size.
constexpr std::size_t kMostRequestBytes = std::size_t{256} << 20U;
constexpr const char* kLidarKey = "x-simuli-lidar";

/// Returns the name in the protocol's documentation.
const char* name_of(grpc::StatusCode code) {
  switch (code) {
    case grpc::OK:
      return "OK";
    case grpc::CANCELLED:
      return "CANCELLED";
    case grpc::INVALID_ARGUMENT:
      return "INVALID_ARGUMENT";
    case grpc::NOT_FOUND:
      return "NOT_FOUND";
    case grpc::PERMISSION_DENIED:
      return "PERMISSION_DENIED";
    case grpc::RESOURCE_EXHAUSTED:
      return "RESOURCE_EXHAUSTED";
    case grpc::FAILED_PRECONDITION:
      return "FAILED_PRECONDITION";
    case grpc::OUT_OF_RANGE:
      return "OUT_OF_RANGE";
    case grpc::UNIMPLEMENTED:
      return "UNIMPLEMENTED";
    default:
      return "INTERNAL";
  }
}

Call call_of(const ServerContext& context) {
  Call call{[&context] { return context.IsCancelled(); }};
  const auto found = context.client_metadata().find(kLidarKey);
  if (found != context.client_metadata().end()) {
    call.lidar = std::string(found->second.data(), found->second.size());
  }
  return call;
}

/// Reports the end of a call; the library offers no other notification.
class CallEnds final : public grpc::experimental::ServerInterceptorFactoryInterface {
 public:
  explicit CallEnds(UnreadReplies& replies) : replies_(replies) {}
  grpc::experimental::Interceptor* CreateServerInterceptor(grpc::experimental::ServerRpcInfo* info) override {
    return new OfCall(replies_, info->server_context());
  }

 private:
  class OfCall final : public grpc::experimental::Interceptor {
   public:
    OfCall(UnreadReplies& replies, const void* call) : replies_(replies), call_(call) {}
    ~OfCall() override { replies_.end(call_); }
    void Intercept(grpc::experimental::InterceptorBatchMethods* batch) override { batch->Proceed(); }

   private:
    UnreadReplies& replies_;
    const void* call_;
  };
  UnreadReplies& replies_;
};

/// End of a call by its client.
struct End {
  bool is_allowed = false;
  std::atomic<bool> is_requested_for{false};
};

/// The service under one of its two names.
template <class Base>
class Sensorsim final : public Base::Service {
 public:
  Sensorsim(const Handlers& handlers,
            const FairQueue& workers,
            SharedWork& rendering,
            UnreadReplies& replies,
            End& end,
            std::atomic<int>& at_work)
      : handlers_(handlers),
        workers_(workers),
        rendering_(rendering),
        replies_(replies),
        end_(end),
        at_work_(at_work) {}

  Status get_version(ServerContext* c,
                     const proto_common::Empty* /*q*/,
                     proto_common::VersionId* r) override {
    return reported("get_version", c, *r, [&] { handlers_.get_version(*r); });
  }
  Status get_available_scenes(ServerContext* c,
                              const proto_common::Empty* /*q*/,
                              proto_common::AvailableScenesReturn* r) override {
    return reported("get_available_scenes", c, *r, [&] { handlers_.get_available_scenes(*r); });
  }
  Status get_loaded_scenes(ServerContext* c,
                           const proto_common::Empty* /*q*/,
                           proto::LoadedScenesReturn* r) override {
    return reported("get_loaded_scenes", c, *r, [&] { handlers_.get_loaded_scenes(*r); });
  }
  Status get_available_ego_masks(ServerContext* c,
                                 const proto_common::Empty* /*q*/,
                                 proto::AvailableEgoMasksReturn* r) override {
    return reported("get_available_ego_masks", c, *r, [&] { handlers_.get_available_ego_masks(*r); });
  }
  Status get_available_cameras(ServerContext* c,
                               const proto::AvailableCamerasRequest* q,
                               proto::AvailableCamerasReturn* r) override {
    return worked("get_available_cameras", c, *r, [&](const Call& call) {
      handlers_.get_available_cameras(call, *q, *r);
    });
  }
  Status get_available_trajectories(ServerContext* c,
                                    const proto::AvailableTrajectoriesRequest* q,
                                    proto::AvailableTrajectoriesReturn* r) override {
    return worked("get_available_trajectories", c, *r, [&](const Call& call) {
      handlers_.get_available_trajectories(call, *q, *r);
    });
  }
  Status get_dynamic_objects(ServerContext* c,
                             const proto::AvailableDynamicObjectsRequest* q,
                             proto::AvailableDynamicObjectsReturn* r) override {
    return worked(
        "get_dynamic_objects", c, *r, [&](const Call& call) { handlers_.get_dynamic_objects(call, *q, *r); });
  }
  Status edit_assets(ServerContext* c,
                     const proto::EditAssetsRequest* q,
                     proto::EditAssetsResponse* r) override {
    return worked("edit_assets", c, *r, [&](const Call& call) { handlers_.edit_assets(call, *q, *r); });
  }
  Status restore_model_parameters(ServerContext* c,
                                  const proto::RestoreModelParametersRequest* q,
                                  proto_common::Empty* r) override {
    return worked("restore_model_parameters", c, *r, [&](const Call& call) {
      handlers_.restore_model_parameters(call, *q);
    });
  }
  Status get_external_asset_objects(ServerContext* c,
                                    const proto::ExternalAssetObjectsRequest* q,
                                    proto::ExternalAssetObjectsReturn* r) override {
    return worked("get_external_asset_objects", c, *r, [&](const Call& call) {
      handlers_.get_external_asset_objects(call, *q, *r);
    });
  }
  Status get_server_config(ServerContext* c,
                           const proto_common::Empty* /*q*/,
                           proto::ServerConfig* r) override {
    return reported("get_server_config", c, *r, [&] { handlers_.get_server_config(*r); });
  }
  Status shut_down(ServerContext* c, const proto_common::Empty* /*q*/, proto_common::Empty* r) override {
    return reported("shut_down", c, *r, [&] {
      if (!end_.is_allowed) {
        throw Refusal(RefusalKind::kDenied,
                      "shut_down: found a server without --allow-shut-down, allowed one with it");
      }
      end_.is_requested_for = true;
    });
  }
  Status render_rgb(ServerContext* c, const proto::RGBRenderRequest* q, proto::RGBRenderReturn* r) override {
    return shared("render_rgb", c, *q, *r, [&](const Call& call, proto::RGBRenderReturn& reply) {
      handlers_.render_rgb(call, *q, reply);
    });
  }
  Status batch_render_rgb(ServerContext* c,
                          const proto::BatchRGBRenderRequest* q,
                          proto::BatchRGBRenderReturn* r) override {
    return shared("batch_render_rgb", c, *q, *r, [&](const Call& call, proto::BatchRGBRenderReturn& reply) {
      handlers_.batch_render_rgb(call, *q, reply);
    });
  }
  Status render_lidar(ServerContext* c,
                      const proto::LidarRenderRequest* q,
                      proto::LidarRenderReturn* r) override {
    return shared("render_lidar", c, *q, *r, [&](const Call& call, proto::LidarRenderReturn& reply) {
      handlers_.render_lidar(call, *q, reply);
    });
  }
  Status render_aggregated(ServerContext* c,
                           const proto::AggregatedRenderRequest* q,
                           proto::AggregatedRenderReturn* r) override {
    return shared(
        "render_aggregated", c, *q, *r, [&](const Call& call, proto::AggregatedRenderReturn& reply) {
          handlers_.render_aggregated(call, *q, reply);
        });
  }

 private:
  template <class Reply, class Work>
  Status reported(const char* name, ServerContext* context, const Reply& reply, const Work& work) const {
    const Stopwatch watch;
    ++at_work_;
    const Status status = status_of(work);
    const std::size_t bytes = status.ok() ? reply.ByteSizeLong() : 0;
    replies_.begin(static_cast<const grpc::ServerContextBase*>(context), bytes, [call = context->c_call()] {
      grpc_call_cancel_with_status(
          call, GRPC_STATUS_RESOURCE_EXHAUSTED, "reply: found a client that does not read it", nullptr);
    });
    // Counted after begin(), so that a client that reads the reply finds the call in the metrics.
    handlers_.metrics().count_call(name, name_of(status.error_code()), watch.seconds(), bytes);
    --at_work_;
    return status;
  }
  template <class Work>
  static Status status_of(const Work& work) {
    try {
      work();
      return Status::OK;
    } catch (...) {
      const Refusal refusal = refusal_of(std::current_exception());
      return {static_cast<grpc::StatusCode>(refusal.kind()), refusal.what()};
    }
  }
  template <class Reply, class Work>
  Status worked(const char* name, ServerContext* context, const Reply& reply, const Work& work) const {
    return reported(name, context, reply, [&] { in_turn(call_of(*context), work); });
  }
  template <class Work>
  void in_turn(const Call& call, const Work& work) const {
    const Stopwatch watch;
    const FairQueue::Ticket worker = workers_.take(call.is_given_up);
    replies_.need_room(call.is_given_up);
    handlers_.metrics().add_time(RequestStage::kWorkerWait, watch.seconds());
    throw_if_cancelled(call.is_given_up);
    work(call);
  }
  /// Computes one reply for all concurrent equal requests for the same scenes.
  template <class Request, class Reply, class Work>
  Status shared(const char* name,
                ServerContext* context,
                const Request& request,
                Reply& reply,
                const Work& work) const {
    return reported(name, context, reply, [&] {
      Call call = call_of(*context);
      const std::string key =
          fmt::format("{} {} {}\n", name, handlers_.edition(), call.lidar) + request.SerializeAsString();
      const IsGivenUp own = call.is_given_up;
      const SharedWork::Result result = rendering_.get(
          key,
          [&](const IsGivenUp& nobody_waits) {
            const auto made = std::make_shared<Reply>();
            call.is_given_up = nobody_waits;
            in_turn(call, [&](const Call& of_all) { work(of_all, *made); });
            return made;
          },
          own);
      reply = *static_cast<const Reply*>(result.get());
    });
  }

  const Handlers& handlers_;
  const FairQueue& workers_;
  SharedWork& rendering_;
  UnreadReplies& replies_;
  End& end_;
  std::atomic<int>& at_work_;
};

std::shared_ptr<grpc::ServerCredentials> credentials_of(const ServerOptions& options) {
  const bool has_certificate = !options.tls_certificate.empty(), has_key = !options.tls_key.empty();
  if (has_certificate != has_key) {
    throw Error(ErrorKind::kUsage, "--tls-cert: found without --tls-key or that without it, allowed both");
  }
  if (!has_certificate) {
    if (!options.tls_clients.empty()) {
      throw Error(ErrorKind::kUsage, "--tls-clients: found without --tls-cert, allowed with it");
    }
    return grpc::InsecureServerCredentials();
  }
  grpc::SslServerCredentialsOptions tls(options.tls_clients.empty()
                                            ? GRPC_SSL_DONT_REQUEST_CLIENT_CERTIFICATE
                                            : GRPC_SSL_REQUEST_AND_REQUIRE_CLIENT_CERTIFICATE_AND_VERIFY);
  tls.pem_key_cert_pairs.push_back({read_file(options.tls_key), read_file(options.tls_certificate)});
  if (!options.tls_clients.empty()) tls.pem_root_certs = read_file(options.tls_clients);
  return grpc::SslServerCredentials(tls);
}

std::string address_of(const std::string& host, int port) {
  return host.find(':') == std::string::npos ? fmt::format("{}:{}", host, port)
                                             : fmt::format("[{}]:{}", host, port);
}

/// Silences the libraries' own output on stderr; errors are sent to the clients.
void silence_libraries() {
  gpr_set_log_function([](gpr_log_func_args* /*line*/) {});
  google::protobuf::SetLogHandler(nullptr);
}

}  // namespace

struct Server::Impl {
  Impl(const Handlers& of, const ServerOptions& with)
      : handlers(of),
        options(with),
        workers(with.max_workers),
        replies(with.replies),
        end{with.allows_shut_down},
        nre(handlers, workers, rendering, replies, end, at_work),
        nurec(handlers, workers, rendering, replies, end, at_work) {}

  const Handlers& handlers;
  ServerOptions options;
  FairQueue workers;
  SharedWork rendering;  // shared by both names
  UnreadReplies replies;
  End end;
  std::atomic<int> at_work{0};  // calls without a finished reply
  Sensorsim<NreService> nre;
  Sensorsim<NurecService> nurec;
  std::unique_ptr<grpc::Server> server;
  int port = 0;

  void set_serving(bool is_serving) const {
    grpc::HealthCheckServiceInterface* const health = server->GetHealthCheckService();
    if (health == nullptr) return;
    for (const char* const name : {"", NreService::service_full_name(), NurecService::service_full_name()}) {
      health->SetServingStatus(name, is_serving);
    }
  }
};

Server::Server(const Handlers& handlers, const ServerOptions& options)
    : impl_(std::make_unique<Impl>(handlers, options)) {
  silence_libraries();
  grpc::EnableDefaultHealthCheckService(true);
  grpc::ServerBuilder builder;
  grpc::ResourceQuota quota("simuli serve");
  quota.SetMaxThreads(static_cast<int>(options.max_workers) + kWaitingThreads);
  quota.Resize(kMostRequestBytes);
  builder.SetResourceQuota(quota);
  std::vector<std::unique_ptr<grpc::experimental::ServerInterceptorFactoryInterface>> interceptors;
  interceptors.push_back(std::make_unique<CallEnds>(impl_->replies));
  builder.experimental().SetInterceptorCreators(std::move(interceptors));
  // The library decompresses a request before it checks its size.
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_DEFLATE, false);
  builder.SetCompressionAlgorithmSupportStatus(GRPC_COMPRESS_GZIP, false);
  builder.AddChannelArgument(GRPC_ARG_ENABLE_PER_MESSAGE_DECOMPRESSION, 0);
  builder.SetMaxReceiveMessageSize(kLargestRequest);
  builder.SetMaxSendMessageSize(-1);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMostStreams);
  const int age_ms = static_cast<int>(options.connection_age.count());
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_MS, age_ms);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONNECTION_AGE_GRACE_MS, age_ms);
  // otherwise a second server on the port would get half of the calls
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);
  builder.AddListeningPort(address_of(options.host, options.port), credentials_of(options), &impl_->port);
  builder.RegisterService(&impl_->nre);
  builder.RegisterService(&impl_->nurec);
  impl_->server = builder.BuildAndStart();
  if (!impl_->server || impl_->port == 0) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format("--host, --port: found {}, allowed an address that is free, and TLS files that fit "
                    "each other",
                    address_of(options.host, options.port)));
  }
  impl_->set_serving(true);
}

Server::~Server() { drain(std::chrono::milliseconds(0)); }

int Server::port() const { return impl_->port; }
std::string Server::address() const { return address_of(impl_->options.host, impl_->port); }

bool Server::is_shut_down_requested() const { return impl_->end.is_requested_for; }

std::string Server::metrics() const {
  const FairQueue& workers = impl_->workers;
  std::vector<Gauge> gauges = impl_->handlers.gauges();
  gauges.push_back({"simuli_requests_waiting",
                    "Requests that wait for a worker.",
                    static_cast<double>(workers.waiting())});
  gauges.push_back({"simuli_requests_in_work",
                    "Requests that a worker has.",
                    static_cast<double>(impl_->options.max_workers - workers.free())});
  gauges.push_back({"simuli_replies_unread",
                    "Replies that are made and that clients have not taken yet.",
                    static_cast<double>(impl_->replies.count())});
  gauges.push_back(
      {"simuli_requests_shared",
       "Requests that came while another one was rendered for, in the same words, and got its answer.",
       static_cast<double>(impl_->rendering.shared())});
  return impl_->handlers.metrics().text(gauges);
}

void Server::drain(std::chrono::milliseconds patience) {
  if (!impl_->server) return;
  impl_->set_serving(false);
  // The library pings each connection and waits 20 s for silent ones; connections without calls are closed at
  // once.
  std::mutex mutex;
  std::condition_variable_any changed;
  std::jthread cutter([&](const std::stop_token& is_done) {
    constexpr std::chrono::milliseconds kQuiet{500}, kLookAgain{20};
    auto quiet_since = std::chrono::steady_clock::now();
    std::unique_lock lock(mutex);
    while (!changed.wait_for(lock, is_done, kLookAgain, [&] { return is_done.stop_requested(); })) {
      const auto now = std::chrono::steady_clock::now();
      if (impl_->at_work > 0 || impl_->replies.count() > 0) quiet_since = now;
      if (now - quiet_since < kQuiet) continue;
      grpc_server_cancel_all_calls(impl_->server->c_server());
      return;
    }
  });
  impl_->server->Shutdown(std::chrono::system_clock::now() + patience);
  impl_->server->Wait();
  cutter.request_stop();
  cutter.join();
  impl_->server.reset();
}

}  // namespace simuli::serve
