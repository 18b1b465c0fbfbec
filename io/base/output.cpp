#include "io/base/output.hpp"

#include <array>
#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/base/temporary.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kWritable = "a path that can be written";

std::string text_in(int descriptor) {
  std::array<char, 32> text{};
  const ssize_t got = ::pread(descriptor, text.data(), text.size(), 0);
  return {text.data(), static_cast<std::size_t>(got > 0 ? got : 0)};
}

/// Whether the name still refers to the open file, because the previous owner of the lock removes it.
bool is_at(const fs::path& path, int descriptor) {
  struct stat named {
  }, open{};
  return ::stat(path.c_str(), &named) == 0 && ::fstat(descriptor, &open) == 0 &&
         named.st_ino == open.st_ino && named.st_dev == open.st_dev;
}

/// Returns the folder, or the target of a link to a folder.
fs::path target_of(const fs::path& folder) {
  const fs::path path = without_trailing_slash(folder);
  std::error_code failed;
  if (!fs::is_symlink(path, failed)) return path;
  fs::path target = fs::canonical(path, failed);
  if (failed) throw_input_error(folder.string(), "folder", "a link that leads nowhere", kWritable);
  return target;
}

}  // namespace

fs::path lock_beside(const fs::path& output) {
  const fs::path path = without_trailing_slash(output);
  return parent_of(path) / fmt::format(".{}.lock", path.filename().string());
}

OutputLock::OutputLock(const fs::path& output) {
  const fs::path path = target_of(output);
  if (path.filename().empty() || path.filename() == "." || path.filename() == "..") {
    throw_input_error(output.string(), "folder", "a path without a name of its own", "one that has one");
  }
  std::error_code failed;
  fs::create_directories(parent_of(path), failed);
  if (failed) throw_input_error(output.string(), "folder", failed.message(), kWritable);
  file_ = lock_beside(path);
  for (;;) {
    constexpr mode_t kAll = 0666;
    Descriptor lock(::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, kAll));
    if (lock.get() < 0) throw_errno(output, "folder", kWritable);
    if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
      const std::string process = text_in(lock.get());
      const std::string who = process.empty() ? "another process that makes it"
                                              : fmt::format("process {}, which makes it", process);
      throw OutputTaken(ErrorKind::kInput,
                        fmt::format("{}: folder: found {}, allowed one at a time", output.string(), who));
    }
    // Some file systems do not support flock(); then there is no mutual exclusion.
    if (!is_at(file_, lock.get())) continue;
    const std::string process = fmt::format("{}", ::getpid());
    const bool written =
        ::ftruncate(lock.get(), 0) == 0 &&
        ::pwrite(lock.get(), process.data(), process.size(), 0) == static_cast<ssize_t>(process.size());
    if (!written) {
      const int why = errno;
      ::unlink(file_.c_str());
      errno = why;
      throw_errno(output, "folder", kWritable);
    }
    descriptor_ = lock.release();
    break;
  }
  remove_at_end(file_);
}

OutputLock::~OutputLock() {
  std::error_code ignored;  // the lock is released with the descriptor
  fs::remove(file_, ignored);
  keep_at_end(file_);
  if (descriptor_ >= 0) ::close(descriptor_);
}

void need_writable(const fs::path& file) {
  std::error_code status;
  if (!file.has_filename() || fs::is_directory(file, status)) {
    throw_input_error(file.string(), "file", "a folder", "the name of a file");
  }
  if (!fs::is_directory(parent_of(file), status)) {
    throw_input_error(file.string(), "folder", "no folder " + parent_of(file).string(), "an existing folder");
  }
  need_regular_file(file);
  for (const char* index : {"log.json", "scene.json"}) {
    if (ending_of(file) == ".html" || !is_there(file) || !is_there(parent_of(file) / index)) continue;
    throw_input_error(file.string(),
                      "file",
                      fmt::format("one in a folder with {}, which may need it", index),
                      "a new path, or elsewhere");
  }
  const Temporary temporary(file);
  const Descriptor made(::open(temporary.path().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
  if (made.get() < 0) throw_errno(file, "file", kWritable);
}

void need_new_path(const fs::path& output) {
  struct stat there {};
  if (::lstat(without_trailing_slash(output).c_str(), &there) == 0) {
    throw_input_error(output.string(), "folder", "something of that name", "a path that does not exist yet");
  }
  if (errno != ENOENT) throw_errno(output, "folder", kWritable);
}

void need_replaceable(const fs::path& folder, const std::function<bool(const std::string&)>& is_own) {
  const fs::path target = target_of(folder);
  std::error_code failed;
  const fs::file_status status = fs::status(target, failed);
  if (status.type() == fs::file_type::not_found) return;
  if (!fs::is_directory(status)) {
    throw_input_error(folder.string(), "folder", "something else of that name", "a folder, or a new path");
  }
  for (fs::directory_iterator at(target, failed), end; !failed && at != end; at.increment(failed)) {
    const std::string name = at->path().filename().string();
    if (is_own(name) || is_temporary(name)) continue;
    throw_input_error(folder.string(),
                      "folder",
                      '"' + name + "\" in it",
                      "a folder with nothing of others, or a path that does not exist yet");
  }
  if (failed) throw_input_error(folder.string(), "folder", failed.message(), "a folder that can be read");
}

void replace_folder_atomically(const fs::path& folder,
                               const std::function<bool(const std::string&)>& is_own,
                               const std::function<void(const fs::path&)>& write) {
  need_replaceable(folder, is_own);
  const fs::path target = target_of(folder);
  std::error_code failed;
  if (!fs::exists(target, failed)) {
    write_folder_atomically(target, write);
    return;
  }
  remove_stale_temporaries(target);
  Temporary temporary(target);
  if (!fs::create_directory(temporary.path(), failed)) {
    throw_input_error(folder.string(), "folder", failed.message(), kWritable);
  }
  fs::permissions(temporary.path(), fs::status(target).permissions(), failed);
  temporary.fill(write);
  temporary.take_targets_place();
}

}  // namespace simuli
