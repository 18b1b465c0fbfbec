#pragma once
// A browser without a window, for pages that are to be tried.
#include <Eigen/Core>  // before the macros of the HTTP library
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <httplib.h>
#include <netdb.h>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

namespace simuli::test {

/// Why there is no browser; empty: there is one.
inline std::string missing_browser() {
  if (std::system("command -v chromedriver >/dev/null 2>&1") != 0) {
    return "chromedriver (Debian: chromium-driver) is not installed";
  }
  addrinfo* found = nullptr;  // by this name chromedriver calls its browser
  if (getaddrinfo("localhost", nullptr, nullptr, &found) != 0) {
    return "localhost is no known name (/etc/hosts)";
  }
  freeaddrinfo(found);
  return {};
}

/// A browser driven over the WebDriver protocol.
class Browser {
 public:
  Browser(int driver_port, const std::filesystem::path& profile) : http_("127.0.0.1", driver_port) {
    http_.set_read_timeout(120);
    const nlohmann::json args = {"--headless=new",
                                 "--no-sandbox",
                                 "--disable-dev-shm-usage",
                                 "--use-angle=swiftshader",
                                 "--enable-unsafe-swiftshader",
                                 "--window-size=1200,800",
                                 "--user-data-dir=" + profile.string()};
    const nlohmann::json wanted = {{"browserName", "chrome"},
                                   {"goog:chromeOptions", {{"args", args}}},
                                   {"goog:loggingPrefs", {{"browser", "ALL"}}}};
    const nlohmann::json made = call("", {{"capabilities", {{"alwaysMatch", wanted}}}});
    session_ = made.value("sessionId", "");
  }
  ~Browser() {
    if (!session_.empty()) http_.Delete("/session/" + session_);
  }
  [[nodiscard]] bool is_open() const { return !session_.empty(); }
  void open(const std::string& url) { call("/url", {{"url", url}}); }
  nlohmann::json evaluate(const std::string& script) {
    return call("/execute/sync", {{"script", script}, {"args", nlohmann::json::array()}});
  }
  /// Tries for a minute.
  bool wait_for(const std::string& condition) {
    for (int tries = 0; tries < 300; ++tries) {
      if (evaluate("return Boolean(" + condition + ")") == true) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    return false;
  }
  void drag(int x, int y, int dx, int dy, int rest_ms = 0) {
    const auto move = [](int to_x, int to_y) {
      return nlohmann::json{{"type", "pointerMove"}, {"duration", 100}, {"x", to_x}, {"y", to_y}};
    };
    const nlohmann::json steps = {move(x, y),
                                  {{"type", "pointerDown"}, {"button", 0}},
                                  move(x + dx / 2, y + dy / 2),
                                  {{"type", "pause"}, {"duration", rest_ms}},
                                  move(x + dx, y + dy),
                                  {{"type", "pointerUp"}, {"button", 0}}};
    const nlohmann::json pointer = {
        {"type", "pointer"}, {"id", "mouse"}, {"parameters", {{"pointerType", "mouse"}}}, {"actions", steps}};
    call("/actions", {{"actions", {pointer}}});
  }
  /// Of the DevTools protocol.
  void command(const char* name, const nlohmann::json& params) {
    call("/goog/cdp/execute", {{"cmd", name}, {"params", params}});
  }
  /// The page itself, whatever windows may be.
  bool resize_to(int width, int height) {
    command("Emulation.setDeviceMetricsOverride",
            {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
    return evaluate("return innerWidth") == width;
  }
  nlohmann::json console() { return call("/se/log", {{"type", "browser"}}); }

 private:
  nlohmann::json call(const std::string& path, const nlohmann::json& body) {
    const std::string at = session_.empty() ? "/session" : "/session/" + session_ + path;
    const httplib::Result result = http_.Post(at, body.dump(), "application/nlohmann::json");
    if (!result) return nlohmann::json::object();
    return nlohmann::json::parse(result->body).value("value", nlohmann::json());
  }
  httplib::Client http_;
  std::string session_;
};

}  // namespace simuli::test
