// PLY: the header's lines, or records of the elements that it tells of.
#include <sstream>
#include <string_view>
#include <vector>

#include "tests/fuzz/mutate/mutate.hpp"

namespace simuli::test {
namespace {

constexpr std::string_view kEnd = "end_header\n";

struct Element {
  std::string line;        // "element vertex 3\n"
  std::size_t count = 0;   // records
  std::size_t stride = 0;  // bytes of one
  std::size_t at = 0;      // in the body
};

std::size_t bytes_of(const std::string& type) {
  if (type == "double" || type == "float64") return 8;
  if (type.find("char") != std::string::npos || type.ends_with("int8")) return 1;
  if (type.find("short") != std::string::npos || type.ends_with("int16")) return 2;
  return 4;
}

std::vector<Element> elements_of(const std::string& header) {
  std::vector<Element> elements;
  std::istringstream in(header);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string first, second;
    words >> first >> second;
    if (first == "element") {
      Element element{line + '\n', 0, 0, 0};
      words >> element.count;
      if (!elements.empty()) {
        const Element& before = elements.back();
        element.at = before.at + before.count * before.stride;
      }
      elements.push_back(element);
    } else if (first == "property" && !elements.empty()) {
      elements.back().stride += bytes_of(second);
    }
  }
  return elements;
}

/// One record more, or one less, and the header says so.
std::string with_another_count(const std::string& header,
                               std::string body,
                               const Element& e,
                               Choice& choice) {
  const std::size_t at = e.at + choice.below(e.count) * e.stride;
  const bool more = choice.below(2) == 0;
  if (more) {
    body.insert(at, body.substr(at, e.stride));
  } else {
    body.erase(at, e.stride);
  }
  std::string line = e.line.substr(0, e.line.rfind(' ') + 1);
  line += std::to_string(more ? e.count + 1 : e.count - 1) + '\n';
  std::string changed = header;
  changed.replace(changed.find(e.line), e.line.size(), line);
  return changed + body;
}

}  // namespace

std::optional<std::string> mutated_ply(const std::string& file, Choice& choice) {
  const std::size_t end = file.find(kEnd);
  if (end == std::string::npos) return std::nullopt;
  const std::string header = file.substr(0, end), body = file.substr(end);  // it begins with kEnd
  if (choice.below(3) == 0) {
    const std::optional<std::string> changed = mutated_text(header, choice);
    if (!changed) return std::nullopt;
    return *changed + (changed->ends_with('\n') ? "" : "\n") + body;
  }
  const std::string values = body.substr(kEnd.size());
  if (header.find("format ascii") != std::string::npos) {
    const std::optional<std::string> changed = mutated_text(values, choice);
    return header + std::string(kEnd) + (changed ? *changed : choice.change(values));
  }
  const std::vector<Element> elements = elements_of(header);
  if (!elements.empty() && choice.below(3) == 0) {
    const Element& element = elements[choice.below(elements.size())];
    const bool fits = element.count > 0 && element.stride > 0 && element.count < values.size() &&
                      element.at < values.size() && header.find(element.line) != std::string::npos &&
                      element.count * element.stride <= values.size() - element.at;
    if (fits) {
      Element shifted = element;
      shifted.at += kEnd.size();
      return with_another_count(header, body, shifted, choice);
    }
  }
  return header + std::string(kEnd) + mutated_numbers(values, sizeof(float), choice);
}

}  // namespace simuli::test
