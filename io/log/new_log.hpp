#pragma once
// Logs that appear whole or not at all.
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "io/log/log.hpp"

namespace simuli {

/// Makes the folder `output` as write_folder_atomically() does. `fill()` writes pictures and sweeps below
/// log.folder, where images/ and sweeps/ are by then, and names them in `log`; log.json follows. Returns the
/// log as the next command will read it. Errors as write_folder_atomically(), read_log() and `fill`.
[[nodiscard]] Log make_log(const std::filesystem::path& output, Log& log, const std::function<void()>& fill);
/// The same for importers: Error{kNothing} where `fill()` leaves neither pictures nor sweeps. Without an
/// `output` it is a survey: log.folder is empty, put_...() do nothing, and the log is returned as `fill()` leaves
/// it.
[[nodiscard]] Log make_import(const std::filesystem::path& output,
                              Log& log,
                              const std::function<void()>& fill);

/// Files of a log that make_import() makes, by their names in it; errors as of what writes them.
void put_sweep(const Log& log, const std::string& file, const Sweep& sweep);
void put_picture(const Log& log,
                 const std::filesystem::path& from,
                 const std::string& file,
                 const Camera& camera,
                 const std::string& source);
/// Hides the lowest `share` of all pictures of a camera, which show the vehicle there. The line that tells it; none
/// where the log has no pictures of such a camera.
[[nodiscard]] std::vector<std::string> hide_lowest(Log& log, const std::string& camera, double share);
/// `write(path)` in a folder that is there; not of a survey.
void put_file(const Log& log,
              const std::string& file,
              const std::function<void(const std::filesystem::path&)>& write);

}  // namespace simuli
