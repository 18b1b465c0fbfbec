#include "host/cli/batch/record.hpp"

#include <fmt/format.h>
#include <utility>

#include "host/base/error.hpp"
#include "host/cli/base/json_text.hpp"
#include "io/base/file.hpp"
#include "io/base/fingerprint.hpp"
#include "io/base/regular_file.hpp"
#include "io/base/temporary.hpp"

namespace simuli::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "simuli job";

}  // namespace

fs::path record_beside(const std::string& output) {
  fs::path record = without_trailing_slash(output);
  return record += ".job";
}

Json made_by(const Job& job, const std::string& program) {
  Json inputs = Json::object();
  for (const std::string& path : job.work.reads) inputs[path] = fingerprint(path);
  Json out = {{"program", program}, {"run", job.words}};
  if (!job.stdout_file.empty()) out["stdout"] = job.stdout_file;
  out["inputs"] = inputs;
  // Bytes that are no UTF-8 as they will be read again.
  return Json::parse(json_text(out));
}

std::optional<Record> read_record(const Job& job) {
  const fs::path file = record_beside(job.output());
  if (!is_there(file)) return std::nullopt;
  try {
    return read_json_text(read_file(file), file.string(), [&](JsonObject& root) -> std::optional<Record> {
      if (root.text("format") != kFormat) throw_input_error(file.string(), "format", "another", kFormat);
      (void)root.integer("version", 1, 1);
      Record record;
      record.is_done = root.boolean("done");
      record.made_by = root.get("made_by");
      root.object("outputs", [&](JsonObject& outputs) {
        for (const std::string& path : job.work.makes) {
          if (outputs.has(path)) record.outputs[path] = outputs.text(path);
        }
        outputs.ignore_other_keys();
      });
      return record;
    });
  } catch (const Error&) {  // damaged: what stands beside it is nobody's
    return std::nullopt;
  }
}

void write_record(const Job& job, const Record& record) {
  const Json out = {{"format", kFormat},
                    {"version", 1},
                    {"done", record.is_done},
                    {"made_by", record.made_by},
                    {"outputs", record.outputs}};
  write_file_atomically(record_beside(job.output()), json_text(out) + '\n');
}

bool is_done(const Job& job, const std::optional<Record>& record, const Json& made_by) {
  if (!record || !record->is_done || record->made_by != made_by) return false;
  for (const std::string& path : job.work.makes) {
    const auto known = record->outputs.find(path);
    if (known == record->outputs.end() || known->second.empty() || known->second != fingerprint(path)) {
      return false;
    }
  }
  return true;
}

void need_own_outputs(const Job& job, const std::optional<Record>& record) {
  const auto refuse = [](const std::string& path, const char* what) {
    throw_input_error(path, "output", what, "a path that does not exist yet, or --overwrite");
  };
  for (const std::string& path : job.work.makes) {
    if (!is_there(path)) continue;
    const bool is_known = record && record->outputs.contains(path);
    if (!is_known) refuse(path, "something of that name that no job has made");
    if (record->is_done && record->outputs.at(path) != fingerprint(path)) {
      refuse(path, "something that was changed since a job made it");
    }
  }
  for (const std::string& path : job.work.unfinished) {
    if (!record && is_there(path)) refuse(path, "something of that name that no job has left");
  }
}

bool is_to_go_on(const Job& job, const std::optional<Record>& record, const Json& made_by) {
  return job.work.goes_on && record && !record->is_done && record->made_by == made_by;
}

}  // namespace simuli::cli
