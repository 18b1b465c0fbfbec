#pragma once
// A client of a server on loopback.
#include <grpcpp/generic/generic_stub.h>
#include <grpcpp/grpcpp.h>
#include <gtest/gtest.h>
#include <memory>
#include <string>

#include "nurec_sensorsim.grpc.pb.h"
#include "sensorsim.grpc.pb.h"

namespace simuli::test {

using NreService = ::nre::grpc::protos::sensorsim::SensorsimService;
using NurecService = ::nurec::grpc::protos::sensorsim::SensorsimService;

inline std::shared_ptr<grpc::Channel> channel_to(const std::string& address) {
  grpc::ChannelArguments arguments;
  arguments.SetMaxReceiveMessageSize(-1);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);  // a connection of its own
  return grpc::CreateCustomChannel(address, grpc::InsecureChannelCredentials(), arguments);
}

/// What grpc.health.v1 says of a service: 1 where it serves, 2 where it doesn't; -1 and less: an error's
/// code.
inline int health_of(const std::shared_ptr<grpc::Channel>& channel, const std::string& service) {
  using Number = ::nre::grpc::protos::common::VersionId::APIVersion;     // {uint32 1}
  using Text = ::nre::grpc::protos::sensorsim::AvailableCamerasRequest;  // {string 1}
  grpc::TemplatedGenericStub<Text, Number> stub(channel);
  grpc::ClientContext context;
  grpc::CompletionQueue queue;
  Text request;
  request.set_scene_id(service);
  Number reply;
  grpc::Status status;
  const auto call = stub.PrepareUnaryCall(&context, "/grpc.health.v1.Health/Check", request, &queue);
  call->StartCall();
  call->Finish(&reply, &status, nullptr);
  void* tag = nullptr;
  bool is_ok = false;
  queue.Next(&tag, &is_ok);
  return status.ok() ? static_cast<int>(reply.major()) : -static_cast<int>(status.error_code());
}

}  // namespace simuli::test
