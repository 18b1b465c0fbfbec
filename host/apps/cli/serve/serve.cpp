// Command simuli serve: renders scenes for simulators.
#include <chrono>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <iostream>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host/apps/cli/base/commands.hpp"
#include "host/apps/cli/base/interrupt.hpp"
#include "host/apps/cli/base/settings.hpp"
#include "host/apps/cli/serve/metrics_server.hpp"
#include "host/apps/cli/view/loopback.hpp"
#include "host/apps/serve/server/server.hpp"
#include "host/core/base/error.hpp"

namespace simuli::cli {
namespace {

struct ServeCommand {
  std::vector<std::string> scenes;
  serve::ServerOptions server;
  bool is_insecure = false;
  bool allows_edits = false;
  int cache_size = 4;
  int max_workers = 4;
  int metrics_port = -1;  // -1: no metrics server
  double drain_s = 60.0;
  std::string ego_masks;
  std::vector<std::string> settings;
};

void need_safe(const ServeCommand& command) {
  const std::string& host = command.server.host;
  if (is_loopback(host) || command.is_insecure || !command.server.tls_certificate.empty()) return;
  throw Error(
      ErrorKind::kUsage,
      fmt::format("--host: found {} without TLS, allowed 127.0.0.1, localhost, ::1, or --tls-cert and "
                  "--tls-key, or --insecure",
                  host));
}

/// glibc creates an arena for each of many threads, and cached rays fragment the arenas; two arenas keep the
/// memory small.
void allocate_from_few_arenas() {
#ifdef __GLIBC__
  static_cast<void>(mallopt(M_ARENA_MAX, 2));
#endif
}

void serve_scenes(const ServeCommand& command, const Globals& globals) {
  allocate_from_few_arenas();
  need_safe(command);
  serve::SessionOptions of_session;
  of_session.scenes = serve::scene_sources(command.scenes);
  of_session.devices = devices_of(globals.device);
  of_session.render = options_of(globals.quality);
  fields_of(of_session.render).apply(command.settings);
  of_session.note = [](const std::string& text) { std::cerr << "simuli: note: " + text + '\n'; };
  of_session.cache_size = static_cast<std::size_t>(command.cache_size);
  const serve::EgoMasks ego_masks =
      command.ego_masks.empty() ? serve::EgoMasks() : serve::EgoMasks(command.ego_masks);
  serve::RenderSession session(of_session);
  // Reads as many scenes as fit in memory before the address is printed, so that read errors end the program
  // here.
  const std::size_t first = std::min(session.sources().size(), session.cache_size());
  for (std::size_t i = first; i-- > 0;) session.read_now(session.sources()[i].id);
  serve::HandlerOptions of_handlers;
  of_handlers.allows_edits = command.allows_edits;
  of_handlers.reported = {{"max-workers", fmt::format("{}", command.max_workers)},
                          {"egocar-hood-dir", command.ego_masks},
                          {"set", fmt::format("{}", fmt::join(command.settings, " "))}};
  const serve::Handlers handlers(session, ego_masks, globals.commit, of_handlers);
  serve::ServerOptions of_server = command.server;
  of_server.max_workers = static_cast<std::size_t>(command.max_workers);
  const InterruptionPoint interruption("running requests are finished; a second signal ends the server");
  serve::Server server(handlers, of_server);
  std::optional<MetricsServer> metrics;
  if (command.metrics_port >= 0) {
    // HTTP is unencrypted: the network requires --insecure, and TLS restricts metrics to loopback.
    const std::string& host = command.server.host;
    const bool is_plain = command.is_insecure && command.server.tls_certificate.empty();
    metrics.emplace(is_loopback(host) || is_plain ? host : "127.0.0.1", command.metrics_port, [&server] {
      return server.metrics();
    });
  }
  std::cout << server.address() << std::endl;  // flushed, because callers wait for the address
  if (metrics) std::cout << metrics->url() << std::endl;
  constexpr std::chrono::milliseconds kPollInterval{50};
  while (!interruption.is_requested_for() && !server.is_shut_down_requested())
    std::this_thread::sleep_for(kPollInterval);
  server.drain(std::chrono::milliseconds(static_cast<std::int64_t>(command.drain_s * 1e3)));
}

}  // namespace

void add_serve(Command app, const Globals& globals) {
  const auto command = std::make_shared<ServeCommand>();
  Command sub = app.command("serve", "render scenes for simulators by gRPC, until Ctrl-C or SIGTERM");
  sub.option("SCENE",
             command->scenes,
             "scene folders or splats, or ID=PATH for another ID than the folder's name")
      .required();
  sub.option("--host",
             command->server.host,
             "address to listen on; addresses other than loopback need TLS or --insecure")
      .with_default();
  sub.option("--port", command->server.port, "port; 0: any free port").range(0, 65535).with_default();
  sub.option("--cache-size", command->cache_size, "maximum number of scenes in memory")
      .range(1, 10000)
      .with_default();
  sub.option("--max-workers", command->max_workers, "maximum number of concurrent requests; others wait")
      .range(1, 1000)
      .with_default();
  sub.option("--metrics-port",
             command->metrics_port,
             "counts and latencies for Prometheus, by HTTP under /metrics; 0: any free port; on loopback, or "
             "with --insecure on --host")
      .range(0, 65535);
  sub.option("--egocar-hood-dir",
             command->ego_masks,
             "pictures of the ego vehicle with alpha: RIG/CAMERA.png, drawn over renders on request");
  sub.flag("--enable-editing-actors",
           command->allows_edits,
           "clients may replace and insert actors for all clients with edit_assets");
  sub.flag(
      "--allow-shut-down", command->server.allows_shut_down, "clients may end the server with shut_down");
  sub.option("--drain", command->drain_s, "time in s to finish requests after a signal")
      .range(0.0, 3600.0)
      .with_default();
  sub.option("--tls-cert", command->server.tls_certificate, "PEM file, with --tls-key");
  sub.option("--tls-key", command->server.tls_key, "PEM file");
  sub.option(
      "--tls-clients", command->server.tls_clients, "PEM file of the authorities of clients' certificates");
  sub.flag("--insecure", command->is_insecure, "allow a --host other than loopback without TLS");
  const auto options = std::make_shared<RenderOptions>();
  const auto fields = [options, &globals] {
    *options = options_of(globals.quality);
    return fields_of(*options);
  };
  add_settings(sub, command->settings, globals, fields, "KEY=VALUE...; help: lists the keys");
  sub.run([command, &globals] { serve_scenes(*command, globals); });
}

}  // namespace simuli::cli
