#include "host/device/render/device/buffer_table.hpp"

#include <algorithm>

#include "host/device/runtime/kernel.hpp"

namespace simuli::detail {

// Members and table are in the same object, so offsets remain valid when the table moves.
Memory& TableRows::memory(const Row& row) {
  return *reinterpret_cast<Memory*>(reinterpret_cast<std::byte*>(this) + row.offset);
}
const Memory& TableRows::memory(const Row& row) const {
  return *reinterpret_cast<const Memory*>(reinterpret_cast<const std::byte*>(this) + row.offset);
}

void TableRows::add(ArgumentName name,
                    Memory& memory,
                    std::size_t element_bytes,
                    const PassedType& type,
                    const PassedType& const_type) {
  const std::ptrdiff_t offset = reinterpret_cast<std::byte*>(&memory) - reinterpret_cast<std::byte*>(this);
  rows_.push_back({name.text(), offset, element_bytes, &type, &const_type});
}

void TableRows::reserve(std::size_t row, std::uint64_t count) { memory(rows_[row]).reserve(count); }

BufferBytes TableRows::bytes(std::size_t row, std::uint64_t count) const {
  return {rows_[row].name, std::max<std::uint64_t>(count, 1) * rows_[row].element_bytes};
}

void TableRows::offer_to(Kernel& kernel) {
  for (const Row& row : rows_) kernel.offer(row.name, *row.type, memory(row));
}
void TableRows::offer_to(Kernel& kernel) const {
  for (const Row& row : rows_) kernel.offer(row.name, *row.const_type, memory(row));
}

}  // namespace simuli::detail
