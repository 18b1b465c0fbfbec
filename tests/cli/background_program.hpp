#pragma once
// A program that runs beside a test: its output so far, and its end.
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace simuli::test {

class BackgroundProgram {
 public:
  /// Standard output and error go to `log`.
  BackgroundProgram(std::vector<std::string> arguments, std::filesystem::path log) : log_(std::move(log)) {
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    std::filesystem::remove(log_);  // of an earlier program: what is read is this one's
    pid_ = ::fork();
    if (pid_ != 0) return;
    const int file = ::open(log_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    ::dup2(file, STDOUT_FILENO);
    ::dup2(file, STDERR_FILENO);
    ::execvp(argv[0], argv.data());
    ::_exit(127);
  }
  ~BackgroundProgram() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGTERM);
    ::kill(pid_, SIGTERM);  // twice: a training takes the first one as a wish
    ::waitpid(pid_, nullptr, 0);
  }
  BackgroundProgram(const BackgroundProgram&) = delete;
  BackgroundProgram& operator=(const BackgroundProgram&) = delete;

  [[nodiscard]] pid_t process() const { return pid_; }
  /// Sends a signal and waits for the end: the exit code, minus the signal that ended it, or -1 where
  /// the system has no exit code.
  int end_by(int signal) {
    ::kill(pid_, signal);
    int status = 0;
    if (::waitpid(std::exchange(pid_, -1), &status, 0) < 0) return -1;
    return WIFSIGNALED(status) ? -WTERMSIG(status) : WEXITSTATUS(status);
  }

  [[nodiscard]] std::string output() const {
    std::ifstream file(log_);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// The number behind `mark` in the output, once a character that is no digit stands behind it; -1 when that
  /// does not come in time.
  [[nodiscard]] int disoccluded_number(const std::string& mark) const {
    for (int tries = 0; tries < 600; ++tries) {
      const std::string text = output();
      const std::size_t at = text.find(mark);
      if (at != std::string::npos) {
        const std::size_t end = text.find_first_not_of("0123456789", at + mark.size());
        if (end != std::string::npos) return std::stoi(text.substr(at + mark.size()));
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return -1;
  }

 private:
  std::filesystem::path log_;
  pid_t pid_ = -1;
};

}  // namespace simuli::test
