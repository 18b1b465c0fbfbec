#include "io/zarr/zarr_codec.hpp"

#include <algorithm>
#include <blosc.h>
#include <fmt/format.h>
#include <lzma.h>
#include <memory>

#include "host/core/base/error.hpp"
#include "io/zarr/zarr_store.hpp"

namespace simuli {

bool has_zarr() { return true; }

std::string blosc(const std::string& bytes, std::size_t item_bytes) {
  constexpr int kLevel = 5;
  std::string out(bytes.size() + BLOSC_MAX_OVERHEAD, '\0');
  const int got = blosc_compress_ctx(kLevel,
                                     BLOSC_BITSHUFFLE,
                                     item_bytes,
                                     bytes.size(),
                                     bytes.data(),
                                     out.data(),
                                     out.size(),
                                     BLOSC_LZ4_COMPNAME,
                                     0,
                                     1);
  if (got <= 0) throw Error(ErrorKind::kInternal, "Blosc: compression failed");
  out.resize(static_cast<std::size_t>(got));
  return out;
}

std::string unblosc(const std::string& bytes, std::size_t size, const std::string& file) {
  constexpr int kNoSuchCompressor = -5;
  std::size_t stated = 0;
  // The decoder trusts the header's sizes; compare them with the data first.
  const bool is_whole = bytes.size() >= BLOSC_MIN_HEADER_LENGTH &&
                        blosc_cbuffer_validate(bytes.data(), bytes.size(), &stated) == 0 && stated == size;
  std::string out(is_whole ? size : 0, '\0');
  const int got = is_whole && size > 0 ? blosc_decompress_ctx(bytes.data(), out.data(), size, 1) : 0;
  if (got == kNoSuchCompressor) {
    const char* const name = blosc_cbuffer_complib(bytes.data());
    throw_input_error(file,
                      "Blosc data",
                      name == nullptr ? "of an unknown compressor"
                                      : fmt::format("compressed by {}, which libblosc is without here", name),
                      blosc_list_compressors());
  }
  if (!is_whole || got != static_cast<int>(size)) {
    throw_input_error(
        file, "Blosc data", "damaged, cut short or of another size", fmt::format("{} bytes", size));
  }
  return out;
}

std::string xz(const std::string& bytes) {
  std::string out(lzma_stream_buffer_bound(bytes.size()), '\0');
  std::size_t size = 0;
  const lzma_ret result = lzma_easy_buffer_encode(LZMA_PRESET_DEFAULT,
                                                  LZMA_CHECK_CRC64,
                                                  nullptr,
                                                  reinterpret_cast<const std::uint8_t*>(bytes.data()),
                                                  bytes.size(),
                                                  reinterpret_cast<std::uint8_t*>(out.data()),
                                                  &size,
                                                  out.size());
  if (result != LZMA_OK) throw Error(ErrorKind::kInternal, "xz: compression failed");
  out.resize(size);
  return out;
}

std::string unxz(const std::string& bytes, const std::string& file, std::size_t most_bytes) {
  constexpr std::uint64_t kMostMemory = std::uint64_t{1} << 28U;
  constexpr std::size_t kPart = 1U << 16U;
  lzma_stream made = LZMA_STREAM_INIT;
  const auto ender = [](lzma_stream* stream) { lzma_end(stream); };
  const std::unique_ptr<lzma_stream, decltype(ender)> stream(&made, ender);
  if (lzma_stream_decoder(stream.get(), kMostMemory, 0) != LZMA_OK)
    throw Error(ErrorKind::kInternal, "xz: no memory");
  stream->next_in = reinterpret_cast<const std::uint8_t*>(bytes.data());
  stream->avail_in = bytes.size();
  std::string out, part(kPart, '\0');
  lzma_ret result = LZMA_OK;
  while (result == LZMA_OK && out.size() <= most_bytes) {
    stream->next_out = reinterpret_cast<std::uint8_t*>(part.data());
    stream->avail_out = part.size();
    result = lzma_code(stream.get(), LZMA_FINISH);
    out.append(part, 0, part.size() - stream->avail_out);
  }
  if (out.size() > most_bytes) {
    throw_input_error(file, "xz data", fmt::format("more than {} bytes", most_bytes), "at most that");
  }
  if (result != LZMA_STREAM_END) throw_input_error(file, "xz data", "damaged or cut short", "whole");
  return out;
}

}  // namespace simuli
