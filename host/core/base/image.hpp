#pragma once
#include <cstddef>
#include <vector>

namespace simuli {

/// Largest side of pictures and cameras.
inline constexpr int kLargestSide_px = 65536;

/// Interleaved float picture, row-major, top row first.
struct Image {
  int width = 0;
  int height = 0;
  int channels = 0;
  std::vector<float> data;  // [height][width][channels]; colours in [0,1] as stored in the file

  Image() = default;
  Image(int w, int h, int c)
      : width(w),
        height(h),
        channels(c),
        data(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * static_cast<std::size_t>(c)) {}
  [[nodiscard]] float& at(int x, int y, int c) { return data[index(x, y, c)]; }
  [[nodiscard]] float at(int x, int y, int c) const { return data[index(x, y, c)]; }

 private:
  [[nodiscard]] std::size_t index(int x, int y, int c) const {
    return (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
               static_cast<std::size_t>(channels) +
           static_cast<std::size_t>(c);
  }
};

}  // namespace simuli
