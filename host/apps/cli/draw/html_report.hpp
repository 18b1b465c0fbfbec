#pragma once
// A report in one self-contained HTML file: tables, curves, pictures, comparisons of pictures, point clouds.
// The layout suits wide and narrow windows and paper.
#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "host/apps/cli/draw/chart.hpp"
#include "io/picture/image.hpp"

namespace simuli {

/// Encoding of a picture: lossless, or JPEG of kPhotoQuality.
enum class PictureCode { kLossless, kPhoto };
inline constexpr int kPhotoQuality = 92;

/// Points in one colour. A report stores at most kMostPoints of them, evenly selected, as 16-bit integers.
struct CloudLayer {
  static constexpr std::size_t kMostPoints = 40'000;

  std::string name;
  std::string colour;                 // "#rrggbb"
  bool is_shown = true;               // initially visible
  std::vector<float> xyz = {};        // [N, 3] m, x forward, y left, z up, relative to the centre of the view
  std::vector<float> intensity = {};  // [N], 0 to 1
};
/// Corners in the same frame; edges connect k with k ^ 1, k ^ 2 and k ^ 4.
using CloudBox = std::array<std::array<float, 3>, 8>;

class HtmlReport {
 public:
  /// All text is plain text and is escaped.
  HtmlReport(std::string title, std::string subtitle);

  /// Starts a section with an entry in the list below the title.
  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /// Adds the main numbers in a large font, each above its name, below `text`.
  struct Fact {
    std::string name;
    std::string value;
  };
  void facts(const std::string& text, const std::vector<Fact>& facts);
  /// The first column contains the names of the rows. On a phone each row of a wide table becomes a block
  /// with the names of the columns. Every row needs as many cells as `header`.
  void table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);
  /// The same with text in all columns.
  void text_table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);
  /// Adds a collapsed text table with the title `summary`; it is omitted in print.
  void folded_table(const std::string& summary,
                    const std::vector<std::string>& header,
                    const std::vector<std::vector<std::string>>& rows);
  /// Adds curves as vector graphics; nothing if fewer than two points are finite.
  void chart(const std::string& title, const std::string& x_label, const std::vector<ChartSeries>& series);
  /// Adds a group of bars per label with one bar per series; nothing if no value is finite.
  void bars(const std::string& title,
            const std::vector<std::string>& labels,
            const std::vector<ChartSeries>& series);
  /// Adds a picture above `caption`. A click enlarges it.
  void picture(const Image& image, const std::string& caption, PictureCode code = PictureCode::kLossless);
  /// Adds two pictures of the same size, one over the other, with a divider that the reader drags.
  void compare(const Image& left,
               const std::string& left_label,
               const Image& right,
               const std::string& right_label,
               const std::string& caption,
               PictureCode code = PictureCode::kLossless);
  /// Adds a point cloud that the reader rotates. Layers without points are omitted; nothing is added without
  /// any point.
  void cloud(const std::vector<CloudLayer>& layers,
             const std::vector<CloudBox>& boxes,
             const std::string& caption);

  /// Returns the complete page.
  [[nodiscard]] std::string html() const;
  /// Writes the page atomically. Throws Error{kInput} if the file cannot be written.
  void write(const std::filesystem::path& file) const;

 private:
  /// Adds `html`. Consecutive figures of the same group are put side by side; "": no group.
  void add(const std::string& group, const std::string& html);
  void add_figure(const Image& size, const std::string& shot, const std::string& caption);
  [[nodiscard]] std::string table_html(const char* css_class,
                                       const std::vector<std::string>& header,
                                       const std::vector<std::vector<std::string>>& rows) const;

  std::string title_, subtitle_, body_;
  std::string group_;  // open group in body_
  std::vector<std::string> headings_;
};

}  // namespace simuli
