#include "host/apps/cli/manual/manual.hpp"

#include <fmt/format.h>
#include <iostream>
#include <memory>

#include "host/apps/cli/base/commands.hpp"
#include "host/core/base/version.hpp"

namespace simuli::cli {
namespace {

void visit_below(const std::string& path,
                 const CommandText& command,
                 const std::function<void(const std::string&, const CommandText&)>& visit) {
  visit(path, command);
  for (const CommandText& inner : command.commands) visit_below(path + ' ' + inner.name, inner, visit);
}

}  // namespace

void visit_commands(const CommandText& program,
                    const std::function<void(const std::string&, const CommandText&)>& visit) {
  visit_below(program.name, program, visit);
}

void add_completion(CommandLine& line) {
  const auto shell = std::make_shared<std::string>();
  const Command completion =
      line.root().command("completion", "print a script that completes commands in bash");
  completion.option("SHELL", *shell, "shell of the script").required().one_of({"bash"});
  completion.run([shell, &line] {  // the option sets the value
    std::cout << bash_completion(line.text());
  });
}

void add_manual(CommandLine& line) {
  line.root()
      .command("manual", "print all commands and options as a manual page: simuli manual | man -l -")
      .run([&line] { std::cout << man_page(line.text(), fmt::format("simuli {}", version())); });
}

}  // namespace simuli::cli
