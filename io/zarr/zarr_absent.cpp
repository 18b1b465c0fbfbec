// Replacement in builds without libblosc or liblzma.
#include "host/core/base/error.hpp"
#include "io/zarr/zarr_codec.hpp"
#include "io/zarr/zarr_store.hpp"

namespace simuli {
namespace {

[[noreturn]] void refuse(const std::string& file) {
  throw_input_error(file,
                    "kind",
                    "a Zarr store, which this build can't read or write",
                    "a build with libblosc and liblzma");
}

}  // namespace

bool has_zarr() { return false; }
std::string blosc(const std::string&, std::size_t) { refuse("output"); }
std::string unblosc(const std::string&, std::size_t, const std::string& file) { refuse(file); }
std::string xz(const std::string&) { refuse("output"); }
std::string unxz(const std::string&, const std::string& file, std::size_t) { refuse(file); }

}  // namespace simuli
