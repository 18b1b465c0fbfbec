#include "host/apps/cli/draw/html_report.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <string_view>
#include <utility>

#include "host/apps/cli/draw/html_text.hpp"
#include "host/apps/cli/draw/pictures.hpp"
#include "host/core/base/error.hpp"
#include "host/device/runtime/source.hpp"
#include "io/base/file.hpp"

namespace simuli {
namespace cli {
std::span<const EmbeddedFile> report_files();  // files of page/, embedded by the build
}  // namespace cli
namespace {

/// Returns a file of host/apps/cli/draw/page/.
std::string_view page_file(std::string_view name) {
  for (const EmbeddedFile& file : cli::report_files()) {
    if (file.path == name) return file.text;
  }
  throw Error(ErrorKind::kInternal, fmt::format("{}: not embedded", name));
}

std::string image_tag(const Image& image, PictureCode code, std::string_view attributes) {
  const bool is_photo = code == PictureCode::kPhoto;
  return fmt::format(
      R"(<img {} width="{}" height="{}" src="data:image/{};base64,{}">)",
      attributes,
      image.width,
      image.height,
      is_photo ? "jpeg" : "png",
      base64(encode_image(image, is_photo ? ImageCode::kJpeg : ImageCode::kPng, kPhotoQuality)));
}

void append_steps(std::string& bytes, double steps) {
  const auto value = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(steps)));
  bytes += static_cast<char>(value & 0xFFU);
  bytes += static_cast<char>(value >> 8U);
}

/// Returns a layer of a cloud in the format of page/cloud.js.
std::string layer_script(const CloudLayer& layer) {
  constexpr double kMostSteps = 32767.0;
  const std::size_t all = layer.xyz.size() / 3;
  const std::size_t count = std::min(all, CloudLayer::kMostPoints);
  float farthest_m = 1.0F;
  for (const float value : layer.xyz) farthest_m = std::max(farthest_m, std::abs(value));
  const double step_m = static_cast<double>(farthest_m) / kMostSteps;
  std::string bytes;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < count; ++k) {
      append_steps(bytes, static_cast<double>(layer.xyz[3 * (k * all / count) + axis]) / step_m);
    }
  }
  for (std::size_t k = 0; k < count; ++k) {
    const float intensity = std::clamp(layer.intensity[k * all / count], 0.0F, 1.0F);
    bytes += static_cast<char>(static_cast<unsigned char>(std::lround(255.0F * intensity)));
  }
  return fmt::format(
      "<script type=\"text/plain\" data-name=\"{}\" data-colour=\"{}\" data-shown=\"{}\" data-count=\"{}\" "
      "data-step=\"{:.9g}\">{}</script>\n",
      escaped_html(layer.name),
      escaped_html(layer.colour),
      layer.is_shown ? 1 : 0,
      count,
      step_m,
      base64(bytes));
}

/// Returns the colour scale of ranges for page/cloud.js.
std::string ramp_text() {
  constexpr int kStops = 11;
  std::string text;
  for (int i = 0; i < kStops; ++i) {
    text += i > 0 ? ",#" : "#";
    for (const float value : cli::colour_at(static_cast<double>(i) / (kStops - 1))) {
      text += fmt::format("{:02x}", static_cast<int>(std::lround(255.0F * value)));
    }
  }
  return text;
}

std::string boxes_text(const std::vector<CloudBox>& boxes) {
  std::string text;
  for (const CloudBox& box : boxes) {
    text += text.empty() ? "[" : ",[";
    for (std::size_t k = 0; k < box.size(); ++k) {
      text += fmt::format("{}[{:.3f},{:.3f},{:.3f}]", k > 0 ? "," : "", box[k][0], box[k][1], box[k][2]);
    }
    text += "]";
  }
  return "[" + text + "]";
}

/// Returns "" if `svg` is empty.
std::string chart_figure(const std::string& title,
                         const std::vector<ChartSeries>& series,
                         const std::string& svg) {
  if (svg.empty()) return {};
  return fmt::format("<figure><figcaption>{}{}</figcaption><div class=\"shot\">{}</div></figure>\n",
                     escaped_html(title),
                     chart_legend(series),
                     svg);
}

}  // namespace

