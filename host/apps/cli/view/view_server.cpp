#include "host/apps/cli/view/view_server.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <exception>
#include <fmt/format.h>
#include <functional>
#include <httplib.h>
#include <string_view>

#include "host/apps/cli/view/guarded_server.hpp"
#include "host/apps/cli/view/loopback.hpp"
#include "host/core/base/error.hpp"
#include "host/core/base/one_line.hpp"
#include "host/device/runtime/source.hpp"

namespace simuli::cli {
std::span<const EmbeddedFile> page_files();  // of page/, embedded by the build
namespace {

constexpr std::size_t kLargestRequest = std::size_t{1} << 20U;
constexpr std::size_t kLargestFile = std::size_t{60} << 20U;  // of splats

/// Whether a page of another site sent the request, by the browser's headers. Such a page cannot read the
/// reply, but would start the work.
bool is_foreign(const httplib::Request& request) {
  const std::string site = request.get_header_value("Sec-Fetch-Site");
  if (!site.empty() && site != "same-origin" && site != "none") return true;
  if (!request.has_header("Origin")) return false;  // not a browser, or direct navigation
  const std::string origin = request.get_header_value("Origin");
  const std::size_t scheme = origin.find("://");
  return scheme == std::string::npos || origin.substr(scheme + 3) != request.get_header_value("Host");
}

/// Escapes text for the query of an address.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool is_plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') ||
                          std::string_view("-._~").find(c) != std::string_view::npos;
    out += is_plain ? std::string(1, c) : fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return out;
}

/// Compares in constant time, so that timing does not reveal matching characters.
bool same(const std::string& a, const std::string& b) {
  unsigned different = a.size() == b.size() ? 0 : 1;
  for (std::size_t i = 0; i < a.size(); ++i) {
    different |= static_cast<unsigned char>(a[i]) ^
                 static_cast<unsigned char>(b[i % std::max<std::size_t>(b.size(), 1)]);
  }
  return different == 0;
}

double seconds_of(const std::string& text) {
  double seconds = 0.0;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (read.ec != std::errc{} || read.ptr != text.data() + text.size() || !std::isfinite(seconds)) {
    throw_input_error("request", "time_s", '"' + text + '"', "a finite number");
  }
  return seconds;
}

std::string type_of(std::string_view path) {
  if (path.ends_with(".js")) return "text/javascript";
  return path.ends_with(".css") ? "text/css" : "text/html";
}

}  // namespace

struct ViewServer::Impl {
  ServerOptions options;
  GuardedServer server;  // destroyed before the objects that it uses
};

