#include "host/apps/cli/base/command.hpp"

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <limits>
#include <map>
#include <set>
#include <string_view>
#include <type_traits>
#include <utility>

#include "host/core/base/close_names.hpp"
#include "host/core/base/error.hpp"

namespace simuli::cli {

/// Additional data by option, which the parser library cannot store.
struct OptionMarks {
  std::map<const CLI::Option*, std::function<std::vector<std::string>()>> completions;
};

namespace {

/// Checks an open range. The library's own checks print the largest double in 309 digits.
CLI::Validator number(const char* name, const char* allowed, bool (*is_allowed)(double)) {
  const auto check = [=](const std::string& text) -> std::string {
    double value = 0.0;
    if (CLI::detail::lexical_cast(text, value) && is_allowed(value)) return {};
    return fmt::format("found {}, allowed {}", text, allowed);
  };
  return {check, name};
}

/// Wraps a check of the library with this program's message.
CLI::Validator reworded(const CLI::Validator& check, const std::string& allowed) {
  const auto checked = [=](const std::string& text) {
    return check(text).empty() ? std::string() : fmt::format("found {}, allowed {}", text, allowed);
  };
  return {checked, check.get_description()};
}

template <class T>
CLI::Validator within(T least, T most) {
  return reworded(CLI::Range(least, most), fmt::format("{} to {}", least, most));
}

/// Checks the range of T, because the library clamps a number to it silently.
template <class T>
std::string unless_held(const std::string& text) {
  errno = 0;
  const auto value = [&] {
    if constexpr (std::is_signed_v<T>) return std::strtoll(text.c_str(), nullptr, 0);
    if constexpr (!std::is_signed_v<T>) return std::strtoull(text.c_str(), nullptr, 0);
  }();
  if (errno != ERANGE && std::in_range<T>(value)) return {};
  using Limits = std::numeric_limits<T>;
  return fmt::format("found {}, allowed {} to {}", text, Limits::min(), Limits::max());
}

/// Returns "program draw": the words that select this command.
std::string full_name(const CLI::App& app) {
  const CLI::App* const parent = app.get_parent();
  return parent == nullptr ? app.get_name() : full_name(*parent) + ' ' + app.get_name();
}

/// Returns the innermost command on the command line.
const CLI::App& reached(const CLI::App& app) {
  const std::vector<CLI::App*> found = app.get_subcommands();
  return found.empty() ? app : reached(*found.front());
}

bool is_listed(const CLI::App* command) { return !command->get_group().empty(); }

std::vector<std::string> command_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* const command : app.get_subcommands(is_listed)) {
    names.push_back(command->get_name());
  }
  return names;
}

/// Returns the names of the options of a command and of its parents, each once: they share -h and --help.
std::vector<std::string> option_names(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* const option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) names.push_back("-" + name);
  }
  if (app.get_parent() != nullptr) {
    for (std::string& name : option_names(*app.get_parent())) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(std::move(name));
    }
  }
  return names;
}

/// Returns the error for a word that no option or command takes.
std::string unknown_word(const CLI::App& app, const std::string& word) {
  if (word.starts_with('-')) {
    const std::string name = word.substr(0, word.find('='));
    return fmt::format("found option \"{}\", {}allowed those of {}",
                       name,
                       did_you_mean(name, option_names(app)),
                       full_name(app));
  }
  const std::vector<std::string> commands = command_names(app);
  if (commands.empty()) return fmt::format("found \"{}\", allowed no further value", word);
  return fmt::format(
      "found \"{}\", {}allowed {}", word, did_you_mean(word, commands), fmt::join(commands, ", "));
}

