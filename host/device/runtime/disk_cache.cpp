#include "host/device/runtime/disk_cache.hpp"

#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <mutex>
#include <stdlib.h>
#include <string_view>
#include <unistd.h>
#include <vector>

namespace simuli {
namespace {

namespace fs = std::filesystem;

// A file contains this line, three little-endian 64-bit numbers (key length, binary length, checksum of the
// binary), the key and the binary. The version increases when the layout or the build changes.
constexpr std::string_view kMagic = "simuli program binary 1\n";
// Program binaries have megabytes; a larger file is not a cache entry.
constexpr std::uintmax_t kMaxFileBytes = std::uintmax_t{1} << 30U;

struct Numbers {
  std::uint64_t key_bytes;
  std::uint64_t binary_bytes;
  std::uint64_t checksum;
};

// FNV-1a names files and detects damage; the comparison of the full key decides.
std::uint64_t fnv1a(const void* data, std::size_t bytes) {
  std::uint64_t hash = 0xcbf29ce484222325U;
  const auto* const first = static_cast<const unsigned char*>(data);
  for (std::size_t i = 0; i < bytes; ++i) hash = (hash ^ first[i]) * 0x100000001b3U;
  return hash;
}

fs::path file_of(const fs::path& folder, const std::string& key) {
  return folder / fmt::format("{:016x}.clbin", fnv1a(key.data(), key.size()));
}

bool write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

bool write_synced(const fs::path& path, std::string_view bytes) {
  constexpr int kOwnerOnly = 0600;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kOwnerOnly);
  if (file < 0) return false;
  const bool complete = write_all(file, bytes) && ::fsync(file) == 0;
  return ::close(file) == 0 && complete;
}

std::optional<std::string> environment(const char* name) {
  const char* const value = std::getenv(name);
  if (value == nullptr) return std::nullopt;
  return std::string(value);
}

constexpr const char* kDriverCache = "POCL_CACHE_DIR";

/// Returns the folder by PoCL's own rules.
fs::path usual_driver_cache() {
  if (const auto xdg = environment("XDG_CACHE_HOME"); xdg && !xdg->empty())
    return fs::path(*xdg) / "pocl/kcache";
  if (const auto home = environment("HOME"); home && !home->empty()) {
    return fs::path(*home) / ".cache/pocl/kcache";
  }
  return "/tmp/pocl/kcache";
}

/// Creates the folder and returns whether files can be written in it.
bool is_writable(fs::path folder) {
  std::error_code failed;
  while (!fs::exists(folder, failed) && folder.has_relative_path()) folder = folder.parent_path();
  constexpr std::uintmax_t kLeast = std::uintmax_t{16}
                                    << 20U;  // the compiler aborts when the disk is full
  return fs::is_directory(folder, failed) && ::access(folder.c_str(), W_OK | X_OK) == 0 &&
         fs::space(folder, failed).available >= kLeast;
}

/// Removed when the process exits.
class PrivateFolder {
 public:
  PrivateFolder() {
    std::error_code failed;
    std::string pattern = (fs::temp_directory_path(failed) / "simuli-pocl-XXXXXX").string();
    if (!failed && ::mkdtemp(pattern.data()) != nullptr) path_ = pattern;
  }
  PrivateFolder(const PrivateFolder&) = delete;
  PrivateFolder& operator=(const PrivateFolder&) = delete;
  ~PrivateFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

std::string& note() {
  static std::string text;
  return text;
}

/// Removes the folders of earlier crashes.
void remove_older(const fs::path& folder, int crashes) {
  std::error_code ignored;
  for (int i = 1; i + 1 < crashes; ++i) fs::remove_all(folder / fmt::format("pocl.{}", i), ignored);
}

void choose_driver_cache() {
  if (environment(kDriverCache)) return;
  constexpr int kOverwrite = 0;
  const auto use = [](const fs::path& folder) { ::setenv(kDriverCache, folder.c_str(), kOverwrite); };
  const auto count = crash_count();
  if (count && count->next > 1 && is_writable(count->file.parent_path())) {
    const int crashes = count->next - 1;
    const fs::path own = count->file.parent_path() / fmt::format("pocl.{}", crashes);
    std::error_code failed;
    if (!fs::exists(own, failed)) {
      note() = fmt::format("the run before crashed: PoCL's cache is {} from now on, in case {} is damaged",
                           own.string(),
                           usual_driver_cache().string());
      remove_older(own.parent_path(), crashes);
      fs::create_directories(own, failed);
    }
    use(own);
    return;
  }
  const fs::path usual = usual_driver_cache();
  if (is_writable(usual)) return;
  static const PrivateFolder instead;
  if (instead.path().empty()) return;
  use(instead.path());
  note() =
      fmt::format("PoCL can't write its cache {}: kernels are compiled anew in every run; set {} to a folder",
                  usual.string(),
                  kDriverCache);
}

}  // namespace

std::string program_key(const DeviceInfo& device, const std::string& options, const std::string& source) {
  return fmt::format(
      "{}platform {}\nplatform version {}\ndevice {}\nvendor {}\ndevice version {}\ndriver version {}\n"
      "options {}\nsource\n{}",
      kMagic,
      device.platform,
      device.platform_version,
      device.name,
      device.vendor,
      device.device_version,
      device.driver_version,
      options,
      source);
}

std::optional<fs::path> cache_folder() {
  if (const auto own = environment("SIMULI_CACHE_DIR")) {
    if (own->empty()) return std::nullopt;
    return fs::path(*own);
  }
  // The XDG specification requires ignoring relative paths.
  if (const auto xdg = environment("XDG_CACHE_HOME"); xdg && fs::path(*xdg).is_absolute()) {
    return fs::path(*xdg) / "simuli";
  }
  if (const auto home = environment("HOME"); home && !home->empty()) {
    return fs::path(*home) / ".cache" / "simuli";
  }
  return std::nullopt;
}

void prepare_driver_cache() {
  static std::once_flag once;
  std::call_once(once, [] {
    ::setenv("POCL_WORK_GROUP_SPECIALIZATION", "0", 0);
    choose_driver_cache();
  });
}

std::string driver_cache_note() { return note(); }

fs::path driver_cache_folder() {
  const auto own = environment(kDriverCache);
  return own ? fs::path(*own) : usual_driver_cache();
}

namespace {

struct Installed {
  std::mutex mutex;
  std::vector<void (*)()> installs;
};

Installed& kept() {
  static Installed all;
  return all;
}

}  // namespace

void keep_installed(void (*install)()) {
  const std::lock_guard lock(kept().mutex);
  kept().installs.push_back(install);
  install();
}

void driver_has_built() {
  const std::lock_guard lock(kept().mutex);
  for (auto* const install : kept().installs) install();
}

std::optional<CrashCount> crash_count() {
  const auto folder = cache_folder();
  if (!folder) return std::nullopt;
  CrashCount count{*folder / "crashes"};
  int crashes = 0;
  constexpr int kMost = 1'000'000;
  if (std::ifstream(count.file) >> crashes && crashes > 0 && crashes < kMost) count.next = crashes + 1;
  return count;
}

std::optional<ProgramBinary> load_binary(const std::string& key) {
  const auto folder = cache_folder();
  if (!folder) return std::nullopt;
  const fs::path path = file_of(*folder, key);
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  constexpr std::size_t kHeaderBytes = kMagic.size() + sizeof(Numbers);
  if (error || size < kHeaderBytes || size > kMaxFileBytes) return std::nullopt;
  std::ifstream stream(path, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  std::string_view rest(bytes);
  if (bytes.size() != size || !rest.starts_with(kMagic)) return std::nullopt;
  Numbers numbers{};
  std::memcpy(&numbers, rest.data() + kMagic.size(), sizeof(numbers));
  rest.remove_prefix(kHeaderBytes);
  if (numbers.key_bytes != key.size() || !rest.starts_with(key)) return std::nullopt;
  rest.remove_prefix(key.size());
  if (rest.empty() || rest.size() != numbers.binary_bytes) return std::nullopt;
  if (fnv1a(rest.data(), rest.size()) != numbers.checksum) return std::nullopt;
  return ProgramBinary(rest.begin(), rest.end());
}

void save_binary(const std::string& key, const ProgramBinary& binary) {
  const auto folder = cache_folder();
  if (!folder || binary.empty()) return;
  std::error_code error;
  fs::create_directories(*folder, error);
  if (error) return;
  const Numbers numbers{key.size(), binary.size(), fnv1a(binary.data(), binary.size())};
  std::string bytes(kMagic);
  bytes.append(reinterpret_cast<const char*>(&numbers), sizeof(numbers));
  bytes += key;
  bytes.append(reinterpret_cast<const char*>(binary.data()), binary.size());
  static std::atomic<unsigned> counter{0};
  const fs::path path = file_of(*folder, key);
  const fs::path temporary = fmt::format("{}.{}.{}.tmp", path.string(), ::getpid(), counter++);
  if (write_synced(temporary, bytes)) fs::rename(temporary, path, error);
  // Removes a partly written file; after the rename it does not exist.
  fs::remove(temporary, error);
}

}  // namespace simuli
