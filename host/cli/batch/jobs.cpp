#include "host/cli/batch/jobs.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <map>
#include <numeric>
#include <set>
#include <utility>

#include "host/base/error.hpp"
#include "host/base/names.hpp"
#include "host/cli/batch/record.hpp"
#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> words_of(JsonObject& object, const std::string& key) {
  std::vector<std::string> words;
  const Json& list = object.get(key);
  const bool is_list = list.is_array() && !list.empty();
  if (is_list) {
    for (const Json& word : list) {
      if (word.is_string()) {
        words.push_back(word.get<std::string>());
      } else if (word.is_number()) {
        words.push_back(word.dump());
      }
    }
  }
  if (!is_list || words.size() != list.size()) {
    throw_input_error(object.file(),
                      object.field(key),
                      list.dump(-1, ' ', false, Json::error_handler_t::replace),
                      "a list of a command's words: texts and numbers");
  }
  return words;
}

Job read_job(JsonObject& object, const std::vector<std::string>& first, const AskWork& ask) {
  Job job;
  job.words = words_of(object, "run");
  job.words.insert(job.words.begin(), first.begin(), first.end());
  try {
    job.work = ask(job.words);
  } catch (const Error& error) {
    throw Error(ErrorKind::kInput,
                fmt::format("{}: {}: {}", object.file(), object.field("run"), error.what()));
  }
  if (object.has("stdout")) {
    job.stdout_file = object.text("stdout");
    job.work.makes.push_back(job.stdout_file);
  }
  for (const std::string& path : job.work.makes) {
    if (fs::path(path).lexically_normal().relative_path().empty() || path.empty()) {
      throw_input_error(object.file(), object.field("stdout"), '"' + path + '"', "the name of a file");
    }
  }
  if (job.work.makes.empty()) {
    throw_input_error(object.file(),
                      object.field("run"),
                      "a command without an output",
                      "one that makes a file or folder, or \"stdout\": FILE beside it");
  }
  job.name = object.has("name") ? object.text("name") : job.output();
  return job;
}

/// The same for every way to say it.
fs::path place(const std::string& path) {
  const fs::path absolute = fs::absolute(path).lexically_normal();
  std::error_code failed;
  fs::path known = fs::weakly_canonical(absolute, failed);
  if (failed) known = absolute;
  return known.has_filename() ? known : known.parent_path();
}

bool is_within(const fs::path& path, const fs::path& folder) {
  return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

/// Who makes what.
class Makers {
 public:
  explicit Makers(std::string file) : file_(std::move(file)) {}

  void add(const std::vector<Job>& jobs, std::size_t i) {
    const Work& work = jobs[i].work;
    for (const std::string& path : work.makes) claim(jobs, i, path);
    for (const std::string& path : work.unfinished) claim(jobs, i, path);
    claim(jobs, i, record_beside(jobs[i].output()).string());
  }

  /// Outputs within the output of another job.
  void refuse_nested(const std::vector<Job>& jobs) const {
    for (const auto& [path, i] : makers_) {
      const std::size_t* const above = maker_above(path.parent_path());
      if (above != nullptr && *above != i) refuse(i, path, jobs[*above], "within an output of");
    }
  }

  /// Jobs that make what is read there, or something within.
  [[nodiscard]] std::set<std::size_t> of(const std::string& read) const {
    const fs::path path = place(read);
    std::set<std::size_t> makers;
    if (const std::size_t* const above = maker_above(path)) makers.insert(*above);
    for (auto at = makers_.lower_bound(path); at != makers_.end() && is_within(at->first, path); ++at) {
      makers.insert(at->second);
    }
    return makers;
  }

 private:
  void claim(const std::vector<Job>& jobs, std::size_t i, const std::string& path) {
    const auto [at, is_new] = makers_.emplace(place(path), i);
    if (!is_new) refuse(i, path, jobs[at->second], "an output of");
  }
  [[nodiscard]] const std::size_t* maker_above(fs::path path) const {
    for (;;) {
      const auto at = makers_.find(path);
      if (at != makers_.end()) return &at->second;
      const fs::path above = path.parent_path();
      if (above == path) return nullptr;
      path = above;
    }
  }
  [[noreturn]] void refuse(std::size_t i, const fs::path& path, const Job& other, const char* how) const {
    throw_input_error(file_,
                      fmt::format("jobs[{}].run", i),
                      fmt::format("{}, {} job \"{}\", too", path.string(), how, other.name),
                      "each output once");
  }

  std::string file_;
  std::map<fs::path, std::size_t> makers_;
};

void link_jobs(const std::string& file, std::vector<Job>& jobs) {
  Makers makers(file);
  for (std::size_t i = 0; i < jobs.size(); ++i) makers.add(jobs, i);
  makers.refuse_nested(jobs);
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    std::set<std::size_t> needs;
    for (const std::string& read : jobs[i].work.reads) {
      for (const std::size_t maker : makers.of(read)) {
        if (maker < i) {
          needs.insert(maker);
          continue;
        }
        throw_input_error(file,
                          fmt::format("jobs[{}].run", i),
                          maker == i
                              ? fmt::format("{}, which it reads and makes something of", read)
                              : fmt::format("{}, which job \"{}\" behind it makes", read, jobs[maker].name),
                          "what is there, or what a job before it makes");
      }
    }
    jobs[i].needs.assign(needs.begin(), needs.end());
  }
}

}  // namespace

std::vector<Job> read_jobs(const fs::path& file, const std::vector<std::string>& first, const AskWork& ask) {
  std::vector<Job> jobs = read_json_text(read_file(file), file.string(), [&](JsonObject& root) {
    constexpr const char* kFormat = "simuli batch";
    if (const std::string format = root.text("format"); format != kFormat) {
      throw_input_error(file.string(), "format", '"' + format + '"', fmt::format("\"{}\"", kFormat));
    }
    (void)root.integer("version", 1, 1);
    return root.objects("jobs", [&](JsonObject& object) { return read_job(object, first, ask); });
  });
  std::map<std::string, std::size_t> names;
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const auto [at, is_new] = names.emplace(jobs[i].name, i);
    if (is_new) continue;
    throw_input_error(file.string(),
                      fmt::format("jobs[{}].name", i),
                      fmt::format("\"{}\", the name of jobs[{}], too", jobs[i].name, at->second),
                      "each name once");
  }
  link_jobs(file.string(), jobs);
  return jobs;
}

std::vector<std::size_t> jobs_of(const std::vector<Job>& jobs, const Shard& shard) {
  // The first job of the group of each: whoever needs several joins their groups.
  std::vector<std::size_t> first(jobs.size());
  std::iota(first.begin(), first.end(), std::size_t{0});
  const auto find = [&](std::size_t i) {
    while (first[i] != i) i = first[i] = first[first[i]];
    return i;
  };
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    for (const std::size_t need : jobs[i].needs) {
      const std::size_t a = find(i), b = find(need);
      first[std::max(a, b)] = std::min(a, b);
    }
  }
  std::vector<std::size_t> own;
  std::map<std::size_t, std::size_t> groups;  // number by first job
  for (std::size_t i = 0; i < jobs.size(); ++i) {
    const std::size_t group = groups.emplace(find(i), groups.size()).first->second;
    if (group % shard.count == shard.index) own.push_back(i);
  }
  return own;
}

}  // namespace simuli::cli