/// Returns the error message for the arguments.
std::string refusal(const CLI::App& root, const CLI::ParseError& error) {
  const CLI::App& app = reached(root);
  const std::vector<std::string> unknown = root.remaining(true);
  const bool lacks_something = dynamic_cast<const CLI::RequiredError*>(&error) != nullptr;
  const bool has_more = dynamic_cast<const CLI::ExtrasError*>(&error) != nullptr;
  std::string what = error.what();
  // The library reports a missing command or value before an unknown word.
  if (!unknown.empty() && (lacks_something || has_more)) {
    what = unknown_word(app, unknown.front());
  } else if (const auto commands = command_names(app); lacks_something && !commands.empty()) {
    what = fmt::format("found no command, allowed {}", fmt::join(commands, ", "));
  }
  // The library reports text that is not a number as "Could not convert: --count = many".
  constexpr std::string_view kUnread = "Could not convert: ", kEquals = " = ";
  if (const std::size_t equals = what.find(kEquals);
      what.starts_with(kUnread) && equals != std::string::npos) {
    const std::string name = what.substr(kUnread.size(), equals - kUnread.size());
    const CLI::Option* const option = app.get_option_no_throw(name);
    const bool is_whole = option != nullptr && option->get_type_name().find("INT") != std::string::npos;
    what = fmt::format("{}: found {}, allowed a {}",
                       name,
                       what.substr(equals + kEquals.size()),
                       is_whole ? "whole number" : "number");
  }
  // The library reports too many values as "--count: At Most 1 required but received 2".
  constexpr std::string_view kMost = ": At Most ", kReceived = " required but received ";
  if (const std::size_t most = what.find(kMost), received = what.find(kReceived, most);
      received != std::string::npos) {
    const std::size_t number = most + kMost.size();
    what = fmt::format("{}: found {} values, allowed at most {}",
                       what.substr(0, most),
                       what.substr(received + kReceived.size()),
                       what.substr(number, received - number));
  }
  return fmt::format("{} ({} --help)", what, full_name(app));
}

OptionText text_of(const CLI::Option& option, const OptionMarks& marks) {
  OptionText text;
  for (const std::string& name : option.get_lnames()) text.names.push_back("--" + name);
  for (const std::string& name : option.get_snames()) text.names.push_back("-" + name);
  text.is_named = !text.names.empty();
  if (!text.is_named) text.names.push_back(option.get_name(true));
  text.is_flag = option.get_items_expected_max() == 0;
  text.takes_many =
      option.get_allow_extra_args() && option.get_expected_max() == CLI::detail::expected_max_vector_size;
  text.is_required = option.get_required();
  if (!text.is_flag) {
    text.type = option.get_type_name();
    text.preset = option.get_default_str();
  }
  text.help = option.get_description();
  const auto known = marks.completions.find(&option);
  if (known != marks.completions.end()) text.completions = known->second();
  return text;
}

CommandText text_of(const CLI::App& app, const OptionMarks& marks) {
  CommandText text{app.get_name(), app.get_description(), {}, {}};
  for (const CLI::Option* const option : app.get_options()) {
    text.options.push_back(text_of(*option, marks));
  }
  for (const CLI::App* const command : app.get_subcommands(is_listed)) {
    text.commands.push_back(text_of(*command, marks));
  }
  return text;
}

/// Returns the help of the global options, printed below the options of each command.
std::string shared_options(const CLI::App& command) {
  const CLI::App* root = &command;
  while (root->get_parent() != nullptr) root = root->get_parent();
  const auto shown = root->get_options([root](const CLI::Option* option) {
    return option->nonpositional() && option != root->get_help_ptr() && option->get_name() != "--version";
  });
  const auto formatter = std::dynamic_pointer_cast<CLI::Formatter>(root->get_formatter());
  if (shown.empty() || formatter == nullptr) return {};
  return formatter->make_group("Options of every command", false, shown);
}

/// Wraps descriptions; the library's formatter prints each in one line.
class WrappedHelp : public CLI::Formatter {
  [[nodiscard]] std::string make_option_desc(const CLI::Option* option) const override {
    constexpr std::size_t kColumns = 110;
    const std::size_t room = kColumns - get_column_width();
    std::string text = option->get_description();
    for (std::size_t begin = 0; text.size() - begin > room;) {
      std::size_t blank = text.rfind(' ', begin + room);
      if (blank == std::string::npos || blank <= begin) blank = text.find(' ', begin + room);
      if (blank == std::string::npos) break;
      text[blank] = '\n';
      begin = blank + 1;
    }
    return text;
  }
};

