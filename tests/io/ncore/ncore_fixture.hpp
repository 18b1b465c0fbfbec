#pragma once
// A street's log as NCore and back, in a separate folder.
#include <filesystem>
#include <fstream>
#include <functional>
#include <gtest/gtest.h>
#include <string>

#include "io/base/file.hpp"
#include "io/base/json_reader.hpp"
#include "io/import/ncore/ncore_log.hpp"
#include "io/ncore/ncore_export.hpp"
#include "io/synth/long_street.hpp"
#include "io/zarr/zarr_store.hpp"
#include "tests/io/scratch.hpp"

namespace simuli::test {

class NcoreTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!has_zarr()) GTEST_SKIP() << "not run: NCore, built without libblosc or liblzma";
  }
  [[nodiscard]] Log street() const {
    LongStreetOptions options;
    options.output = scratch_ / "street.log";
    options.length_m = 10.0;
    options.frames = 2;
    options.cameras = 2;
    options.lidars = 2;
    options.image_width = 48;
    options.image_height = 27;
    options.lidar_columns = 90;
    options.rolling_shutter = true;
    return synth_long_street(options);
  }
  [[nodiscard]] Log there_and_back(const Log& log, const std::string& name = "a.zarr") {
    (void)export_ncore(log, scratch_ / name, {});
    return back(name);
  }
  [[nodiscard]] Log back(const std::string& name) {
    NcoreOptions options;
    options.sequence = scratch_ / name;
    options.output = scratch_ / (name + std::to_string(++count_) + ".log");
    return import_ncore(options, {}, report_);
  }
  /// Changes the JSON of a key of a.zarr.
  void edit(const std::string& key, const std::function<void(Json&)>& change) const {
    const std::filesystem::path file = scratch_ / ("a.zarr/" + key);
    Json json = parse_json(read_file(file), key);
    change(json);
    std::ofstream(file) << json.dump();
  }
  /// Removes the keys of simuli, which files of other programs do not have.
  void strip() const {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(scratch_ / "a.zarr")) {
      if (entry.path().filename() != ".zattrs") continue;
      Json json = parse_json(read_file(entry.path()), "");
      if (json.contains("generic_meta_data")) json["generic_meta_data"] = Json::object();
      json.erase("simuli");
      std::ofstream(entry.path()) << json.dump();
    }
    for (const auto& entry : std::filesystem::recursive_directory_iterator(scratch_ / "a.zarr")) {
      if (entry.path().filename().string().starts_with("simuli_") && entry.is_directory())
        std::filesystem::remove(entry.path() / ".zarray");
    }
  }

  Scratch scratch_;
  NcoreReport report_;
  int count_ = 0;
};

}  // namespace simuli::test
