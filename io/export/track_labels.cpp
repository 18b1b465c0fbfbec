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
  std::array<std::string_view, 3> labels;  // in the order of LabelNames; empty: no label for this word
};

/// More specific words come first.
constexpr std::array kLabelWords{LabelWord{"static", {"", "", ""}},
                                 LabelWord{"tram", {"", "Tram", ""}},
                                 LabelWord{"train", {"", "Tram", ""}},
                                 LabelWord{"pedestrian", {"person", "Pedestrian", "human.pedestrian.adult"}},
                                 LabelWord{"person", {"person", "Pedestrian", "human.pedestrian.adult"}},
                                 LabelWord{"people", {"person", "Pedestrian", "human.pedestrian.adult"}},
                                 LabelWord{"human", {"person", "Pedestrian", "human.pedestrian.adult"}},
                                 LabelWord{"walker", {"person", "Pedestrian", "human.pedestrian.adult"}},
                                 LabelWord{"cyclist", {"rider", "Cyclist", "vehicle.bicycle"}},
                                 LabelWord{"bicyclist", {"rider", "Cyclist", "vehicle.bicycle"}},
                                 LabelWord{"motorcyclist", {"rider", "", "vehicle.motorcycle"}},
                                 LabelWord{"rider", {"rider", "Cyclist", "vehicle.bicycle"}},
                                 LabelWord{"bicycle", {"rider", "Cyclist", "vehicle.bicycle"}},
                                 LabelWord{"motorcycle", {"rider", "", "vehicle.motorcycle"}},
                                 LabelWord{"bike", {"rider", "Cyclist", "vehicle.bicycle"}},
                                 LabelWord{"motorbike", {"rider", "", "vehicle.motorcycle"}},
                                 LabelWord{"trailer", {"trailer", "", "vehicle.trailer"}},
                                 LabelWord{"bus", {"bus", "", "vehicle.bus.rigid"}},
                                 LabelWord{"truck", {"heavy_truck", "Truck", "vehicle.truck"}},
                                 LabelWord{"automobile", {"automobile", "Car", "vehicle.car"}},
                                 LabelWord{"car", {"automobile", "Car", "vehicle.car"}},
                                 LabelWord{"van", {"automobile", "Van", "vehicle.car"}},
                                 LabelWord{"vehicle", {"automobile", "Car", "vehicle.car"}}};

/// Returns the words of a text in lower case.
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

/// Returns an empty text without a label.
std::string_view label_of(const std::string& kind, LabelNames names) {
  const std::vector<std::string> words = words_of(kind);
  for (const LabelWord& known : kLabelWords) {
    if (std::find(words.begin(), words.end(), known.word) != words.end())
      return known.labels[static_cast<std::size_t>(names)];
  }
  return {};
}

}  // namespace

std::string label_class_of(const std::string& kind, LabelNames names) {
  const std::string_view label = label_of(kind, names);
  return label.empty() ? kind : std::string(label);
}

bool has_label_class(const std::string& kind, LabelNames names) { return !label_of(kind, names).empty(); }

}  // namespace simuli
