#include "host/serve/server/server.hpp"

#include <fmt/format.h>
#include <google/protobuf/stubs/logging.h>
#include <grpc/support/log.h>
#include <grpcpp/ext/health_check_service_server_builder_option.h>
#include <grpcpp/grpcpp.h>
#include <grpcpp/resource_quota.h>

#include "host/base/error.hpp"
#include "host/serve/session/refusal.hpp"
#include "io/base/file.hpp"
#include "nurec_sensorsim.grpc.pb.h"
#include "sensorsim.grpc.pb.h"

namespace simuli::serve {
namespace {

using NreService = ::nre::grpc::protos::sensorsim::SensorsimService;
using NurecService = ::nurec::grpc::protos::sensorsim::SensorsimService;
using grpc::ServerContext;
using grpc::Status;

constexpr int kMostStreams = 64;      // of a connection, at once
constexpr int kWaitingThreads = 128;  // of requests that wait for a worker
constexpr const char* kLidarKey = "x-simuli-lidar";

Call call_of(const ServerContext& context) {
  Call call{[&context] { return context.IsCancelled(); }};
  const auto found = context.client_metadata().find(kLidarKey);
  if (found != context.client_metadata().end()) {
    call.lidar = std::string(found->second.data(), found->second.size());
  }
  return call;
}

/// The service under one of its names.
template <class Base>
class Sensorsim final : public Base::Service {
 public:
  Sensorsim(const Handlers& handlers, const Turns& workers) : handlers_(handlers), workers_(workers) {}

  Status get_version(ServerContext* /*c*/,
                     const proto_common::Empty* /*q*/,
                     proto_common::VersionId* r) override {
    return told([&] { handlers_.get_version(*r); });
  }
  Status get_available_scenes(ServerContext* /*c*/,
                              const proto_common::Empty* /*q*/,
                              proto_common::AvailableScenesReturn* r) override {
    return told([&] { handlers_.get_available_scenes(*r); });
  }
  Status get_loaded_scenes(ServerContext* /*c*/,
                           const proto_common::Empty* /*q*/,
                           proto::LoadedScenesReturn* r) override {
    return told([&] { handlers_.get_loaded_scenes(*r); });
  }
  Status get_available_ego_masks(ServerContext* /*c*/,
                                 const proto_common::Empty* /*q*/,
                                 proto::AvailableEgoMasksReturn* r) override {
    return told([&] { handlers_.get_available_ego_masks(*r); });
  }
  Status get_available_cameras(ServerContext* c,
                               const proto::AvailableCamerasRequest* q,
                               proto::AvailableCamerasReturn* r) override {
    return worked(c, [&](const Call& call) { handlers_.get_available_cameras(call, *q, *r); });
  }
  Status get_available_trajectories(ServerContext* c,
                                    const proto::AvailableTrajectoriesRequest* q,
                                    proto::AvailableTrajectoriesReturn* r) override {
    return worked(c, [&](const Call& call) { handlers_.get_available_trajectories(call, *q, *r); });
  }
  Status get_dynamic_objects(ServerContext* c,
                             const proto::AvailableDynamicObjectsRequest* q,
                             proto::AvailableDynamicObjectsReturn* r) override {
    return worked(c, [&](const Call& call) { handlers_.get_dynamic_objects(call, *q, *r); });
  }
  Status render_rgb(ServerContext* c, const proto::RGBRenderRequest* q, proto::RGBRenderReturn* r) override {
    return worked(c, [&](const Call& call) { handlers_.render_rgb(call, *q, *r); });
  }
  Status batch_render_rgb(ServerContext* c,
                          const proto::BatchRGBRenderRequest* q,
                          proto::BatchRGBRenderReturn* r) override {
    return worked(c, [&](const Call& call) { handlers_.batch_render_rgb(call, *q, *r); });
  }
  Status render_lidar(ServerContext* c,
                      const proto::LidarRenderRequest* q,
                      proto::LidarRenderReturn* r) override {
    return worked(c, [&](const Call& call) { handlers_.render_lidar(call, *q, *r); });
  }
  Status render_aggregated(ServerContext* c,
                           const proto::AggregatedRenderRequest* q,
                           proto::AggregatedRenderReturn* r) override {
    return worked(c, [&](const Call& call) { handlers_.render_aggregated(call, *q, *r); });
  }

 private:
  template <class Work>
  static Status told(const Work& work) {
    try {
      work();
      return Status::OK;
    } catch (...) {
      const Refusal refusal = refusal_of(std::current_exception());
      return {static_cast<grpc::StatusCode>(refusal.kind()), refusal.what()};
    }
  }
  template <class Work>
  Status worked(const ServerContext* context, const Work& work) const {
    return told([&] {
      const Call call = call_of(*context);
      const Turns::Turn worker = workers_.take(call.is_given_up);
      need_wanted(call.is_given_up);
      work(call);
    });
  }

  const Handlers& handlers_;
  const Turns& workers_;
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

/// Errors reach who asked; on stderr the libraries' own lines would be read by nobody.
void silence_libraries() {
  gpr_set_log_function([](gpr_log_func_args* /*line*/) {});
  google::protobuf::SetLogHandler(nullptr);
}

}  // namespace

struct Server::Impl {
  Impl(const Handlers& handlers, const ServerOptions& with)
      : options(with), workers(with.max_workers), nre(handlers, workers), nurec(handlers, workers) {}

  ServerOptions options;
  Turns workers;
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
  builder.SetResourceQuota(quota);
  builder.SetMaxReceiveMessageSize(kLargestRequest);
  builder.SetMaxSendMessageSize(-1);
  builder.AddChannelArgument(GRPC_ARG_MAX_CONCURRENT_STREAMS, kMostStreams);
  builder.AddChannelArgument(GRPC_ARG_ALLOW_REUSEPORT, 0);  // else a second server takes half of the calls
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

void Server::drain(std::chrono::milliseconds patience) {
  if (!impl_->server) return;
  impl_->set_serving(false);
  impl_->server->Shutdown(std::chrono::system_clock::now() + patience);
  impl_->server->Wait();
  impl_->server.reset();
}

}  // namespace simuli::serve