/// Ends the library's parsing; `run` is called instead of a command.
struct Answer {
  std::function<void()> run;
};

}  // namespace

Option& Option::required() {
  option_->required();
  return *this;
}

Option& Option::completed_by(std::function<std::vector<std::string>()> values) {
  marks_->completions[option_] = std::move(values);
  return *this;
}

Option& Option::with_default() {
  option_->capture_default_str();
  return *this;
}

Option& Option::shown_as(const std::string& type, const std::string& value) {
  option_->type_name(type)->default_str(value);
  return *this;
}

Option& Option::range(int least, int most) {
  option_->check(within(least, most));
  return *this;
}

Option& Option::range(std::int64_t least, std::int64_t most) {
  option_->check(within(least, most));
  return *this;
}

Option& Option::range(double least, double most) {
  option_->check(within(least, most));
  return *this;
}

Option& Option::positive() {
  option_->check(number("POSITIVE", "a number above 0", [](double value) { return value > 0.0; }));
  return *this;
}

Option& Option::non_negative() {
  option_->check(number("NONNEGATIVE", "a number from 0 on", [](double value) { return value >= 0.0; }));
  return *this;
}

Option& Option::one_of(std::initializer_list<const char*> values) {
  const std::vector<std::string> names(values.begin(), values.end());
  option_->check(reworded(CLI::IsMember(names), fmt::format("{}", fmt::join(names, ", "))));
  return completed_by([names] { return names; });
}

Option& Option::one_of(std::initializer_list<int> values) {
  option_->check(reworded(CLI::IsMember(values), fmt::format("{}", fmt::join(values, ", "))));
  return *this;
}

Option& Option::values(int least, int most) {
  option_->expected(least, most);
  return *this;
}

Option& Option::one_at_a_time() {
  option_->allow_extra_args(false);
  return *this;
}

Option& Option::comma_separated() {
  option_->allow_extra_args(false)->delimiter(',');
  return *this;
}

Option& Option::answers(const std::string& value, std::function<void()> answer) {
  option_->each([value, answer = std::move(answer)](const std::string& given) {
    if (given == value) throw Answer{answer};
  });
  return *this;
}

Option& Option::on_each(std::function<void(const std::string&)> on_value) {
  option_->each(std::move(on_value));
  return *this;
}

Option& Option::excludes(const std::string& name) {
  option_->excludes(name);
  return *this;
}

bool Option::is_given() const { return option_->count() > 0; }

template <OptionValue T>
Option Command::option(const std::string& names, T& value, const std::string& help) const {
  CLI::Option* const option = app_->add_option(names, value, help);
  // The library converts -1 to the largest value.
  if constexpr (std::same_as<T, std::size_t>) {
    option->check(number("", "a whole number from 0 on", [](double number) { return number >= 0.0; }));
  }
  if constexpr (std::integral<T>) option->check(CLI::Validator(unless_held<T>, ""));
  // An empty text would mean an absent option.
  if constexpr (std::same_as<T, std::string> || std::same_as<T, std::filesystem::path>) {
    option->check(CLI::Validator(
        [](const std::string& text) {
          return text.empty() ? std::string("found nothing, allowed a text") : std::string();
        },
        ""));
  }
  // The library's ranges accept "nan" and "inf".
  if constexpr (std::same_as<T, double>) {
    option->check(CLI::Validator(
        [](const std::string& text) -> std::string {
          double read = 0.0;
          if (!CLI::detail::lexical_cast(text, read) || std::isfinite(read)) return {};
          return fmt::format("found {}, allowed a finite number", text);
        },
        ""));
  }
  return Option(option, marks_);
}

