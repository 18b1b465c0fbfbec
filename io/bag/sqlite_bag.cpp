// rosbag2's SQLite databases: a table of topics and a table of messages.
#include <fmt/format.h>
#include <map>
#include <sqlite3.h>

#include "host/core/base/error.hpp"
#include "io/bag/bag.hpp"
#include "io/base/file.hpp"

namespace simuli {
namespace {

namespace fs = std::filesystem;

struct Close {
  void operator()(sqlite3* database) const { sqlite3_close(database); }
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};

class Database {
 public:
  explicit Database(const fs::path& path) : file_(path.string()) {
    need_regular_file(path);
    sqlite3* opened = nullptr;
    // Read-only, without locks, and without applying the recorder's journal.
    const int result = sqlite3_open_v2(path.c_str(), &opened, SQLITE_OPEN_READONLY, nullptr);
    database_.reset(opened);
    if (result != SQLITE_OK) refuse("file");
    sqlite3_limit(database_.get(), SQLITE_LIMIT_LENGTH, static_cast<int>(kLargestChunk));
    // Defensive mode: a file's own views and functions in its schema are not executed.
    sqlite3_db_config(database_.get(), SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(database_.get(), SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_db_config(database_.get(), SQLITE_DBCONFIG_ENABLE_VIEW, 0, nullptr);
    for_each("PRAGMA cell_size_check=ON", [](sqlite3_stmt*) {});
  }

  template <class OnRow>
  void for_each(const char* query, const OnRow& on_row) const {
    sqlite3_stmt* prepared = nullptr;
    if (sqlite3_prepare_v2(database_.get(), query, -1, &prepared, nullptr) != SQLITE_OK) refuse("tables");
    const std::unique_ptr<sqlite3_stmt, Close> statement(prepared);
    int result = SQLITE_ROW;
    while ((result = sqlite3_step(prepared)) == SQLITE_ROW) on_row(prepared);
    if (result != SQLITE_DONE) refuse("rows");
  }

  [[noreturn]] void refuse(const char* field) const {
    throw_input_error(file_,
                      field,
                      (database_ ? sqlite3_errmsg(database_.get()) : "no memory"),
                      "a whole database of rosbag2: tables topics and messages");
  }
  [[nodiscard]] const std::string& file() const { return file_; }

 private:
  std::string file_;
  std::unique_ptr<sqlite3, Close> database_;
};

std::string_view bytes_of(sqlite3_stmt* row, int column) {
  const void* data = sqlite3_column_blob(row, column);
  const int size = sqlite3_column_bytes(row, column);
  return data == nullptr ? std::string_view()
                         : std::string_view(static_cast<const char*>(data), static_cast<std::size_t>(size));
}

class SqliteBag : public Bag {
 public:
  explicit SqliteBag(const fs::path& path) : path_(path) { (void)Database(path); }

  void read(const Wanted& wanted, const OnMessage& on_message) const override {
    const Database database(path_);
    std::map<std::int64_t, std::pair<BagChannel, bool>> channels;
    constexpr std::size_t kMostTopics = 65536;
    database.for_each("SELECT id, name, type, serialization_format FROM topics", [&](sqlite3_stmt* row) {
      BagChannel channel{
          std::string(bytes_of(row, 1)), std::string(bytes_of(row, 2)), std::string(bytes_of(row, 3))};
      const bool is_wanted = wanted(channel);
      channels.emplace(sqlite3_column_int64(row, 0), std::pair(std::move(channel), is_wanted));
      if (channels.size() > kMostTopics)
        throw_input_error(database.file(), "topics", "more", fmt::format("at most {}", kMostTopics));
    });
    database.for_each(
        "SELECT topic_id, timestamp, data FROM messages ORDER BY rowid", [&](sqlite3_stmt* row) {
          const std::int64_t id = sqlite3_column_int64(row, 0), time_ns = sqlite3_column_int64(row, 1);
          const auto channel = channels.find(id);
          if (channel == channels.end())
            throw_input_error(
                database.file(), "messages: topic_id", fmt::format("{}", id), "an id of topics");
          if (time_ns < 0)
            throw_input_error(
                database.file(), "messages: timestamp", fmt::format("{}", time_ns), "at least 0");
          if (channel->second.second)
            on_message(channel->second.first, static_cast<std::uint64_t>(time_ns), bytes_of(row, 2));
        });
  }

 private:
  fs::path path_;
};

}  // namespace

std::unique_ptr<const Bag> open_sqlite_bag(const fs::path& file) {
  return std::make_unique<const SqliteBag>(file);
}

}  // namespace simuli
