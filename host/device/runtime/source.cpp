#include "host/device/runtime/source.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>

#include "host/core/base/error.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kRoot = "cl/";

std::optional<fs::path> override_folder() {
  const char* const folder = std::getenv("SIMULI_CL_DIR");
  if (folder == nullptr || *folder == '\0') return std::nullopt;
  return fs::path(folder);
}

std::optional<std::string> find_source(const std::string& path) {
  if (const auto folder = override_folder()) {
    std::error_code ignored;
    if (!fs::is_regular_file(*folder / path, ignored)) return std::nullopt;
    std::ifstream stream(*folder / path, std::ios::binary);
    std::string text((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
    if (!stream) {
      throw Error(ErrorKind::kKernel, fmt::format("can't read kernel file {}", (*folder / path).string()));
    }
    return text;
  }
  const auto files = embedded_files();
  const auto found =
      std::find_if(files.begin(), files.end(), [&](const EmbeddedFile& file) { return file.path == path; });
  if (found == files.end()) return std::nullopt;
  return std::string(found->text);
}

std::string place() {
  const auto folder = override_folder();
  return folder ? "the folder $SIMULI_CL_DIR = " + folder->string()
                : "the embedded kernel files (cl/files.cmake)";
}

std::string_view trimmed_left(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  return text;
}

// Returns the words of a directive after '#'; no value when the line is not a directive.
std::string_view directive(std::string_view line) {
  line = trimmed_left(line);
  if (!line.starts_with('#')) return {};
  return trimmed_left(line.substr(1));
}

std::optional<std::string_view> quoted_include(std::string_view line) {
  constexpr std::string_view kInclude = "include";
  std::string_view rest = directive(line);
  if (!rest.starts_with(kInclude)) return std::nullopt;
  rest = trimmed_left(rest.substr(kInclude.size()));
  if (!rest.starts_with('"')) return std::nullopt;
  rest.remove_prefix(1);
  const std::size_t end = rest.find('"');
  if (end == std::string_view::npos) return std::nullopt;
  return rest.substr(0, end);
}

bool is_pragma_once(std::string_view line) {
  constexpr std::string_view kPragma = "pragma";
  const std::string_view rest = directive(line);
  return rest.starts_with(kPragma) && trimmed_left(rest.substr(kPragma.size())).starts_with("once");
}

class Expander {
 public:
  // `path` is relative to cl/; #line directives contain `shown`.
  void splice(const fs::path& path, const std::string& shown, std::string_view text) {
    out_ += fmt::format("#line 1 \"{}\"\n", shown);
    for (std::size_t number = 1; !text.empty(); ++number) {
      const std::size_t newline = text.find('\n');
      std::string_view line = text.substr(0, newline);
      text.remove_prefix(newline == std::string_view::npos ? text.size() : newline + 1);
      if (line.ends_with('\r')) line.remove_suffix(1);
      if (const auto wanted = quoted_include(line)) {
        include(path, shown, number, *wanted);
      } else if (!is_pragma_once(line)) {
        out_ += line;
      }
      out_ += '\n';
    }
  }

  std::set<std::string> spliced;
  [[nodiscard]] std::string take() { return std::move(out_); }

 private:
  void include(const fs::path& from, const std::string& shown, std::size_t number, std::string_view wanted) {
    const std::string from_folder = (from.parent_path() / wanted).lexically_normal().generic_string();
    const std::string from_root = fs::path(wanted).lexically_normal().generic_string();
    std::string from_project;
    if (from_root.starts_with(kRoot)) from_project = from_root.substr(kRoot.size());
    for (const std::string& candidate : {from_folder, from_root, from_project}) {
      if (candidate.empty()) continue;
      if (spliced.contains(candidate)) return;
      if (const auto text = find_source(candidate)) {
        spliced.insert(candidate);
        splice(candidate, std::string(kRoot) + candidate, *text);
        out_ += fmt::format("#line {} \"{}\"", number + 1, shown);
        return;
      }
    }
    throw Error(ErrorKind::kKernel,
                fmt::format("{}:{}: include \"{}\" is not in {}", shown, number, wanted, place()));
  }

  std::string out_;
};

}  // namespace

std::string load_source(std::string_view path) {
  auto text = find_source(std::string(path));
  if (!text) throw Error(ErrorKind::kKernel, fmt::format("kernel file cl/{} is not in {}", path, place()));
  return *std::move(text);
}

std::string expand_file(std::string_view path) {
  const std::string text = load_source(path);
  Expander expander;
  expander.spliced.insert(std::string(path));
  expander.splice(fs::path(path), std::string(kRoot) + std::string(path), text);
  return expander.take();
}

std::string expand_text(std::string_view name, std::string_view text) {
  Expander expander;
  expander.splice(fs::path(name), std::string(name), text);
  return expander.take();
}

}  // namespace simuli
