#pragma once
// Reads Prometheus' text format, and throws std::runtime_error for what its documents don't allow.
#include <charconv>
#include <map>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

namespace simuli::test {

class MetricsText {
 public:
  explicit MetricsText(const std::string& text) {
    if (text.empty() || text.back() != '\n') fail("no end of line at the end");
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = text.find('\n', at);
      read(text.substr(at, end - at));
      at = end + 1;
    }
    for (const auto& [name, type] : types_) {
      if (type == "histogram") check_histogram(name);
    }
  }
  /// Of a sample by its name and labels, as they are written. Throws for one that there is not.
  [[nodiscard]] double value(const std::string& sample) const { return values_.at(sample); }
  [[nodiscard]] bool has(const std::string& sample) const { return values_.contains(sample); }

 private:
  [[noreturn]] static void fail(const std::string& why) { throw std::runtime_error(why); }

  void read(const std::string& line) {
    static const std::regex help("# HELP ([a-zA-Z_:][a-zA-Z0-9_:]*) ([^\\\\]*)");
    static const std::regex type("# TYPE ([a-zA-Z_:][a-zA-Z0-9_:]*) (counter|gauge|histogram)");
    static const std::string label = "[a-zA-Z_][a-zA-Z0-9_]*=\"[^\"\\\\]*\"";
    static const std::regex sample("([a-zA-Z_:][a-zA-Z0-9_:]*)(\\{" + label + "(?:," + label +
                                   ")*\\})? (\\S+)");
    std::smatch found;
    if (std::regex_match(line, found, help)) {
      if (!helps_.insert(found[1]).second) fail("described twice: " + line);
    } else if (std::regex_match(line, found, type)) {
      if (!types_.emplace(found[1], found[2]).second) fail("a type twice: " + line);
    } else if (std::regex_match(line, found, sample)) {
      read_sample(line, found[1], found[1].str() + found[2].str(), found[3]);
    } else {
      fail("no line of this format: " + line);
    }
  }

  void read_sample(const std::string& line,
                   const std::string& name,
                   const std::string& key,
                   const std::string& number) {
    double value = 0.0;
    const auto read = std::from_chars(number.data(), number.data() + number.size(), value);
    if (read.ec != std::errc{} || read.ptr != number.data() + number.size()) fail("no number: " + line);
    const std::string type = type_of(name);
    if (type != "gauge" && value < 0.0) fail("less than nothing: " + line);
    if (!values_.emplace(key, value).second) fail("twice: " + line);
    order_.push_back(key);
  }

  [[nodiscard]] std::string type_of(const std::string& name) const {
    if (const auto own = types_.find(name); own != types_.end()) return own->second;
    for (const std::string suffix : {"_bucket", "_sum", "_count"}) {
      if (!name.ends_with(suffix)) continue;
      const auto of = types_.find(name.substr(0, name.size() - suffix.size()));
      if (of != types_.end() && of->second == "histogram") return of->second;
    }
    fail("without a type before it: " + name);
  }

  /// Buckets never fall, the last is +Inf, and as large as the count.
  void check_histogram(const std::string& name) const {
    static const std::regex bucket("_bucket\\{(.*?),?le=\"([^\"]*)\"\\}");
    std::map<std::string, std::pair<double, std::string>> last;  // by labels: value and bound
    for (const std::string& key : order_) {
      std::smatch found;
      const std::string rest = key.rfind(name + "_bucket", 0) == 0 ? key.substr(name.size()) : std::string();
      if (!std::regex_match(rest, found, bucket)) continue;
      const double value = values_.at(key);
      if (last.contains(found[1]) && value < last[found[1]].first) fail("falls: " + key);
      last[found[1]] = {value, found[2]};
    }
    for (const auto& [labels, end] : last) {
      const std::string behind = labels.empty() ? "" : "{" + labels + "}";
      const auto count = values_.find(name + "_count" + behind);
      if (end.second != "+Inf") fail("ends before +Inf: " + name);
      if (count == values_.end() || count->second != end.first) fail("another count: " + name);
      if (!values_.contains(name + "_sum" + behind)) fail("no sum: " + name);
    }
  }

  std::set<std::string> helps_;
  std::map<std::string, std::string> types_;
  std::map<std::string, double> values_;
  std::vector<std::string> order_;
};

}  // namespace simuli::test
