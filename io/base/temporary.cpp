#include "io/base/temporary.hpp"

#include <atomic>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <mutex>
#include <optional>
#include <set>
#include <stdlib.h>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMark = ".tmp";

/// A reserved descriptor for the removal of folders when no other descriptor is available.
class Spare {
 public:
  /// Returns false without a descriptor. Not thread-safe.
  [[nodiscard]] bool keep() {
    if (descriptor_ < 0) descriptor_ = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    return descriptor_ >= 0;
  }
  void give_back() {
    const int kept = descriptor_.exchange(-1);
    if (kept >= 0) ::close(kept);
  }

 private:
  std::atomic<int> descriptor_ = -1;
};

/// Paths that remove_temporaries() removes. Never destroyed, because it may be used while the process ends.
struct Registry {
  std::mutex mutex;
  std::set<fs::path> paths;
  std::set<pid_t> groups;  // process groups
  bool kills_groups = false;
  Spare spare;
  std::atomic<std::size_t> written = 0;  // number of Temporary objects that may still create a file
};

Registry& registry() {
  static auto* const all = new Registry;
  return *all;
}

/// Removes level by level with one descriptor at a time.
void remove_by_levels(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(fs::symlink_status(path, ignored))) {
    std::vector<fs::path> entries;
    for (fs::directory_iterator at(path, ignored), end; !ignored && at != end; at.increment(ignored)) {
      entries.push_back(at->path());
    }
    for (const fs::path& entry : entries) remove_by_levels(entry);
  }
  fs::remove(path, ignored);
}

/// Removes files and folders. Ignores errors, because another error is being reported.
void remove_all_of(const fs::path& path, Spare& spare) {
  std::error_code failed;
  fs::remove_all(path, failed);  // needs a descriptor per level and one per file
  if (failed != std::errc::too_many_files_open) return;
  spare.give_back();
  remove_by_levels(path);
}

/// Returns the process id in ".STEM.PID-N.tmpEXTENSION"; no value for other names.
std::optional<pid_t> process_in(std::string_view name, std::string_view stem, std::string_view extension) {
  const std::string front = fmt::format(".{}.", stem), back = fmt::format("{}{}", kMark, extension);
  if (name.size() <= front.size() + back.size() || !name.starts_with(front) || !name.ends_with(back))
    return {};
  const std::string_view middle = name.substr(front.size(), name.size() - front.size() - back.size());
  pid_t process = 0;
  unsigned number = 0;
  const char* const end = middle.data() + middle.size();
  const auto first = std::from_chars(middle.data(), end, process);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != '-') return {};
  const auto second = std::from_chars(first.ptr + 1, end, number);
  if (second.ec != std::errc() || second.ptr != end) return {};
  return process;
}

/// Returns the path's key in the registry. If the working folder was removed, absolute paths do not exist, and
/// nothing can be written.
fs::path key_of(const fs::path& path) {
  std::error_code error;
  const fs::path absolute = fs::absolute(path, error);
  return error ? path : absolute;
}

/// Whether the path is in a temporary folder, which is synced as a whole before it is renamed, or removed in
/// the end; syncing thousands of pictures individually takes minutes.
bool is_in_a_temporary(const fs::path& path) {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  for (fs::path at = key_of(path).parent_path(); at != at.root_path(); at = at.parent_path()) {
    if (all.paths.contains(at)) return true;
  }
  return false;
}

