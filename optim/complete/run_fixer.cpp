#include "optim/complete/run_fixer.hpp"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fmt/format.h>
#include <set>
#include <spawn.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>

#include "host/core/base/error.hpp"
#include "host/core/base/interruption.hpp"
#include "io/base/file.hpp"
#include "io/base/temporary.hpp"
#include "io/log/log_json.hpp"
#include "io/log/sensor_json.hpp"
#include "io/picture/sized_image.hpp"

extern char** environ;

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "simuli fixer";
constexpr int kVersion = 1;

[[noreturn]] void refuse(const std::string& command,
                         const std::string& field,
                         const std::string& found,
                         const std::string& allowed) {
  throw_input_error("fixer " + command, field, found, allowed);
}

void write_views(const fs::path& folder, const std::vector<FixerView>& views, int iteration) {
  Json list = Json::array();
  for (const FixerView& view : views) {
    write_image(folder / (view.name + ".png"), view.rendered);
    write_image(folder / (view.name + "_support.png"), view.support);
    write_image(folder / (view.name + "_recorded.png"), view.recorded);
    list.push_back({{"name", view.name},
                    {"picture", view.name + ".png"},
                    {"support", view.name + "_support.png"},
                    {"recorded", view.name + "_recorded.png"},
                    {"time_s", view.time_s},
                    {"left_m", view.left_m},
                    {"world_from_camera", to_json(view.world_from_camera)},
                    {"camera", to_json(view.camera)}});
  }
  const Json root{
      {"format", kFormat}, {"version", kVersion}, {"iteration", iteration}, {"views", std::move(list)}};
  write_file_atomically(folder / "views.json", root.dump(1) + '\n');
}

/// The program and its child processes. Its output goes to stderr, because stdout may be JSON.
class ProcessGroup {
 public:
  ProcessGroup(const std::string& command, char* const* arguments) {
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_adddup2(&files, STDERR_FILENO, STDOUT_FILENO);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
    posix_spawnattr_setpgroup(&attributes, 0);
    const int failed = posix_spawn(&leader_, "/bin/sh", &files, &attributes, arguments, environ);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    if (failed != 0) refuse(command, "program", "no shell to run it", "/bin/sh");
    kill_at_end(leader_);
  }
  ProcessGroup(const ProcessGroup&) = delete;
  ProcessGroup& operator=(const ProcessGroup&) = delete;
  ~ProcessGroup() { spare_at_end(leader_); }

  /// Waits for the program and returns its status as waitpid() does. Throws Error{kInput} when the system has
  /// none: the process ignores SIGCHLD, or another thread waited for the program. Kills the group when
  /// Interruption::ask() throws.
  [[nodiscard]] int wait(const std::string& command) const {
    constexpr std::chrono::milliseconds kLookAgain{20};
    int status = 0;
    try {
      for (;;) {
        const pid_t ended = ::waitpid(leader_, &status, WNOHANG);
        if (ended == leader_) return status;
        if (ended < 0 && errno != EINTR) break;
        Interruption::ask();
        std::this_thread::sleep_for(kLookAgain);
      }
    } catch (...) {
      ::kill(-leader_, SIGKILL);
      ::waitpid(leader_, &status, 0);
      throw;
    }
    refuse(command,
           "end",
           "no exit code, as SIGCHLD is ignored or another thread has waited for the program",
           "exit code 0");
  }

 private:
  pid_t leader_ = 0;
};

void run(const std::string& command, const fs::path& in, const fs::path& out) {
  std::array<std::string, 6> words{"sh", "-c", command + " \"$@\"", "fixer", in.string(), out.string()};
  std::array<char*, 7> arguments{};
  std::transform(
      words.begin(), words.end(), arguments.begin(), [](std::string& word) { return word.data(); });
  const ProcessGroup group(command, arguments.data());
  const int status = group.wait(command);
  if (WIFSIGNALED(status)) refuse(command, "end", fmt::format("signal {}", WTERMSIG(status)), "exit code 0");
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    refuse(command, "end", fmt::format("exit code {}", WEXITSTATUS(status)), "exit code 0");
  }
}

std::vector<Image> read_views(const std::string& command,
                              const fs::path& folder,
                              const std::vector<FixerView>& views) {
  std::set<std::string> left, missing;
  std::error_code failed;  // the program may have removed its folder
  for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed))
    left.insert(at->path().filename().string());
  for (const FixerView& view : views) {
    if (left.erase(view.name + ".png") == 0) missing.insert(view.name + ".png");
  }
  if (!missing.empty()) {
    refuse(command,
           "files",
           fmt::format("no {}", *missing.begin()),
           fmt::format("{} pictures, named as those it was given", views.size()));
  }
  if (!left.empty()) refuse(command, "files", *left.begin(), "pictures named as those it was given alone");
  std::vector<Image> images;
  for (const FixerView& view : views) {
    const std::string name = view.name + ".png";
    images.push_back(with_context("reading what fixer " + command + " wrote", [&] {
      return read_image(folder / name, view.camera.width, view.camera.height, "the one it was given");
    }));
  }
  return images;
}

}  // namespace

std::vector<Image> run_fixer(const std::string& command, const std::vector<FixerView>& views, int iteration) {
  const ScratchFolder scratch("simuli_fixer");
  const fs::path in = scratch.path() / "in", out = scratch.path() / "out";
  fs::create_directory(in);
  fs::create_directory(out);
  write_views(in, views, iteration);
  run(command, in, out);
  return read_views(command, out, views);
}

}  // namespace simuli
