// Implements `simuli bench --peers` in a build without Embree.
#include "bench/peers/peers.hpp"
#include "host/core/base/error.hpp"

namespace simuli::bench {
namespace {

[[noreturn]] void throw_absent() {
  throw Error(ErrorKind::kUsage,
              "bench --peers: found a build without Embree, allowed one with: install Embree 3 (Debian 12: "
              "libembree-dev), configure and build again");
}

}  // namespace

std::vector<PeerCase> run_peers(const std::string& /*device_request*/,
                                const PeersOptions& /*options*/,
                                const std::function<void(const std::string&)>& /*note*/) {
  throw_absent();
}

RayResults traced_results(const GaussianSet& /*set*/,
                          const SensorRays& /*rays*/,
                          const View& /*view*/,
                          const RenderOptions& /*options*/) {
  throw_absent();
}

}  // namespace simuli::bench