void sync_to_disk(const fs::path& path) {
  const Descriptor descriptor(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (descriptor.get() < 0) throw_errno(path, "sync", "a file that was just written");
  // EINVAL: the file system cannot sync folders; the rename is still atomic.
  if (::fsync(descriptor.get()) != 0 && errno != EINVAL) throw_errno(path, "sync", "a working disk");
}

/// Starts write-back, so that syncing many files waits for all of them at once.
void begin_to_write_out(const fs::path& file) {
  const Descriptor descriptor(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  (void)::sync_file_range(
      descriptor.get(), 0, 0, SYNC_FILE_RANGE_WRITE);  // a hint; some file systems lack it
}

bool is_dead(pid_t process) { return ::kill(process, 0) != 0 && errno == ESRCH; }

}  // namespace

Descriptor::~Descriptor() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

int Descriptor::release() { return std::exchange(descriptor_, -1); }

int Descriptor::close() { return ::close(release()); }

void throw_errno(const fs::path& file, const char* field, const char* allowed) {
  throw_input_error(file.string(), field, std::strerror(errno), allowed);
}

fs::path parent_of(const fs::path& path) {
  const fs::path parent = path.parent_path();
  return parent.empty() ? fs::path(".") : parent;
}

fs::path without_trailing_slash(const fs::path& path) {
  return path.has_filename() ? path : path.parent_path();
}

Temporary::Temporary(const fs::path& target) : target_(target) {
  static std::atomic<unsigned> counter{0};
  path_ =
      parent_of(target) /
      fmt::format(
          ".{}.{}-{}{}{}", target.stem().string(), ::getpid(), counter++, kMark, target.extension().string());
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  if (!all.spare.keep()) throw_errno(target_, "open", "a descriptor more");
  all.paths.insert(key_of(path_));
  ++all.written;
}

Temporary::~Temporary() {
  if (path_.empty()) return;
  remove_all_of(path_, registry().spare);
  --registry().written;
  keep_at_end(path_);
}

void Temporary::fill(const std::function<void(const fs::path&)>& write) const {
  try {
    write(path_);
  } catch (const Error& error) {
    std::string what = error.what();
    const std::string own = path_.string(), target = target_.string();
    for (std::size_t at = what.find(own); at != std::string::npos; at = what.find(own, at + target.size())) {
      what.replace(at, own.size(), target);
    }
    throw Error(error.kind(), what);
  }
}

void Temporary::sync() const {
  std::error_code ignored;  // for a file; syncing it reports errors
  if (fs::is_directory(path_, ignored)) {
    std::vector<fs::path> entries;
    for (const auto& entry : fs::recursive_directory_iterator(path_)) entries.push_back(entry.path());
    for (const fs::path& entry : entries) begin_to_write_out(entry);
    for (const fs::path& entry : entries) sync_to_disk(entry);
  }
  sync_to_disk(path_);
}

void Temporary::become_target() {
  const bool is_to_last = !is_in_a_temporary(target_);
  if (is_to_last) sync();
  if (::rename(path_.c_str(), target_.c_str()) != 0) {
    throw_errno(target_, "rename", "a path that can be written");
  }
  --registry().written;
  keep_at_end(path_);
  path_.clear();
  if (is_to_last) sync_to_disk(parent_of(target_));
}

void Temporary::take_targets_place() {
  sync();
  const auto refuse = [&] { throw_errno(target_, "rename", "a folder that can be replaced"); };
  if (::renameat2(AT_FDCWD, path_.c_str(), AT_FDCWD, target_.c_str(), RENAME_EXCHANGE) != 0) {
    // Some file systems cannot exchange paths; then the old folder has another name for a moment.
    if (errno != EINVAL && errno != ENOSYS && errno != ENOTSUP) refuse();
    const Temporary old(target_);
    if (::rename(target_.c_str(), old.path().c_str()) != 0) refuse();
    if (::rename(path_.c_str(), target_.c_str()) != 0) {
      const int why = errno;
      (void)::rename(old.path().c_str(), target_.c_str());
      errno = why;
      refuse();
    }
  }
  sync_to_disk(parent_of(target_));  // path_ now contains the old folder
}

void remove_temporaries() noexcept {
  try {
    kill_groups();
    Registry& all = registry();
    all.mutex.lock();  // never unlocked: no new temporary can begin or end
    // A thread that is creating a file or filling a folder may continue: it finds its path missing and then
    // waits for the lock. This loop waits for such threads; a busy machine gets several tries.
    constexpr int kFewestTries = 10;
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(200);
    for (int i = 0; i < kFewestTries || std::chrono::steady_clock::now() < end; ++i) {
      const bool is_last = all.written == 0;
      for (const fs::path& path : all.paths) remove_all_of(path, all.spare);
      if (is_last) break;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  } catch (...) {  // the process ends in any case
  }
}

void remove_at_end(const fs::path& path) {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  all.paths.insert(key_of(path));
}

void keep_at_end(const fs::path& path) {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  all.paths.erase(key_of(path));
}

void kill_at_end(pid_t group) {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  all.groups.insert(group);
  if (all.kills_groups) ::kill(-group, SIGKILL);
}

void kill_groups() {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  all.kills_groups = true;
  for (const pid_t group : all.groups) ::kill(-group, SIGKILL);
}

void spare_at_end(pid_t group) {
  Registry& all = registry();
  const std::lock_guard lock(all.mutex);
  all.groups.erase(group);
}

void remove_stale_temporaries(const fs::path& target) {
  const fs::path whole = without_trailing_slash(target);
  std::vector<fs::path> stale;
  std::error_code failed;
  for (fs::directory_iterator at(parent_of(whole), failed), end; !failed && at != end; at.increment(failed)) {
    const auto process =
        process_in(at->path().filename().string(), whole.stem().string(), whole.extension().string());
    if (process && is_dead(*process)) stale.push_back(at->path());
  }
  std::error_code ignored;  // a new temporary has another name
  for (const fs::path& path : stale) fs::remove_all(path, ignored);
}

bool is_temporary(const fs::path& file) {
  const std::string name = file.filename().string();
  const std::size_t mark = name.rfind(kMark);
  if (mark == std::string::npos || mark == 0 || name.front() != '.') return false;
  const std::size_t number = name.rfind('.', mark - 1);
  if (number == std::string::npos || number == 0) return false;
  return process_in(name, name.substr(1, number - 1), name.substr(mark + kMark.size())).has_value();
}

ScratchFolder::ScratchFolder(const std::string& name) {
  std::string pattern = (std::filesystem::temp_directory_path() / (name + "_XXXXXX")).string();
  if (::mkdtemp(pattern.data()) == nullptr) throw_errno(pattern, "folder", "one that can be made");
  path_ = pattern;
  remove_at_end(path_);
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;  // a destructor must not throw; remains are in the temporary folder
  std::filesystem::remove_all(path_, ignored);
  keep_at_end(path_);
}

}  // namespace simuli