ViewServer::ViewServer(ViewAnswers& answers, const ServerOptions& options) : impl_(std::make_unique<Impl>()) {
  const bool loopback = is_loopback(options.host);
  if (!loopback && options.token.empty()) {
    throw Error(
        ErrorKind::kUsage,
        fmt::format("--host: found {} without a token, allowed 127.0.0.1, localhost, ::1, or a token that "
                    "pages must know: --token, --token-file, $SIMULI_VIEW_TOKEN",
                    options.host));
  }
  impl_->options = options;
  GuardedServer& server = impl_->server;
  server.set_payload_max_length(kLargestFile);
  server.set_default_headers({{"Cache-Control", "no-store"},
                              {"X-Content-Type-Options", "nosniff"},
                              {"Referrer-Policy", "no-referrer"},
                              {"Cross-Origin-Resource-Policy", "same-origin"},
                              {"Content-Security-Policy",
                               "default-src 'self'; img-src 'self' blob: data:; frame-ancestors 'none'"}});
  server.set_pre_routing_handler(
      [this, loopback](const httplib::Request& request, httplib::Response& response) {
        // Prevents DNS rebinding: a page of another site could use a host name with this address.
        if (loopback && !is_loopback(host_of_header(request.get_header_value("Host")))) {
          response.status = 403;
          response.set_content("not a name of this machine", "text/plain");
          return httplib::Server::HandlerResponse::Handled;
        }
        const bool is_api = request.path.rfind("/api/", 0) == 0;
        if (is_api && is_foreign(request)) {
          response.status = 403;
          response.set_content("origin: found another site's page, allowed this one's", "text/plain");
          return httplib::Server::HandlerResponse::Handled;
        }
        if (is_api && !impl_->options.token.empty() &&
            !same(request.get_header_value("X-Simuli-Token"), impl_->options.token)) {
          response.status = 401;
          response.set_content(
              "token: found another one, allowed that of --token (?token=... behind the page's address)",
              "text/plain");
          return httplib::Server::HandlerResponse::Handled;
        }
        return httplib::Server::HandlerResponse::Unhandled;
      });
  for (const EmbeddedFile& file : page_files()) {
    const auto serve = [file](const httplib::Request&, httplib::Response& response) {
      response.set_content(std::string(file.text), type_of(file.path));
    };
    server.Get(fmt::format("/{}", file.path), serve);
    if (file.path == "index.html") server.Get("/", serve);
  }
  // Errors are returned to the page as one line.
  const auto answer = [](const char* type, const std::function<std::string(const httplib::Request&)>& work) {
    return [type, work](const httplib::Request& request, httplib::Response& response) {
      try {
        response.set_content(work(request), type);
      } catch (const std::exception& error) {
        response.status = 400;
        response.set_content(on_one_line(error.what()), "text/plain");
      }
    };
  };
  server.Get("/api/scene",
             answer("application/json", [&](const httplib::Request&) { return answers.describe(); }));
  server.Get("/api/status",
             answer("application/json", [&](const httplib::Request&) { return answers.progress(); }));
  using Post = std::function<std::string(const httplib::Request&, const std::string& body)>;
  const auto post = [&](const char* path, const char* type, std::size_t most_bytes, const Post& work) {
    server.Post(
        path,
        [type, most_bytes, work, answer](const httplib::Request& request,
                                         httplib::Response& response,
                                         const httplib::ContentReader& read) {
          std::string body;
          std::size_t bytes = 0;
          const bool is_whole = read([&](const char* data, std::size_t size) {
            bytes += size;  // bytes beyond the limit are read, but not stored
            if (bytes <= most_bytes) body.append(data, size);
            return true;
          });
          if (!is_whole || bytes > most_bytes) {
            response.status = 413;
            response.set_content(
                fmt::format(
                    "body: found a part, or more than {} bytes, allowed a whole one of at most that many",
                    most_bytes),
                "text/plain");
            return;
          }
          answer(type, [&](const httplib::Request& r) { return work(r, body); })(request, response);
        });
  };
  const char* const parts = "application/octet-stream";
  post("/api/picture", parts, kLargestRequest, [&](const httplib::Request&, const std::string& body) {
    return answers.picture(parse_view_request(body));
  });
  post("/api/sweep", parts, kLargestRequest, [&](const httplib::Request&, const std::string& body) {
    return answers.sweep(parse_view_request(body));
  });
  const char* const json = "application/json";
  post("/api/probe", json, kLargestRequest, [&](const httplib::Request&, const std::string& body) {
    return answers.probe(parse_view_request(body));
  });
  post("/api/duplicate", json, kLargestRequest, [&](const httplib::Request&, const std::string& body) {
    return answers.duplicate(body);
  });
  post("/api/command", json, kLargestRequest, [&](const httplib::Request&, const std::string& body) {
    return answers.command(parse_view_request(body));
  });
  post("/api/add", json, kLargestFile, [&](const httplib::Request& request, const std::string& body) {
    return answers.add(request.get_param_value("file"), body, seconds_of(request.get_param_value("time_s")));
  });
  server.start(options.host, options.port, "--port");
}

ViewServer::~ViewServer() = default;

std::string ViewServer::url() const {
  const std::string& token = impl_->options.token;
  return fmt::format("{}/{}", impl_->server.url(), token.empty() ? "" : "?token=" + escaped(token));
}

void ViewServer::wait() { impl_->server.wait(); }

}  // namespace simuli::cli