template Option Command::option(const std::string&, std::string&, const std::string&) const;
template Option Command::option(const std::string&, std::filesystem::path&, const std::string&) const;
template Option Command::option(const std::string&, int&, const std::string&) const;
template Option Command::option(const std::string&, std::int64_t&, const std::string&) const;
template Option Command::option(const std::string&, std::size_t&, const std::string&) const;
template Option Command::option(const std::string&, double&, const std::string&) const;
template Option Command::option(const std::string&, std::vector<std::string>&, const std::string&) const;

Option Command::option(const std::string& names,
                       const std::function<void(const std::string&)>& read,
                       const std::string& help) const {
  return Option(app_->add_option_function<std::string>(names, read, help), marks_);
}

Option Command::flag(const std::string& names, bool& value, const std::string& help) const {
  return Option(app_->add_flag(names, value, help), marks_);
}

Command Command::command(const std::string& name, const std::string& help) const {
  CLI::App* const command = app_->add_subcommand(name, help);
  command->footer([command] { return shared_options(*command); });
  return Command(command, marks_);
}

void Command::require_command() const { app_->require_subcommand(1); }

void Command::take_anything() const { app_->allow_extras()->fallthrough(false); }

void Command::run(std::function<void()> work) const { app_->callback(std::move(work)); }

struct CommandLine::Impl {
  CLI::App app;
  OptionMarks marks;
  std::map<std::string, Forward, std::less<>> foreign;

  Impl(const std::string& name, const std::string& about) : app(about, name) {
    app.formatter(std::make_shared<WrappedHelp>());  // also for its commands
  }

  /// Returns the index of the command's name, or argc.
  [[nodiscard]] int command_at(int argc, const char* const* argv) const {
    for (int i = 1; i < argc; ++i) {
      const std::string_view word = argv[i];
      if (!word.starts_with('-')) return i;
      const CLI::Option* const option = app.get_option_no_throw(std::string(word));
      if (option != nullptr && option->get_items_expected_max() > 0) ++i;  // value of the option
    }
    return argc;
  }
};

CommandLine::CommandLine(const std::string& name, const std::string& about, std::function<std::string()> ask)
    : impl_(std::make_unique<Impl>(name, about)) {
  impl_->app.set_version_flag("-v,--version", std::move(ask));
  impl_->app.fallthrough();  // global options are also allowed after the command's name
}

CommandLine::~CommandLine() = default;

Command CommandLine::root() { return Command(&impl_->app, &impl_->marks); }

CommandText CommandLine::text() const { return text_of(impl_->app, impl_->marks); }

void CommandLine::add_foreign(const std::string& name, const std::string& help, Forward run) {
  CLI::App* const command = impl_->app.add_subcommand(name, help);
  if (help.empty()) command->group("");
  impl_->foreign.emplace(name, std::move(run));
}

bool CommandLine::parse(int argc, const char* const* argv) {
  // Accepts `help`, `help COMMAND` and `version`, as other programs do.
  if (const std::string_view first = argc > 1 ? argv[1] : ""; first == "help" || first == "version") {
    std::vector<const char*> as{argv[0]};
    if (first == "help") as.insert(as.end(), argv + 2, argv + argc);
    as.push_back(first == "help" ? "--help" : "--version");
    return parse(static_cast<int>(as.size()), as.data());
  }
  const int at = impl_->command_at(argc, argv);
  const auto foreign = at < argc ? impl_->foreign.find(std::string_view(argv[at])) : impl_->foreign.end();
  if (foreign != impl_->foreign.end()) {
    std::vector<std::string> arguments(argv + 1, argv + argc);
    arguments.erase(arguments.begin() + (at - 1));
    foreign->second(arguments);
    return true;
  }
  CLI::App& app = impl_->app;
  try {
    app.parse(argc, argv);
  } catch (const Answer& answer) {
    answer.run();
    return false;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      app.exit(error);
      return false;
    }
    throw Error(ErrorKind::kUsage, refusal(app, error));
  }
  return true;
}

}  // namespace simuli::cli
