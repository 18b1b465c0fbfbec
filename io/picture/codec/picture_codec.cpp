#include "io/picture/codec/picture_codec.hpp"

#ifdef SIMULI_PICTURES
#include <dlfcn.h>
#include <fmt/format.h>

#include "host/core/base/error.hpp"
#endif

namespace simuli {

std::vector<std::pair<std::string, std::string>> reproducible_exr() {
  return {{"compression", "zip"}, {"DateTime", "1970:01:01 00:00:00"}};
}

#ifdef SIMULI_PICTURES
namespace {

using Entry = decltype(&simuli_picture_codec_2);

const PictureCodec* loaded_codec() {
  const auto refuse = [] {
    const char* const cause = ::dlerror();
    throw Error(
        ErrorKind::kInternal,
        fmt::format("{}: found {}, allowed one of this build and all libraries that it needs (it reads "
                    "and writes pictures and sweeps)",
                    SIMULI_PICTURES,
                    cause != nullptr ? cause : "none"));
  };
  // Searched beside the caller (run path), then in the system's folders. Never closed: its libraries' cleanup
  // runs at exit.
  void* const object = ::dlopen(SIMULI_PICTURES, RTLD_LAZY | RTLD_LOCAL);
  if (object == nullptr) refuse();
  void* const entry = ::dlsym(object, "simuli_picture_codec_2");
  if (entry == nullptr) refuse();
  return reinterpret_cast<Entry>(entry)();
}

}  // namespace

const PictureCodec& picture_codec() {
  static const PictureCodec* const codec = loaded_codec();
  return *codec;
}
#else
const PictureCodec& picture_codec() { return *simuli_picture_codec_2(); }
#endif

}  // namespace simuli
