// Command serve of a build without gRPC.
#include "host/apps/cli/base/commands.hpp"
#include "host/core/base/error.hpp"

namespace simuli::cli {

void add_serve(Command app, const Globals& /*globals*/) {
  const Command command = app.command("serve", "render scenes for simulators by gRPC (not in this build)");
  command.take_anything();
  command.run([] {
    throw Error(ErrorKind::kUsage,
                "serve: found a build without gRPC, allowed one with -D SIMULI_SERVE=ON and libgrpc++-dev, "
                "libprotobuf-dev, protobuf-compiler, protobuf-compiler-grpc");
  });
}

}  // namespace simuli::cli
