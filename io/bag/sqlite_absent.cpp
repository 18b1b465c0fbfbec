#include "host/core/base/error.hpp"
#include "io/bag/bag.hpp"

namespace simuli {

std::unique_ptr<const Bag> open_sqlite_bag(const std::filesystem::path& file) {
  throw_input_error(file.string(), "kind", "SQLite, which this build can't read", "a build with libsqlite3");
}

}  // namespace simuli
