#include "optim/base/state.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <sstream>
#include <utility>

#include "io/base/state_file.hpp"

namespace simuli {
namespace {

template <class T>
StateList::Bytes bytes_of(const std::vector<T>& values) {
  StateList::Bytes bytes(values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

template <class T>
std::vector<T> values_of(const std::string& file, const std::string& name, std::span<const std::byte> bytes) {
  if (bytes.size() % sizeof(T) != 0) {
    throw_input_error(
        file, name, fmt::format("{} bytes", bytes.size()), fmt::format("a multiple of {}", sizeof(T)));
  }
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

}  // namespace

void StateList::need_size(const std::string& file,
                          const std::string& name,
                          std::size_t found,
                          std::size_t allowed) {
  if (found == allowed) return;
  throw_input_error(file, name, fmt::format("{} bytes", found), fmt::format("{}", allowed));
}

void StateList::add(std::string name, Save save, Load load) {
  entries_.push_back({std::move(name), std::move(save), std::move(load)});
}

void StateList::add(std::string name, RealBuffer& buffer) {
  const std::string block = name;
  add(
      std::move(name),
      [&buffer] { return bytes_of(buffer.download_float()); },
      [&buffer, block](const std::string& file, std::span<const std::byte> bytes) {
        buffer.assign(std::span<const float>(values_of<float>(file, block, bytes)));
      });
}

void StateList::add(std::string name, Buffer<std::uint32_t>& buffer) {
  const std::string block = name;
  add(
      std::move(name),
      [&buffer] { return bytes_of(buffer.download()); },
      [&buffer, block](const std::string& file, std::span<const std::byte> bytes) {
        buffer.assign(std::span<const std::uint32_t>(values_of<std::uint32_t>(file, block, bytes)));
      });
}

void StateList::add_numbers(const std::string& name,
                            const std::function<std::vector<double>()>& get,
                            const std::function<void(std::span<const double>)>& set) {
  add(
      name,
      [get] { return bytes_of(get()); },
      [get, set, name](const std::string& file, std::span<const std::byte> bytes) {
        need_size(file, name, bytes.size(), get().size() * sizeof(double));
        set(values_of<double>(file, name, bytes));
      });
}

void StateList::add_fixed(const std::string& name, const std::string& text) {
  add(
      name,
      [text] { return bytes_of(std::vector<char>(text.begin(), text.end())); },
      [text, name](const std::string& file, std::span<const std::byte> bytes) {
        need_text(file, name, bytes, text);
      });
}

void StateList::need_text(const std::string& file,
                          const std::string& name,
                          std::span<const std::byte> saved,
                          const std::string& text) {
  const std::vector<char> characters = values_of<char>(file, name, saved);
  std::istringstream found_text(std::string(characters.begin(), characters.end())), allowed_text(text);
  std::string found, allowed;
  for (;;) {
    const bool more_found = static_cast<bool>(std::getline(found_text, found));
    const bool more_allowed = static_cast<bool>(std::getline(allowed_text, allowed));
    if (!more_found && !more_allowed) return;
    if (more_found != more_allowed || found != allowed) {
      throw_input_error(
          file, name, more_found ? found : "fewer lines", more_allowed ? allowed : "fewer lines");
    }
  }
}

std::vector<std::pair<std::string, std::uint64_t>> StateList::hashes() const {
  std::vector<std::pair<std::string, std::uint64_t>> out;
  for (const Entry& entry : entries_) out.emplace_back(entry.name, checksum_of(entry.save()));
  return out;
}

void StateList::write(const std::filesystem::path& file) const {
  write_state_file(file, [&](StateWriter& writer) {
    for (const Entry& entry : entries_) writer.add(entry.name, entry.save());
  });
}

void StateList::read(const std::filesystem::path& path) const {
  const StateFile file(path);
  // Checks names first, so that nothing is loaded from another kind of training.
  for (const std::string& name : file.names()) {
    const bool known =
        std::any_of(entries_.begin(), entries_.end(), [&](const Entry& e) { return e.name == name; });
    if (!known)
      throw_input_error(path.string(), name, "a state this training does not have", "none of that name");
  }
  for (const Entry& entry : entries_) {
    if (!file.has(entry.name)) throw_input_error(path.string(), entry.name, "no such state", "one");
  }
  for (const Entry& entry : entries_) entry.load(path.string(), file.block(entry.name));
}

}  // namespace simuli
