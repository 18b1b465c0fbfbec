#include "host/cli/draw/html_report.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <limits>
#include <string_view>
#include <utility>

#include "io/base/file.hpp"

namespace simuli {
namespace {

constexpr std::string_view kStyle = R"css(
:root { color-scheme: light dark; --line: #8884; --soft: #888; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1320px; margin: 2rem auto; padding: 0 1rem; }
h1 { margin-bottom: 0; } h2 { margin-top: 2.2rem; border-bottom: 1px solid var(--line); }
.sub, figcaption, .axis { color: var(--soft); }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: .2rem .8rem .2rem 0; border-bottom: 1px solid var(--line); text-align: right; }
th:first-child, td:first-child { text-align: left; }
figure { display: inline-block; vertical-align: top; margin: 1rem 1rem 0 0; max-width: 100%; } figure img { max-width: 100%; display: block; }
.charts { display: flex; flex-wrap: wrap; gap: 1rem; } .charts figure { margin: 0; }
svg text { fill: currentColor; font: 11px system-ui, sans-serif; }
.pair { position: relative; width: fit-content; max-width: 100%; cursor: ew-resize; touch-action: none; }
.pair img { display: block; max-width: 100%; user-select: none; -webkit-user-drag: none; }
.pair .top { position: absolute; inset: 0; clip-path: inset(0 calc(100% - var(--at, 50%)) 0 0); }
.pair .bar { position: absolute; top: 0; bottom: 0; left: var(--at, 50%); width: 2px; background: #fff;
  box-shadow: 0 0 3px #000; }
.pair .tag { position: absolute; bottom: .3rem; background: #000a; color: #fff; padding: 0 .4rem; font-size: 12px; }
)css";

constexpr std::string_view kScript = R"js(
for (const pair of document.querySelectorAll('.pair')) {
  const move = e => {
    const box = pair.getBoundingClientRect();
    const at = Math.min(Math.max((e.clientX - box.left) / box.width, 0), 1);
    pair.style.setProperty('--at', (100 * at).toFixed(2) + '%');
  };
  pair.addEventListener('pointerdown', e => { pair.setPointerCapture(e.pointerId); move(e); });
  pair.addEventListener('pointermove', e => { if (e.buttons) move(e); });
}
)js";

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8U | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) out += k <= count ? kDigits[bits >> (18 - 6 * k) & 63U] : '=';
  }
  return out;
}

std::string png_tag(const Image& image, std::string_view css_class) {
  return fmt::format(R"(<img class="{}" width="{}" height="{}" alt="" src="data:image/png;base64,{}">)",
                     css_class,
                     image.width,
                     image.height,
                     base64(encode_image(image, ImageCode::kPng)));
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// 1, 2 or 5 times a power of ten: about `count` steps over `span`.
double nice_step(double span, int count) {
  const double raw = span / count;
  const double power = std::pow(10.0, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= raw) return factor * power;
  }
  return 10.0 * power;
}

}  // namespace

HtmlReport::HtmlReport(std::string title, std::string subtitle)
    : title_(std::move(title)), subtitle_(std::move(subtitle)) {}

void HtmlReport::heading(const std::string& text) { body_ += fmt::format("<h2>{}</h2>\n", escaped(text)); }

void HtmlReport::paragraph(const std::string& text) { body_ += fmt::format("<p>{}</p>\n", escaped(text)); }

void HtmlReport::table(const std::vector<std::string>& header,
                       const std::vector<std::vector<std::string>>& rows) {
  const auto row = [&](const std::vector<std::string>& cells, const char* tag) {
    body_ += "<tr>";
    for (const std::string& cell : cells) body_ += fmt::format("<{0}>{1}</{0}>", tag, escaped(cell));
    body_ += "</tr>\n";
  };
  body_ += "<table>\n";
  row(header, "th");
  for (const std::vector<std::string>& cells : rows) row(cells, "td");
  body_ += "</table>\n";
}

