#pragma once
// Names and numbers of glTF 2.0 (Khronos, section 5 and KHR_gaussian_splatting) that reader and writer share.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace simuli::glb {

inline constexpr std::string_view kMagic = "glTF";
inline constexpr std::uint32_t kVersion = 2;
inline constexpr std::size_t kHeaderBytes = 12, kChunkHeaderBytes = 8;
inline constexpr std::uint32_t kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;  // "JSON", "BIN\0"

inline constexpr int kByte = 5120, kUnsignedByte = 5121, kShort = 5122, kUnsignedShort = 5123, kFloat = 5126;
inline constexpr int kPoints = 0;  // mode of a primitive

inline constexpr char kSplatting[] = "KHR_gaussian_splatting";
inline constexpr char kSpz[] = "KHR_gaussian_splatting_compression_spz_2";
inline constexpr char kKernel[] = "ellipse";
inline constexpr char kColorSpace[] = "srgb_rec709_display";
inline constexpr char kPosition[] = "POSITION";
inline constexpr char kColor[] = "COLOR_0";
inline constexpr char kRotation[] = "KHR_gaussian_splatting:ROTATION";  // x, y, z, w
inline constexpr char kScale[] = "KHR_gaussian_splatting:SCALE";
inline constexpr char kOpacity[] = "KHR_gaussian_splatting:OPACITY";

/// Returns the name of SH coefficient k in this project's order: by degree, then by order from -degree to
/// degree.
[[nodiscard]] inline std::string sh_name(int k) {
  int degree = 0;
  while ((degree + 1) * (degree + 1) <= k) ++degree;
  return "KHR_gaussian_splatting:SH_DEGREE_" + std::to_string(degree) + "_COEF_" +
         std::to_string(k - degree * degree);
}

}  // namespace simuli::glb
