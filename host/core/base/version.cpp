#include "host/core/base/version.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <elf.h>
#include <fmt/format.h>
#include <link.h>
#include <span>

namespace simuli {
namespace {

std::size_t padded(std::size_t bytes) { return (bytes + 3) / 4 * 4; }

/// Extracts the linker's build ID in hexadecimal digits.
std::string build_id_in(const std::byte* notes, std::size_t bytes) {
  for (std::size_t at = 0; at + sizeof(ElfW(Nhdr)) <= bytes;) {
    ElfW(Nhdr) note{};
    std::memcpy(&note, notes + at, sizeof note);
    const std::byte* const name = notes + at + sizeof note;
    const std::byte* const id = name + padded(note.n_namesz);
    at += sizeof note + padded(note.n_namesz) + padded(note.n_descsz);
    if (at > bytes || note.n_type != NT_GNU_BUILD_ID || note.n_namesz != 4 ||
        std::memcmp(name, "GNU", 4) != 0) {
      continue;
    }
    std::string digits;
    for (std::size_t i = 0; i < note.n_descsz; ++i) {
      digits += fmt::format("{:02x}", std::to_integer<unsigned>(id[i]));
    }
    return digits;
  }
  return "";
}

/// Finds the build ID of the object that contains this function.
int find_build_id(dl_phdr_info* object, std::size_t /*bytes*/, void* found) {
  const std::span parts(object->dlpi_phdr, object->dlpi_phnum);
  const auto here = reinterpret_cast<ElfW(Addr)>(&find_build_id) - object->dlpi_addr;
  const bool is_own = std::any_of(parts.begin(), parts.end(), [&](const ElfW(Phdr) & part) {
    return part.p_type == PT_LOAD && here - part.p_vaddr < part.p_memsz;
  });
  if (!is_own) return 0;
  for (const auto& part : parts) {
    if (part.p_type != PT_NOTE) continue;
    const auto* const notes = reinterpret_cast<const std::byte*>(object->dlpi_addr + part.p_vaddr);
    const std::string id = build_id_in(notes, part.p_memsz);
    if (id.empty()) continue;
    *static_cast<std::string*>(found) = id;
    break;
  }
  return 1;
}

}  // namespace

const char* version() { return SIMULI_VERSION; }

std::string build_id() {
  std::string id;
  dl_iterate_phdr(find_build_id, &id);
  const char* const pretended = std::getenv("SIMULI_TEST_BUILD");
  return pretended == nullptr ? id : id + pretended;
}

}  // namespace simuli
