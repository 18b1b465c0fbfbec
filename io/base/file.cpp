#include "io/base/file.hpp"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include "host/base/error.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

/// Owner of a POSIX descriptor; close() is for writers, which must learn of a late write error.
class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  [[nodiscard]] int get() const { return descriptor_; }
  [[nodiscard]] int close() { return ::close(std::exchange(descriptor_, -1)); }

 private:
  int descriptor_;
};

[[noreturn]] void throw_errno(const fs::path& file, const char* field, const char* allowed) {
  throw_input_error(file.string(), field, std::strerror(errno), allowed);
}

/// Flushes a file or a folder's entries to the disk.
void sync_path(const fs::path& path) {
  const Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (descriptor.get() < 0) throw_errno(path, "sync", "a file that was just written");
  // EINVAL: a file system that cannot sync folders; the rename is still atomic there.
  if (::fsync(descriptor.get()) != 0 && errno != EINVAL) throw_errno(path, "sync", "a working disk");
}

fs::path parent_of(const fs::path& path) {
  const fs::path parent = path.parent_path();
  return parent.empty() ? fs::path(".") : parent;
}

/// A name beside `path` that no other process or thread uses, with the same extension.
fs::path temporary_sibling(const fs::path& path) {
  static std::atomic<unsigned> counter{0};
  return parent_of(path) /
         fmt::format(
             ".{}.{}-{}.tmp{}", path.stem().string(), ::getpid(), counter++, path.extension().string());
}

/// Removes what stands at the path, unless release() was called.
class Cleanup {
 public:
  explicit Cleanup(fs::path path) : path_(std::move(path)) {}
  Cleanup(const Cleanup&) = delete;
  Cleanup& operator=(const Cleanup&) = delete;
  ~Cleanup() {
    std::error_code ignored;  // a destructor on the way out of another error has nothing to add
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  void release() { path_.clear(); }

 private:
  fs::path path_;
};

void rename_synced(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) != 0) throw_errno(to, "rename", "a path that can be written");
  sync_path(parent_of(to));
}

/// "x/" names the same folder as "x", but has no file name of its own.
fs::path without_trailing_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

}  // namespace

std::string read_file(const fs::path& file, std::size_t max_bytes) {
  const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (descriptor.get() < 0) throw_errno(file, "file", "a readable file");
  struct stat info {};
  if (::fstat(descriptor.get(), &info) != 0) throw_errno(file, "file", "a readable file");
  if (!S_ISREG(info.st_mode)) {
    throw_input_error(file.string(), "file", S_ISDIR(info.st_mode) ? "a folder" : "a device", "a file");
  }
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
  const fs::path temporary = temporary_sibling(file);
  Cleanup cleanup(temporary);
  write(temporary);
  sync_path(temporary);
  rename_synced(temporary, file);
  cleanup.release();
}

void write_folder_atomically(const fs::path& folder, const std::function<void(const fs::path&)>& write) {
  const fs::path target = without_trailing_slash(folder);
  std::error_code status;
  if (target.empty() || fs::symlink_status(target, status).type() != fs::file_type::not_found) {
    throw_input_error(folder.string(), "folder", "something of that name", "a path that does not exist yet");
  }
  const fs::path temporary = temporary_sibling(target);
  if (!fs::create_directories(temporary, status) || status) {
    throw_input_error(folder.string(),
                      "folder",
                      status ? status.message() : "its temporary folder in use",
                      "a path that can be written");
  }
  Cleanup cleanup(temporary);
  write(temporary);
  for (const auto& entry : fs::recursive_directory_iterator(temporary)) sync_path(entry.path());
  sync_path(temporary);
  rename_synced(temporary, target);
  cleanup.release();
}

}  // namespace simuli
