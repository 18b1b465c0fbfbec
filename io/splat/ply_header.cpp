#include "io/splat/ply_header.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <fmt/format.h>
#include <string_view>
#include <system_error>
#include <utility>

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

/// Headers of the standard layout have at most about 4 kB; this bounds the search in other files.
constexpr std::size_t kMaxHeaderBytes = std::size_t{1} << 20U;

constexpr std::array<std::pair<std::string_view, PlyType>, 16> kTypeNames{{
    {"char", PlyType::kInt8},
    {"int8", PlyType::kInt8},
    {"uchar", PlyType::kUint8},
    {"uint8", PlyType::kUint8},
    {"short", PlyType::kInt16},
    {"int16", PlyType::kInt16},
    {"ushort", PlyType::kUint16},
    {"uint16", PlyType::kUint16},
    {"int", PlyType::kInt32},
    {"int32", PlyType::kInt32},
    {"uint", PlyType::kUint32},
    {"uint32", PlyType::kUint32},
    {"float", PlyType::kFloat32},
    {"float32", PlyType::kFloat32},
    {"double", PlyType::kFloat64},
    {"float64", PlyType::kFloat64},
}};

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> words;
  constexpr std::string_view kBlanks = " \t";
  for (std::size_t at = line.find_first_not_of(kBlanks); at != std::string_view::npos;) {
    const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
    words.push_back(line.substr(at, end - at));
    at = line.find_first_not_of(kBlanks, end);
  }
  return words;
}

/// Quotes file content for a message: shortened, and without bytes that would break the line.
std::string in_quotes(std::string_view text) {
  std::string out(text.substr(0, 80));
  for (char& c : out) {
    if (c < ' ' || c > '~') c = '?';
  }
  return '"' + out + '"';
}