HtmlReport::HtmlReport(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

void HtmlReport::add(const std::string& group, const std::string& html) {
  if (html.empty()) return;
  if (group != group_) {
    if (!group_.empty()) body_ += "</div>\n";
    if (!group.empty()) body_ += fmt::format("<div class=\"{}\">\n", group);
    group_ = group;
  }
  body_ += html;
}

void HtmlReport::heading(const std::string& text) {
  headings_.push_back(text);
  add("", fmt::format("<h2 id=\"part-{}\">{}</h2>\n", headings_.size(), escaped_html(text)));
}

void HtmlReport::paragraph(const std::string& text) {
  add("", fmt::format("<p>{}</p>\n", escaped_html(text)));
}

std::string HtmlReport::table_html(const char* css_class,
                                   const std::vector<std::string>& header,
                                   const std::vector<std::vector<std::string>>& rows) const {
  constexpr std::size_t kFitsAPhone = 4;  // columns
  const bool is_wide = header.size() > kFitsAPhone;
  std::string html =
      fmt::format("<div class=\"{}{}\"><table>\n<thead><tr>", css_class, is_wide ? " wide" : "");
  for (const std::string& name : header) html += fmt::format("<th>{}</th>", escaped_html(name));
  html += "</tr></thead>\n<tbody>";
  for (const std::vector<std::string>& cells : rows) {
    html += "<tr>";
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const std::string name =
          is_wide && c > 0 ? fmt::format(" data-name=\"{}\"", escaped_html(header[c])) : "";
      html += fmt::format("<td{}>{}</td>", name, escaped_html(cells[c]));
    }
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

void HtmlReport::facts(const std::string& text, const std::vector<Fact>& facts) {
  std::string html = fmt::format("<p>{}</p>\n<dl class=\"facts\">", escaped_html(text));
  for (const Fact& fact : facts) {
    html +=
        fmt::format("<div><dd>{}</dd><dt>{}</dt></div>", escaped_html(fact.value), escaped_html(fact.name));
  }
  add("", html + "</dl>\n");
}

void HtmlReport::table(const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows) {
  add("", table_html("scroll", header, rows));
}

void HtmlReport::text_table(const std::vector<std::string>& header,
                            const std::vector<std::vector<std::string>>& rows) {
  add("", table_html("scroll texts", header, rows));
}

void HtmlReport::folded_table(const std::string& summary,
                              const std::vector<std::string>& header,
                              const std::vector<std::vector<std::string>>& rows) {
  add("",
      fmt::format("<details><summary>{}</summary>\n{}</details>\n",
                  escaped_html(summary),
                  table_html("scroll texts", header, rows)));
}

void HtmlReport::chart(const std::string& title,
                       const std::string& x_label,
                       const std::vector<ChartSeries>& series) {
  add("charts", chart_figure(title, series, curves_svg(x_label, series)));
}

void HtmlReport::bars(const std::string& title,
                      const std::vector<std::string>& labels,
                      const std::vector<ChartSeries>& series) {
  add("charts", chart_figure(title, series, bars_svg(labels, series)));
}

void HtmlReport::add_figure(const Image& size, const std::string& shot, const std::string& caption) {
  constexpr int kWide = 2;  // aspect ratio of pictures with a row of their own
  add("pictures",
      fmt::format("<figure{}><div class=\"shot\">{}</div><figcaption>{}</figcaption></figure>\n",
                  size.width >= kWide * size.height ? " class=\"wide\"" : "",
                  shot,
                  escaped_html(caption)));
}

void HtmlReport::picture(const Image& image, const std::string& caption, PictureCode code) {
  add_figure(image, image_tag(image, code, fmt::format("alt=\"{}\"", escaped_html(caption))), caption);
}

void HtmlReport::compare(const Image& left,
                         const std::string& left_label,
                         const Image& right,
                         const std::string& right_label,
                         const std::string& caption,
                         PictureCode code) {
  const auto tag = [&](const Image& image, const char* css_class, const std::string& label) {
    return image_tag(image, code, fmt::format("class=\"{}\" alt=\"{}\"", css_class, escaped_html(label)));
  };
  add_figure(left,
             fmt::format(
                 "<div class=\"pair\" tabindex=\"0\" role=\"slider\" aria-label=\"{0} to the left of the "
                 "line, {1} to "
                 "the right\" aria-valuemin=\"0\" aria-valuemax=\"100\" aria-valuenow=\"50\">{2}{3}<div "
                 "class=\"bar\"></div><span class=\"tag\" style=\"left:.3rem\">{0}</span><span class=\"tag\" "
                 "style=\"right:.3rem\">{1}</span></div>",
                 escaped_html(left_label),
                 escaped_html(right_label),
                 tag(right, "below", right_label),
                 tag(left, "top", left_label)),
             caption);
}

void HtmlReport::cloud(const std::vector<CloudLayer>& layers,
                       const std::vector<CloudBox>& boxes,
                       const std::string& caption) {
  std::string scripts;
  for (const CloudLayer& layer : layers) {
    if (!layer.xyz.empty()) scripts += layer_script(layer);
  }
  if (scripts.empty()) return;
  add("",
      fmt::format(
          "<figure class=\"cloud\"><canvas tabindex=\"0\" data-ramp=\"{}\" data-boxes=\"{}\"></canvas>"
          "<div class=\"tools\"></div><figcaption>{}</figcaption>\n{}</figure>\n",
          ramp_text(),
          boxes_text(boxes),
          escaped_html(caption),
          scripts));
}

std::string HtmlReport::html() const {
  std::string parts;
  for (std::size_t i = 0; i < headings_.size(); ++i) {
    parts += fmt::format("<a href=\"#part-{}\">{}</a>\n", i + 1, escaped_html(headings_[i]));
  }
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{0}</title>\n<style>{1}</style></head>\n<body>\n<h1>{0}</h1>\n<p class=\"sub\">{2}</p>\n"
      "<nav>{3}</nav>\n{4}{5}<script>{6}</script>\n<script>{7}</script>\n</body></html>\n",
      escaped_html(title_),
      page_file("report.css"),
      escaped_html(subtitle_),
      parts,
      body_,
      group_.empty() ? "" : "</div>\n",
      page_file("report.js"),
      page_file("cloud.js"));
}

void HtmlReport::write(const std::filesystem::path& file) const { write_file_atomically(file, html()); }

}  // namespace simuli
