#include "io/export/track_labels.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>
#include <vector>

namespace simuli {
namespace {

struct LabelWord {
  std::string_view word;
  std::string_view label;  // empty: whatever else it says, it is none of them
};

/// What says more comes first.
constexpr std::array kLabelWords{LabelWord{"static", ""},
                                 LabelWord{"tram", ""},
                                 LabelWord{"train", ""},
                                 LabelWord{"pedestrian", "person"},
                                 LabelWord{"person", "person"},
                                 LabelWord{"people", "person"},
                                 LabelWord{"human", "person"},
                                 LabelWord{"walker", "person"},
                                 LabelWord{"cyclist", "rider"},
                                 LabelWord{"bicyclist", "rider"},
                                 LabelWord{"motorcyclist", "rider"},
                                 LabelWord{"rider", "rider"},
                                 LabelWord{"bicycle", "rider"},
                                 LabelWord{"motorcycle", "rider"},
                                 LabelWord{"bike", "rider"},
                                 LabelWord{"motorbike", "rider"},
                                 LabelWord{"trailer", "trailer"},
                                 LabelWord{"bus", "bus"},
                                 LabelWord{"truck", "heavy_truck"},
                                 LabelWord{"automobile", "automobile"},
                                 LabelWord{"car", "automobile"},
                                 LabelWord{"van", "automobile"},
                                 LabelWord{"vehicle", "automobile"}};

/// In small letters, without what stands between them.
std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> out(1);
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalpha(byte) != 0) {
      out.back() += static_cast<char>(std::tolower(byte));
    } else if (!out.back().empty()) {
      out.emplace_back();
    }
  }
  return out;
}

}  // namespace

std::string label_class_of(const std::string& kind) {
  const std::vector<std::string> words = words_of(kind);
  for (const LabelWord& known : kLabelWords) {
    if (std::find(words.begin(), words.end(), known.word) == words.end()) continue;
    return known.label.empty() ? kind : std::string(known.label);
  }
  return kind;
}

}  // namespace simuli
