// A tar file with an index at its end: xz(CBOR {"items": [text], "offset_datas": [n], "sizes": [n]}), padded to
// a block, then a block with magic, kind, offset and size of the index.
#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <fmt/format.h>
#include <map>
#include <sys/stat.h>
#include <unistd.h>

#include "host/core/base/error.hpp"
#include "io/base/file.hpp"
#include "io/base/temporary.hpp"
#include "io/zarr/itar_index.hpp"
#include "io/zarr/zarr_codec.hpp"
#include "io/zarr/zarr_store.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

class ItarStore : public ZarrStore {
 public:
  explicit ItarStore(const fs::path& file)
      : file_(file.string()), descriptor_(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
    if (descriptor_.get() < 0) throw_errno(file, "file", "a readable file");
    need_regular_file(file);
    struct stat info {};
    if (::fstat(descriptor_.get(), &info) != 0) throw_errno(file, "file", "a readable file");
    const auto size = static_cast<std::uint64_t>(info.st_size);
    if (size < kTarBlock || size % kTarBlock != 0) {
      throw_input_error(file_, "size", fmt::format("{} bytes", size), "blocks of 512, the last of the index");
    }
    const ItarTrailer trailer = read_itar_trailer(part(size - kTarBlock, kTarBlock), size - kTarBlock, file_);
    // At most the size of the listed entries, each of which has its own block.
    const std::uint64_t most = std::min(kLargestEntry, trailer.offset + 8 * kTarBlock);
    const std::string index = unxz(part(trailer.offset, trailer.size), file_ + ": index", most);
    entries_ = read_itar_index(index, trailer.offset, file_);
  }
  [[nodiscard]] bool has(const std::string& key) const override { return entries_.contains(key); }
  [[nodiscard]] std::string read(const std::string& key) const override {
    const auto found = entries_.find(key);
    if (found == entries_.end()) throw_input_error(file_, key, "none", "an entry of the index");
    return part(found->second.offset, found->second.size);
  }
  [[nodiscard]] std::vector<std::string> children(const std::string& group) const override {
    std::vector<std::string> out;
    const std::string prefix = group.empty() ? "" : group + '/';
    for (auto at = entries_.lower_bound(prefix); at != entries_.end() && at->first.starts_with(prefix);) {
      const std::string child =
          at->first.substr(prefix.size(), at->first.find('/', prefix.size()) - prefix.size());
      const std::string path = prefix + child;
      if (is_group(*this, path) || is_array(*this, path)) out.push_back(child);
      // Names below the child sort before its name followed by the character after '/'.
      at = entries_.lower_bound(at->first == path ? path + '\0' : path + static_cast<char>('/' + 1));
    }
    return out;
  }
  [[nodiscard]] std::string name() const override { return file_; }

 private:
  [[nodiscard]] std::string part(std::uint64_t offset, std::uint64_t size) const {
    std::string out(size, '\0');
    std::size_t done = 0;
    while (done < size) {
      const ssize_t got =
          ::pread(descriptor_.get(), out.data() + done, size - done, static_cast<off_t>(offset + done));
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) throw_errno(file_, "content", "a readable file");
      if (got == 0) throw_input_error(file_, "size", "an end within an entry", "a whole file");
      done += static_cast<std::size_t>(got);
    }
    return out;
  }

  std::string file_;
  Descriptor descriptor_;
  std::map<std::string, ItarEntry> entries_;
};

}  // namespace

std::unique_ptr<const ZarrStore> open_itar(const fs::path& file) {
  need_regular_file(file);
  return std::make_unique<const ItarStore>(file);
}

}  // namespace simuli
