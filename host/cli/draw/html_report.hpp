#pragma once
// A report as one HTML file that needs nothing beside it: tables, curves, pictures, pictures to compare.
#include <filesystem>
#include <string>
#include <vector>

#include "io/picture/image.hpp"

namespace simuli {

/// A curve of a chart. x and y are of the same length; points whose y is not finite are left out.
struct ChartSeries {
  std::string name;
  std::vector<double> x;
  std::vector<double> y;
};

class HtmlReport {
 public:
  /// All text of a report is plain and is escaped.
  HtmlReport(std::string title, std::string subtitle);

  void heading(const std::string& text);
  void paragraph(const std::string& text);
  /// The first column is a row's name. Every row has as many cells as `header`.
  void table(const std::vector<std::string>& header, const std::vector<std::vector<std::string>>& rows);
  /// Curves over one axis, drawn as vectors. Nothing is shown when no series has two finite points.
  void chart(const std::string& title, const std::string& x_label, const std::vector<ChartSeries>& series);
  /// Lossless; `caption` stands below.
  void picture(const Image& image, const std::string& caption);
  /// Two pictures of one size over each other, parted by a line that the reader drags.
  void compare(const Image& left,
               const std::string& left_label,
               const Image& right,
               const std::string& right_label,
               const std::string& caption);

  /// The whole page.
  [[nodiscard]] std::string html() const;
  /// Atomic. Error{kInput} when the file can't be written.
  void write(const std::filesystem::path& file) const;

 private:
  std::string title_, subtitle_, body_;
};

}  // namespace simuli
