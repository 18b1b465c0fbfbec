#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/apps/cli/base/quoted.hpp"
#include "host/apps/cli/manual/manual.hpp"

namespace simuli::cli {
namespace {

std::string option_words(const CommandText& command) {
  std::string words;
  for (const OptionText& option : command.options) {
    if (option.is_named) words += (words.empty() ? "" : " ") + option.names.front();
  }
  return words;
}

/// Returns the positional words: commands, or completions of positional values.
std::string place_words(const CommandText& command) {
  std::vector<std::string> words;
  for (const CommandText& inner : command.commands) words.push_back(inner.name);
  for (const OptionText& option : command.options) {
    if (!option.is_named) words.insert(words.end(), option.completions.begin(), option.completions.end());
  }
  return fmt::format("{}", fmt::join(words, " "));
}

std::string words_case(const std::string& pattern, const std::string& words) {
  return fmt::format("    {}) words={} ;;\n", pattern, quoted(words));
}

}  // namespace

std::string bash_completion(const CommandText& program) {
  std::string commands, values, options, places;
  const std::string shared = option_words(program);
  visit_commands(program, [&](const std::string& path, const CommandText& command) {
    if (path != program.name) commands += (commands.empty() ? "" : " | ") + quoted(path);
    for (const OptionText& option : command.options) {
      if (!option.is_named || option.is_flag) continue;
      std::string pattern;
      for (const std::string& name : option.names) {
        // Global options are allowed after every command.
        const std::string at =
            path == program.name ? fmt::format("*{}", quoted(' ' + name)) : quoted(path + ' ' + name);
        pattern += (pattern.empty() ? "" : " | ") + at;
      }
      values += words_case(pattern, fmt::format("{}", fmt::join(option.completions, " ")));
    }
    const std::string own = path == program.name ? "" : option_words(command) + ' ';
    options += words_case(quoted(path), own + shared);
    if (const std::string words = place_words(command); !words.empty()) {
      places += words_case(quoted(path), words);
    }
  });
  std::string many;  // options with several values, up to the next option
  visit_commands(program, [&](const std::string& path, const CommandText& command) {
    for (const OptionText& option : command.options) {
      if (!option.takes_many || !option.is_named) continue;
      for (const std::string& name : option.names) {
        many += (many.empty() ? "" : " | ") + quoted(path + ' ' + name);
      }
    }
  });
  return fmt::format(R"(# Completion of {name} for bash, made by "{name} completion bash".
_{name}() {{
    local current=${{COMP_WORDS[COMP_CWORD]}} command={name} option='' words='' is_value='' files='' i
    for ((i = 1; i < COMP_CWORD; ++i)); do
        if [[ ${{COMP_WORDS[i]}} == -* ]]; then option=${{COMP_WORDS[i]}}; fi
        case "$command ${{COMP_WORDS[i]}}" in
        {commands})
            command+=" ${{COMP_WORDS[i]}}" option='' ;;
        esac
    done
    case "$command $option" in
    {many}) is_value=1 ;;
    *) if [[ $option && $option == "${{COMP_WORDS[COMP_CWORD-1]}}" ]]; then is_value=1; fi ;;
    esac
    if [[ $is_value ]]; then
        case "$command $option" in
{values}    *) is_value='' ;;
        esac
    fi
    if [[ $current == -* ]]; then
        case "$command" in
{options}        esac
    elif [[ ! $is_value ]]; then
        case "$command" in
{places}        esac
        if [[ $words && $command == *' '* ]]; then files=1; fi
    fi
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current"
        if [[ $files ]]; then compgen -f -- "$current"; fi)
    if [[ ${{COMPREPLY[0]-}} == *= ]]; then compopt -o nospace; fi
}}
complete -o default -F _{name} {name}
)",
                     fmt::arg("name", program.name),
                     fmt::arg("commands", commands),
                     fmt::arg("many", many.empty() ? "''" : many),
                     fmt::arg("values", values),
                     fmt::arg("options", options),
                     fmt::arg("places", places));
}

}  // namespace simuli::cli
