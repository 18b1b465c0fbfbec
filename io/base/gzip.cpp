#include "io/base/gzip.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <limits>
#include <memory>
#include <utility>
#include <zlib.h>
#ifdef SIMULI_HAS_LZ4
#include <lz4frame.h>
#endif
#ifdef SIMULI_HAS_ZSTD
#include <zstd.h>
#endif

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

constexpr int kGzipWindow = 15 + 16;  // largest window, with gzip's header and checksum
constexpr int kAnyWindow = 15 + 32;   // gzip's or zlib's header
/// Returns the output size per call of zlib: the usual output for that much input, within bounds.
std::size_t chunk_bytes(std::size_t in) {
  return std::clamp(4 * in, std::size_t{1} << 12U, std::size_t{1} << 20U);
}

uInt part(std::size_t left) {
  return static_cast<uInt>(std::min<std::size_t>(left, std::numeric_limits<uInt>::max()));
}

/// Decompresses up to more than most_bytes; returns zlib's last status as well.
std::pair<std::string, int> inflated(const std::string& bytes, std::size_t most_bytes) {
  z_stream stream{};
  if (inflateInit2(&stream, kAnyWindow) != Z_OK) throw Error(ErrorKind::kInternal, "zlib: no memory");
  std::string in = bytes;  // zlib's pointer is not const
  std::string out, chunk(chunk_bytes(bytes.size()), '\0');
  std::size_t read = 0;
  int status = Z_OK;
  while (status == Z_OK && out.size() <= most_bytes) {
    stream.next_in = reinterpret_cast<Bytef*>(in.data() + read);
    const uInt given = part(in.size() - read);
    stream.avail_in = given;
    stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
    stream.avail_out = part(chunk.size());
    status = inflate(&stream, Z_NO_FLUSH);
    read += given - stream.avail_in;
    out.append(chunk, 0, chunk.size() - stream.avail_out);
  }
  inflateEnd(&stream);
  return {std::move(out), status};
}

}  // namespace

bool is_gzip(const std::string& bytes) { return bytes.starts_with("\x1f\x8b"); }

std::string gunzip(const std::string& bytes, const std::string& file, std::size_t most_bytes) {
  auto [out, status] = inflated(bytes, most_bytes);
  if (out.size() > most_bytes) {
    throw_input_error(file, "content", fmt::format("more than {} bytes", most_bytes), "at most that");
  }
  if (status != Z_STREAM_END) throw_input_error(file, "compressed data", "damaged or cut short", "whole");
  return std::move(out);
}

std::string gunzip_start(const std::string& bytes, std::size_t count, const std::string& file) {
  const auto [out, status] = inflated(bytes, count);
  if (status != Z_STREAM_END && out.size() < count) {
    throw_input_error(file, "compressed data", "damaged or cut short", "whole");
  }
  return out.substr(0, count);
}

std::string gzip(const std::string& bytes) {
  z_stream stream{};
  constexpr int kMemory = 8;  // zlib's default
  if (deflateInit2(&stream, Z_BEST_COMPRESSION, Z_DEFLATED, kGzipWindow, kMemory, Z_DEFAULT_STRATEGY) != Z_OK)
    throw Error(ErrorKind::kInternal, "zlib: no memory");
  std::string in = bytes;
  std::string out, chunk(chunk_bytes(bytes.size()), '\0');
  std::size_t read = 0;
  int status = Z_OK;
  while (status == Z_OK) {
    const uInt given = part(in.size() - read);
    stream.next_in = reinterpret_cast<Bytef*>(in.data() + read);
    stream.avail_in = given;
    stream.next_out = reinterpret_cast<Bytef*>(chunk.data());
    stream.avail_out = part(chunk.size());
    status = deflate(&stream, read + given == in.size() ? Z_FINISH : Z_NO_FLUSH);
    read += given - stream.avail_in;
    out.append(chunk, 0, chunk.size() - stream.avail_out);
  }
  deflateEnd(&stream);
  if (status != Z_STREAM_END) throw Error(ErrorKind::kInternal, "zlib: deflate failed");
  return out;
}

#ifdef SIMULI_HAS_ZSTD
bool has_zstd() { return true; }

std::string zstd(const std::string& bytes) {
  std::string out(ZSTD_compressBound(bytes.size()), '\0');
  const std::size_t got =
      ZSTD_compress(out.data(), out.size(), bytes.data(), bytes.size(), ZSTD_CLEVEL_DEFAULT);
  if (ZSTD_isError(got) != 0U) throw Error(ErrorKind::kInternal, "Zstandard: compression failed");
  out.resize(got);
  return out;
}

std::string unzstd(const char* bytes, std::size_t count, std::size_t size, const std::string& file) {
  // A block has at least 4 bytes and holds at most 128 KiB; larger claims would only allocate memory.
  constexpr std::size_t kMostOfByte = std::size_t{1} << 15U;
  std::string out(size / kMostOfByte <= count ? size : 0, '\0');
  const std::size_t got = ZSTD_decompress(out.data(), out.size(), bytes, count);
  if (ZSTD_isError(got) != 0U || got != size) {
    throw_input_error(file, "Zstandard data", "damaged, cut short or of another size", "whole");
  }
  return out;
}
#else
bool has_zstd() { return false; }

std::string zstd(const std::string&) {
  throw Error(ErrorKind::kUsage, "compression: found Zstandard, allowed in a build with libzstd");
}

std::string unzstd(const char*, std::size_t, std::size_t, const std::string& file) {
  throw_input_error(file, "compression", "Zstandard, which this build can't read", "a build with libzstd");
}
#endif

#ifdef SIMULI_HAS_LZ4
std::string unlz4(const char* bytes, std::size_t count, std::size_t size, const std::string& file) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0U)
    throw Error(ErrorKind::kInternal, "LZ4: no memory");
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      made, LZ4F_freeDecompressionContext);
  std::string out(size, '\0');
  std::size_t read = 0, written = 0, wanted = 1;  // 0: at the end of a frame
  while (read < count) {
    std::size_t in = count - read, to = size - written;
    wanted = LZ4F_decompress(context.get(), out.data() + written, &to, bytes + read, &in, nullptr);
    if (LZ4F_isError(wanted) != 0U || (in == 0 && to == 0)) break;
    read += in;
    written += to;
  }
  if (wanted != 0 || read != count || written != size)
    throw_input_error(file, "LZ4 data", "damaged, cut short or of another size", "whole");
  return out;
}
#else
std::string unlz4(const char*, std::size_t, std::size_t, const std::string& file) {
  throw_input_error(file, "compression", "LZ4, which this build can't read", "a build with liblz4");
}
#endif

std::uint32_t crc_32(std::string_view bytes, std::uint32_t before) {
  return static_cast<std::uint32_t>(
      crc32_z(before, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

}  // namespace simuli
