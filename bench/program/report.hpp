#pragma once
// What a bench measured, as one HTML file.
#include <filesystem>
#include <string>
#include <vector>

#include "bench/render/measure.hpp"

namespace simuli::bench {

/// One table for each thing measured. Atomic; Error{kInput} when the file can't be written.
void write_report(const std::filesystem::path& file, const std::string& title, const std::vector<Row>& rows);

}  // namespace simuli::bench
