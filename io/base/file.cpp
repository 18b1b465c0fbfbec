#include "io/base/file.hpp"

#include <cerrno>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>

#include "host/core/base/error.hpp"
#include "host/core/base/split.hpp"
#include "io/base/temporary.hpp"

namespace simuli {

namespace fs = std::filesystem;

namespace {

void need_regular(const fs::path& file, mode_t mode) {
  if (S_ISREG(mode)) return;
  const char* const found = S_ISDIR(mode) ? "a folder" : S_ISFIFO(mode) ? "a pipe" : "a device";
  throw_input_error(file.string(), "file", found, "a file");
}

}  // namespace

bool is_there(const fs::path& path) {
  std::error_code failed;
  return fs::exists(fs::symlink_status(path, failed));
}

std::string ending_of(const fs::path& file) { return lower(file.extension().string()); }

void need_regular_file(const fs::path& file) {
  struct stat info {};
  if (::stat(file.c_str(), &info) == 0) need_regular(file, info.st_mode);
}

std::string read_file(const fs::path& file, std::size_t max_bytes) {
  // O_NONBLOCK: opening a pipe without a writer would block.
  const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (descriptor.get() < 0) throw_errno(file, "file", "a readable file");
  struct stat info {};
  if (::fstat(descriptor.get(), &info) != 0) throw_errno(file, "file", "a readable file");
  need_regular(file, info.st_mode);
  const auto size = static_cast<std::size_t>(info.st_size);
  if (size > max_bytes) {
    throw_input_error(
        file.string(), "size", fmt::format("{} bytes", size), fmt::format("at most {} bytes", max_bytes));
  }
  std::string bytes(size, '\0');
  std::size_t done = 0;
  while (done < size) {
    const ssize_t got = ::read(descriptor.get(), bytes.data() + done, size - done);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw_errno(file, "content", "a readable file");
    if (got == 0) {
      throw_input_error(file.string(), "size", fmt::format("{} bytes", done), fmt::format("{} bytes", size));
    }
    done += static_cast<std::size_t>(got);
  }
  return bytes;
}

void write_file_atomically(const fs::path& file, const std::string& bytes) {
  write_atomically(file, [&](const fs::path& temporary) {
    Descriptor descriptor(::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (descriptor.get() < 0) throw_errno(file, "file", "a path that can be written");
    std::size_t done = 0;
    while (done < bytes.size()) {
      const ssize_t put = ::write(descriptor.get(), bytes.data() + done, bytes.size() - done);
      if (put < 0 && errno == EINTR) continue;
      if (put < 0) throw_errno(file, "content", "a path that can be written");
      done += static_cast<std::size_t>(put);
    }
    if (descriptor.close() != 0) throw_errno(file, "content", "a path that can be written");
  });
}

void write_atomically(const fs::path& file, const std::function<void(const fs::path&)>& write) {
  std::error_code status;
  if (!file.has_filename() || fs::is_directory(file, status)) {
    throw_input_error(file.string(), "file", "a folder", "the name of a file");
  }
  if (!fs::is_directory(parent_of(file), status)) {
    throw_input_error(file.string(), "folder", "no folder " + parent_of(file).string(), "an existing folder");
  }
  need_regular_file(file);  // a rename would replace a device by a file
  Temporary temporary(file);
  temporary.fill(write);
  temporary.become_target();
}

void write_folder_atomically(const fs::path& folder, const std::function<void(const fs::path&)>& write) {
  const fs::path target = without_trailing_slash(folder);
  std::error_code status;
  if (target.empty() || fs::symlink_status(target, status).type() != fs::file_type::not_found) {
    throw_input_error(folder.string(), "folder", "something of that name", "a path that does not exist yet");
  }
  remove_stale_temporaries(target);
  Temporary temporary(target);
  if (!fs::create_directories(temporary.path(), status) || status) {
    throw_input_error(folder.string(),
                      "folder",
                      status ? status.message() : "its temporary folder in use",
                      "a path that can be written");
  }
  temporary.fill(write);
  temporary.become_target();
}

}  // namespace simuli