class HeaderParser {
 public:
  HeaderParser(const std::string& bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  PlyHeader parse() {
    if (next_line() != "ply") refuse("magic", in_quotes(line_), "\"ply\"");
    parse_format();
    while (next_line() != "end_header") parse_line(split(line_));
    if (!has_vertex_) refuse("element vertex", "none", "one");
    header_.body = at_;
    check_size();
    return std::move(header_);
  }

 private:
  [[noreturn]] void refuse(const std::string& field, const std::string& found, const std::string& allowed) {
    throw_input_error(file_, fmt::format("header line {}: {}", line_number_, field), found, allowed);
  }

  std::string_view next_line() {
    const std::size_t limit = std::min(bytes_.size(), kMaxHeaderBytes);
    const std::size_t end = bytes_.find('\n', at_);
    ++line_number_;
    if (end == std::string::npos || end >= limit) {
      refuse("header", "no further line", "a header that ends with end_header");
    }
    line_ = std::string_view(bytes_).substr(at_, end - at_);
    if (!line_.empty() && line_.back() == '\r') line_.remove_suffix(1);
    at_ = end + 1;
    return line_;
  }

  void parse_format() {
    do {
      next_line();
    } while (line_.starts_with("comment") || line_.starts_with("obj_info"));
    if (line_ == "format ascii 1.0") {
      header_.format = PlyFormat::kAscii;
    } else if (line_ == "format binary_little_endian 1.0") {
      header_.format = PlyFormat::kLittleEndian;
    } else if (line_ == "format binary_big_endian 1.0") {
      header_.format = PlyFormat::kBigEndian;
    } else {
      refuse("format", in_quotes(line_), "ascii, binary_little_endian or binary_big_endian 1.0");
    }
  }

  void parse_line(const std::vector<std::string_view>& words) {
    const std::string_view key = words.empty() ? std::string_view() : words[0];
    if (key == "comment") {
      const std::size_t start = std::min(line_.size(), std::size_t{8});
      header_.comments.emplace_back(line_.substr(start));
    } else if (key == "element") {
      parse_element(words);
    } else if (key == "property") {
      parse_property(words);
    } else if (key != "obj_info") {
      refuse("keyword", in_quotes(line_), "comment, obj_info, element, property or end_header");
    }
  }

  void parse_element(const std::vector<std::string_view>& words) {
    std::uint64_t count = 0;
    bool good = words.size() == 3;
    if (good) {
      const char* end = words[2].data() + words[2].size();
      const auto [stop, error] = std::from_chars(words[2].data(), end, count);
      good = stop == end && error == std::errc();
    }
    if (!good) refuse("element", in_quotes(line_), "\"element NAME COUNT\" with a count below 2^64");
    if (words[1] == "vertex") {
      if (has_vertex_) refuse("element", in_quotes(words[1]), "vertex once");
      header_.vertices = count;
    }
    has_element_ = true;
    header_.other_elements = has_vertex_;
    in_vertex_ = words[1] == "vertex";
    has_vertex_ = has_vertex_ || in_vertex_;
    count_ = count;
  }

  void parse_property(const std::vector<std::string_view>& words) {
    if (!has_element_) refuse("property", in_quotes(line_), "an element before it");
    if (header_.other_elements) return;  // of an element after the vertices, which is ignored
    if (words.size() != 3) refuse("property", in_quotes(line_), "\"property TYPE NAME\" with a scalar type");
    const auto* known = std::find_if(
        kTypeNames.begin(), kTypeNames.end(), [&](const auto& entry) { return entry.first == words[1]; });
    if (known == kTypeNames.end()) {
      refuse("property type", in_quotes(words[1]), "char, uchar, short, ushort, int, uint, float or double");
    }
    if (!in_vertex_) return skip(ply_size(known->second));
    std::string name(words[2]);
    if (header_.find(name) >= 0) refuse("property", "a second " + in_quotes(name), "each name once");
    header_.properties.push_back({std::move(name), known->second, header_.vertex_bytes});
    header_.vertex_bytes += ply_size(known->second);
  }

  /// Handles a property of an element before the vertices.
  void skip(std::uint64_t bytes) {
    // At most the file's size, so that sums stay far below 2^64.
    if (count_ > bytes_.size()) refuse("element", fmt::format("{}", count_), "as many as the file holds");
    header_.bytes_in_front += count_ * bytes;
    header_.values_in_front += count_;
  }

  /// Checks before allocation that the file can contain the declared vertices.
  void check_size() {
    if (header_.properties.empty()) refuse("element vertex", "no property", "at least one");
    const bool ascii = header_.format == PlyFormat::kAscii;
    const std::uint64_t all = bytes_.size() - header_.body;
    const std::uint64_t in_front = ascii ? 2 * header_.values_in_front : header_.bytes_in_front;
    const std::uint64_t left = all - std::min(in_front, all);
    // A value of an ascii file has at least a digit and a separator, the last one only a digit.
    const std::size_t vertex_bytes = ascii ? 2 * header_.properties.size() : header_.vertex_bytes;
    const std::uint64_t fits = (left + (ascii ? 1 : 0)) / vertex_bytes;
    if (header_.vertices > fits) {
      refuse("element vertex",
             fmt::format("{} vertices", header_.vertices),
             fmt::format("at most {} in the {} bytes that follow", fits, left));
    }
    const std::uint64_t used = header_.vertices * vertex_bytes;
    if (!ascii && !header_.other_elements &&
        !is_blank(std::string_view(bytes_).substr(bytes_.size() - (left - used)))) {
      refuse("element vertex",
             fmt::format("{} vertices and {} bytes behind them", header_.vertices, left - used),
             "nothing behind the last vertex");
    }
  }

  const std::string& bytes_;
  const std::string& file_;
  PlyHeader header_;
  std::size_t at_ = 0;
  std::size_t line_number_ = 0;
  std::string_view line_;
  bool in_vertex_ = false, has_vertex_ = false, has_element_ = false;
  std::uint64_t count_ = 0;  // of the current element
};

}  // namespace

int PlyHeader::find(const std::string& name) const {
  const auto found = std::find_if(
      properties.begin(), properties.end(), [&](const PlyProperty& p) { return p.name == name; });
  return found == properties.end() ? -1 : static_cast<int>(found - properties.begin());
}

std::size_t ply_size(PlyType type) {
  switch (type) {
    case PlyType::kInt8:
    case PlyType::kUint8:
      return 1;
    case PlyType::kInt16:
    case PlyType::kUint16:
      return 2;
    case PlyType::kInt32:
    case PlyType::kUint32:
    case PlyType::kFloat32:
      return 4;
    case PlyType::kFloat64:
      return 8;
  }
  throw Error(ErrorKind::kInternal, "PLY type without a size");
}

bool is_blank(std::string_view rest) {
  constexpr std::size_t kMost = 4;
  return rest.size() <= kMost &&
         rest.find_first_not_of(std::string_view("\n\r \t\0", 5)) == std::string_view::npos;
}

PlyHeader parse_ply_header(const std::string& bytes, const std::string& file) {
  return HeaderParser(bytes, file).parse();
}

}  // namespace simuli
