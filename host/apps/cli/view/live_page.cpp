#include "host/apps/cli/view/live_page.hpp"

#include <utility>

#include "host/apps/cli/view/view_server.hpp"
#include "host/apps/cli/view/view_session.hpp"

namespace simuli::cli {
namespace {

ServerOptions on_port(int port) {
  ServerOptions options;
  options.port = port;
  return options;
}

class ServedPage : public LivePage {
 public:
  ServedPage(const Globals& globals, SceneFile file, int port)
      : session_(globals, std::move(file)), server_(session_, on_port(port)) {}

  [[nodiscard]] std::string url() const override { return server_.url(); }
  void show(Scene scene) override { session_.show(std::move(scene)); }
  void set_progress(const ViewProgress& progress) override { session_.set_progress(progress); }
  [[nodiscard]] double idle_s() const override { return session_.idle_s(); }

 private:
  ViewSession session_;
  ViewServer server_;
};

}  // namespace

std::unique_ptr<LivePage> open_live_page(const Globals& globals, SceneFile file, int port) {
  return std::make_unique<ServedPage>(globals, std::move(file), port);
}

}  // namespace simuli::cli
