#pragma once
// Command line as commands declare it: typed options with names and help. Only command.cpp depends on the
// parser library.
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

/// Types that an option can set. Numbers are decimal and must fill the complete argument; a vector takes all
/// values up to the next option.
template <class T>
concept OptionValue = std::same_as<T, std::string> || std::same_as<T, std::filesystem::path> ||
    std::same_as<T, int> || std::same_as<T, std::int64_t> || std::same_as<T, std::size_t> ||
    std::same_as<T, double> || std::same_as<T, std::vector<std::string>>;

/// One option of a command. A handle: copies refer to the same option.
class Option {
 public:
  Option& required();
  /// Sets the values that shells complete; other values may be allowed, too.
  Option& completed_by(std::function<std::vector<std::string>()> values);
  /// Shows the current value as the default in the help.
  Option& with_default();
  /// Sets the type and the default in the help.
  Option& shown_as(const std::string& type, const std::string& value);
  /// Allows values from `least` to `most`, both included.
  Option& range(int least, int most);
  Option& range(std::int64_t least, std::int64_t most);
  Option& range(double least, double most);
  Option& positive();
  Option& non_negative();
  Option& one_of(std::initializer_list<const char*> values);
  Option& one_of(std::initializer_list<int> values);
  /// Sets the allowed number of values.
  Option& values(int least, int most);
  /// For a vector: each occurrence of the option takes one value; the option may be repeated.
  Option& one_at_a_time();
  /// The same as one_at_a_time(), and each occurrence may take several comma-separated values.
  Option& comma_separated();
  /// When the option has this value, parse() runs only `answer` and requires no other argument.
  Option& answers(const std::string& value, std::function<void()> answer);
  /// Calls `on_value` with each value on the command line.
  Option& on_each(std::function<void(const std::string&)> on_value);
  /// Rejects the option together with the option `name`, which must have been added before.
  Option& excludes(const std::string& name);

  /// Whether the command line contains the option.
  [[nodiscard]] bool is_given() const;

 private:
  friend class Command;
  Option(CLI::Option* option, OptionMarks* marks) : option_(option), marks_(marks) {}
  CLI::Option* option_;
  OptionMarks* marks_;
};

/// Help data of an option or of a positional value.
struct OptionText {
  std::vector<std::string> names;  // "--output", "-o"; for a positional value "LOG"
  bool is_named = true;            // false: positional
  bool is_flag = false;            // takes no value
  bool takes_many = false;         // takes several values, up to the next option
  bool is_required = false;
  std::string type;    // type and allowed values: "INT", "TEXT:{a,b}"
  std::string preset;  // default in the help; empty: none
  std::string help;
  std::vector<std::string> completions;
};
struct CommandText {
  std::string name;  // without the names of the program and of the parent command
  std::string help;
  std::vector<OptionText> options;
  std::vector<CommandText> commands;
};

/// A command, or the program as the root command. A handle: copies refer to the same command.
class Command {
 public:
  /// Adds an option with names as in "-o,--output", or a positional value with a name as in "LOG". `value`
  /// must outlive the command line; it keeps its value when the option is absent.
  template <OptionValue T>
  Option option(const std::string& names, T& value, const std::string& help) const;
  /// Adds an option that calls `read` with its text before any command runs.
  Option option(const std::string& names,
                const std::function<void(const std::string&)>& read,
                const std::string& help) const;
  /// Adds a flag. In "--a,!--not-a" the second name sets false.
  Option flag(const std::string& names, bool& value, const std::string& help) const;

  /// Adds a subcommand.
  [[nodiscard]] Command command(const std::string& name, const std::string& help) const;
  /// Requires one of the subcommands.
  void require_command() const;
  /// Ignores unknown arguments.
  void take_anything() const;
  /// Sets the function that runs after the complete command line has been parsed.
  void run(std::function<void()> work) const;

 private:
  friend class CommandLine;
  Command(CLI::App* app, OptionMarks* marks) : app_(app), marks_(marks) {}
  CLI::App* app_;
  OptionMarks* marks_;
};

/// Arguments of a program: global options, before or after the command's name, and commands.
class CommandLine {
 public:
  /// `version` returns the text of --version and is only called for it; `name` appears in the help and in
  /// errors.
  CommandLine(const std::string& name, const std::string& about, std::function<std::string()> version);
  ~CommandLine();
  CommandLine(const CommandLine&) = delete;
  CommandLine& operator=(const CommandLine&) = delete;

  [[nodiscard]] Command root();
  /// Receives all arguments except the command's name, in order.
  using Forward = std::function<void(const std::vector<std::string>& arguments)>;
  /// Adds a command that parses its arguments itself. A command with an empty `help` is not listed.
  void add_foreign(const std::string& name, const std::string& help, Forward run);

  /// Runs the selected command; returns false when only the help, the version or an answer was printed.
  /// Throws Error{kUsage} for arguments that are not allowed.
  bool parse(int argc, const char* const* argv);
  /// Returns all help data.
  [[nodiscard]] CommandText text() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace simuli::cli
