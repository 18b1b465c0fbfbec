#pragma once
// Logs that appear whole or not at all.
#include <filesystem>
#include <functional>

#include "io/log/log.hpp"

namespace simuli {

/// Makes the folder `output` as write_folder_atomically() does. `fill()` writes pictures and sweeps below
/// log.folder, where images/ and sweeps/ are by then, and names them in `log`; log.json follows. Returns the
/// log as the next command will read it. Errors as write_folder_atomically(), read_log() and `fill`.
[[nodiscard]] Log make_log(const std::filesystem::path& output, Log& log, const std::function<void()>& fill);
/// The same for importers: Error{kNothing} where `fill()` leaves neither pictures nor sweeps.
[[nodiscard]] Log make_import(const std::filesystem::path& output,
                              Log& log,
                              const std::function<void()>& fill);

}  // namespace simuli
