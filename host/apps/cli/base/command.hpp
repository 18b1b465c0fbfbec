#pragma once
// A command line as the commands describe it: options by name, typed by what they set, with their help. Which
// library reads it is known to command.cpp alone.
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace simuli::cli {

struct OptionMarks;

/// What an option can set. Numbers are read whole, in decimal; a vector takes every value up to the next
/// option.
template <class T>
concept OptionValue = std::same_as<T, std::string> || std::same_as<T, std::filesystem::path> ||
    std::same_as<T, int> || std::same_as<T, std::int64_t> || std::same_as<T, std::size_t> ||
    std::same_as<T, double> || std::same_as<T, std::vector<std::string>>;

/// One option of a command; what is said of it holds for the option, however often this is copied.
class Option {
 public:
  Option& required();
  /// Values that can be told beforehand, for shells to complete; others may be allowed, too.
  Option& completed_by(std::function<std::vector<std::string>()> values);
  /// The help tells what the value is now.
  Option& with_default();
  /// What stands in the help for its type and its default.
  Option& shown_as(const std::string& type, const std::string& value);
  /// Values within, both ends allowed.
  Option& range(int least, int most);
  Option& range(std::int64_t least, std::int64_t most);
  Option& range(double least, double most);
  Option& positive();
  Option& non_negative();
  Option& one_of(std::initializer_list<const char*> values);
  Option& one_of(std::initializer_list<int> values);
  /// How many values it takes.
  Option& values(int least, int most);
  /// Of a vector: one value each time that the option is given, any number of times.
  Option& one_at_a_time();
  /// The same, and a value may be several with commas between them.
  Option& comma_separated();
  /// For this value nothing is run or required: `answer` is, once the whole command line has been read.
  Option& answers(const std::string& value, std::function<void()> answer);
  /// Calls `on_value` with each value that the command line gives.
  Option& on_each(std::function<void(const std::string&)> on_value);
  /// Not together with the option of that name, which stands before this one.
  Option& excludes(const std::string& name);

  /// Whether the command line has it.
  [[nodiscard]] bool is_given() const;

 private:
  friend class Command;
  Option(CLI::Option* option, OptionMarks* marks) : option_(option), marks_(marks) {}
  CLI::Option* option_;
  OptionMarks* marks_;
};

/// What the help tells of an option, or of a value that has its place alone.
struct OptionText {
  std::vector<std::string> names;  // "--output", "-o"; of a value "LOG"
  bool is_named = true;            // by these, not by its place
  bool is_flag = false;            // takes no value
  bool takes_many = false;         // values, up to the next option
  bool is_required = false;
  std::string type;    // of its values, with what is allowed: "INT", "TEXT:{a,b}"
  std::string preset;  // empty: none is told
  std::string help;
  std::vector<std::string> completions;
};
struct CommandText {
  std::string name;  // as typed behind that of the program or of the command that it is one of
  std::string help;
  std::vector<OptionText> options;
  std::vector<CommandText> commands;
};

/// A command, or the program itself as the one above all. A handle: copies mean the same command.
class Command {
 public:
  /// Options are named "-o,--output", positional values "LOG". `value` must live as long as the command line
  /// does; it keeps what it has when the option is not given.
  template <OptionValue T>
  Option option(const std::string& names, T& value, const std::string& help) const;
  /// `read` gets the text before any command runs.
  Option option(const std::string& names,
                const std::function<void(const std::string&)>& read,
                const std::string& help) const;
  /// Of "--a,!--not-a" the second one says false.
  Option flag(const std::string& names, bool& value, const std::string& help) const;

  /// A command of this one.
  [[nodiscard]] Command command(const std::string& name, const std::string& help) const;
  /// One of its commands has to be named.
  void require_command() const;
  /// Arguments that it does not know are passed over.
  void take_anything() const;
  /// What it does, once the whole command line has been read.
  void run(std::function<void()> work) const;

 private:
  friend class CommandLine;
  Command(CLI::App* app, OptionMarks* marks) : app_(app), marks_(marks) {}
  CLI::App* app_;
  OptionMarks* marks_;
};

/// The arguments of a program: its own options, before or behind a command's name, and its commands.
class CommandLine {
 public:
  /// `version` makes what --version prints, when it is asked for; `name` stands in the help and in errors.
  CommandLine(const std::string& name, const std::string& about, std::function<std::string()> version);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  [[nodiscard]] Command root();
  /// All arguments but its name, in their order.
  using Forward = std::function<void(const std::vector<std::string>& arguments)>;
  /// A command that reads its arguments itself: none are read here once it is named. Without a help it is told
  /// nowhere.
  void add_foreign(const std::string& name, const std::string& help, Forward run);

  /// Runs the command that is named; false when only help, the version or an answer was asked for, and
  /// printed. Error{kUsage} for arguments that are not allowed.
  bool parse(int argc, const char* const* argv);
  /// All that the help tells.
  [[nodiscard]] CommandText text() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace simuli::cli