void HtmlReport::chart(const std::string& title,
                       const std::string& x_label,
                       const std::vector<ChartSeries>& series) {
  constexpr int kWidth = 420, kHeight = 240, kLeft = 56, kRight = 12, kTop = 12, kBottom = 34, kSteps = 5;
  constexpr std::array<const char*, 4> kColours{"#2a78d6", "#d6612a", "#3a9a4a", "#9a4ab0"};
  Range x, y;
  std::size_t drawn = 0;
  for (const ChartSeries& s : series) {
    for (std::size_t i = 0; i < s.x.size(); ++i) {
      if (!std::isfinite(s.y[i])) continue;
      x.include(s.x[i]);
      y.include(s.y[i]);
      ++drawn;
    }
  }
  if (drawn < 2 || !(x.high > x.low)) return;
  if (!(y.high > y.low)) {  // a constant gets a band around it
    const double around = std::max(std::abs(y.high), 1.0) * 0.01;
    y = {y.low - around, y.high + around};
  }
  const auto px = [&](double v) {
    return kLeft + (v - x.low) / (x.high - x.low) * (kWidth - kLeft - kRight);
  };
  const auto py = [&](double v) {
    return kHeight - kBottom - (v - y.low) / (y.high - y.low) * (kHeight - kTop - kBottom);
  };
  std::string svg = fmt::format(R"(<svg width="{0}" height="{1}" viewBox="0 0 {0} {1}">)", kWidth, kHeight);
  const auto line = [&](double x0, double y0, double x1, double y1) {
    svg += fmt::format(
        R"(<line x1="{:.1f}" y1="{:.1f}" x2="{:.1f}" y2="{:.1f}" stroke="currentColor" stroke-opacity=".2"/>)",
        x0,
        y0,
        x1,
        y1);
  };
  const auto text = [&](double at_x, double at_y, const char* anchor, const std::string& what) {
    svg += fmt::format(
        R"(<text x="{:.1f}" y="{:.1f}" text-anchor="{}">{}</text>)", at_x, at_y, anchor, escaped(what));
  };
  const double x_step = nice_step(x.high - x.low, kSteps), y_step = nice_step(y.high - y.low, kSteps);
  for (double v = std::ceil(x.low / x_step) * x_step; v <= x.high; v += x_step) {
    line(px(v), kTop, px(v), kHeight - kBottom);
    text(px(v), kHeight - kBottom + 14, "middle", fmt::format("{:g}", v));
  }
  for (double v = std::ceil(y.low / y_step) * y_step; v <= y.high; v += y_step) {
    line(kLeft, py(v), kWidth - kRight, py(v));
    text(kLeft - 6, py(v) + 4, "end", fmt::format("{:g}", std::abs(v) < 1e-9 * y_step ? 0.0 : v));
  }
  text(0.5 * (kLeft + kWidth - kRight), kHeight - 4, "middle", x_label);
  std::string legend;
  for (std::size_t s = 0; s < series.size(); ++s) {
    const char* const colour = kColours[s % kColours.size()];
    std::string points;
    for (std::size_t i = 0; i < series[s].x.size(); ++i) {
      if (std::isfinite(series[s].y[i])) {
        points += fmt::format("{:.1f},{:.1f} ", px(series[s].x[i]), py(series[s].y[i]));
      }
    }
    svg +=
        fmt::format(R"(<polyline fill="none" stroke="{}" stroke-width="1.6" points="{}"/>)", colour, points);
    if (series.size() > 1) {
      legend += fmt::format(R"( <span style="color:{}">&#9632;</span> {})", colour, escaped(series[s].name));
    }
  }
  svg += "</svg>";
  // Charts in a row flow beside each other.
  constexpr std::string_view kOpen = "<div class=\"charts\">\n", kClose = "</div><!--charts-->\n";
  const std::string figure =
      fmt::format("<figure><figcaption>{}{}</figcaption>{}</figure>\n", escaped(title), legend, svg);
  const bool continues =
      body_.size() >= kClose.size() && std::string_view(body_).substr(body_.size() - kClose.size()) == kClose;
  if (continues) body_.resize(body_.size() - kClose.size());
  if (!continues) body_ += kOpen;
  body_ += figure;
  body_ += kClose;
}

void HtmlReport::picture(const Image& image, const std::string& caption) {
  body_ += fmt::format(
      "<figure>{}<figcaption>{}</figcaption></figure>\n", png_tag(image, "one"), escaped(caption));
}

void HtmlReport::compare(const Image& left,
                         const std::string& left_label,
                         const Image& right,
                         const std::string& right_label,
                         const std::string& caption) {
  body_ += fmt::format(
      "<figure><div class=\"pair\">{}{}<div class=\"bar\"></div><span class=\"tag\" style=\"left:.3rem\">{}"
      "</span><span class=\"tag\" "
      "style=\"right:.3rem\">{}</span></div><figcaption>{}</figcaption></figure>\n",
      png_tag(right, "below"),
      png_tag(left, "top"),
      escaped(left_label),
      escaped(right_label),
      escaped(caption));
}

std::string HtmlReport::html() const {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<title>{0}</title>\n<style>{2}</style></head>\n<body>\n<h1>{0}</h1>\n<p class=\"sub\">{1}</p>\n"
      "{3}<script>{4}</script>\n</body></html>\n",
      escaped(title_),
      escaped(subtitle_),
      kStyle,
      body_,
      kScript);
}

void HtmlReport::write(const std::filesystem::path& file) const { write_file_atomically(file, html()); }

}  // namespace simuli
