#pragma once
// Declarative tables of device buffers: a struct whose members are rows of a table.
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "host/device/runtime/argument.hpp"
#include "host/device/runtime/buffer.hpp"
#include "host/device/runtime/real_buffer.hpp"

namespace simuli {

class Kernel;

struct BufferBytes {
  std::string name;
  std::uint64_t bytes = 0;
};

namespace detail {

/// The part of BufferTable that does not depend on the type of sizes.
class TableRows {
 public:
  struct Row {
    const char* name;
    std::ptrdiff_t offset;  // offset of the Memory from the table
    std::size_t element_bytes;
    const PassedType* type;
    const PassedType* const_type;
  };
  void add(ArgumentName name,
           Memory& memory,
           std::size_t element_bytes,
           const PassedType& type,
           const PassedType& const_type);
  [[nodiscard]] std::size_t size() const { return rows_.size(); }
  void reserve(std::size_t row, std::uint64_t count);
  [[nodiscard]] BufferBytes bytes(std::size_t row, std::uint64_t count) const;
  void offer_to(Kernel& kernel);
  void offer_to(Kernel& kernel) const;

 private:
  [[nodiscard]] Memory& memory(const Row& row);
  [[nodiscard]] const Memory& memory(const Row& row) const;
  std::vector<Row> rows_;
};

}  // namespace detail

/// Buffers of a common purpose. Each member is a row: a name, unique in the program, which is used by kernel
/// arguments, errors and memory statistics (Device::memory_by_name); an element type; and the number of
/// elements as a function of `Sizes`.
///   struct Projected : BufferTable<FrameSizes> {
///     using BufferTable::BufferTable;
///     Reals records{*this, "records", [](const FrameSizes& s) { return SIM_RECORD * s.particles; }};
///     Words keys{*this, "keys", [](const FrameSizes& s) { return s.particles; }};
///   };
/// A table is an ArgumentGroup: kernels receive the members that they have arguments for.
template <class Sizes>
class BufferTable {
 public:
  using Count = std::uint64_t (*)(const Sizes&);

  explicit BufferTable(const Device& device, Precision precision = Precision::kFloat)
      : device_(device), precision_(precision) {}

  class Reals : public RealBuffer {
   public:
    Reals(BufferTable& table, ArgumentName name, Count size)
        : RealBuffer(table.device_, name.text(), table.precision_) {
      if (table.precision_ == Precision::kFloat) {
        table.template add<float>(name, memory(), size);
      } else {
        table.template add<double>(name, memory(), size);
      }
    }
  };
  template <class T>
  class Array : public Buffer<T> {
   public:
    Array(BufferTable& table, ArgumentName name, Count size) : Buffer<T>(table.device_, name.text()) {
      table.template add<T>(name, this->memory(), size);
    }
  };
  using Words = Array<std::uint32_t>;
  /// Structs of reals; the size counts reals.
  template <template <class> class T>
  class Structs : public StructBuffer<T> {
   public:
    Structs(BufferTable& table, ArgumentName name, Count size)
        : StructBuffer<T>(table.device_, name.text(), table.precision_) {
      if (table.precision_ == Precision::kFloat) {
        table.template add_structs<T, float>(name, this->memory(), size);
      } else {
        table.template add_structs<T, double>(name, this->memory(), size);
      }
    }
  };

  /// Calls Buffer::reserve() for each member: grows, never shrinks, keeps the content of members that need not
  /// grow.
  void reserve(const Sizes& sizes) {
    for (std::size_t row = 0; row < counts_.size(); ++row) rows_.reserve(row, counts_[row](sizes));
  }
  /// Returns the bytes of each member after reserve(sizes).
  [[nodiscard]] std::vector<BufferBytes> bytes(const Sizes& sizes) const {
    std::vector<BufferBytes> all;
    for (std::size_t row = 0; row < counts_.size(); ++row)
      all.push_back(rows_.bytes(row, counts_[row](sizes)));
    return all;
  }
  void offer_to(Kernel& kernel) { rows_.offer_to(kernel); }
  void offer_to(Kernel& kernel) const { rows_.offer_to(kernel); }

  [[nodiscard]] const Device& device() const { return device_; }
  [[nodiscard]] Precision precision() const { return precision_; }

 private:
  template <class T>
  void add(ArgumentName name, detail::Memory& memory, Count count) {
    rows_.add(name, memory, sizeof(T), detail::kPassedBuffer<T>, detail::kPassedBuffer<const T>);
    counts_.push_back(count);
  }
  template <template <class> class T, class Real>
  void add_structs(ArgumentName name, detail::Memory& memory, Count count) {
    rows_.add(name,
              memory,
              sizeof(Real),
              detail::kPassedStructs<T<double>, Real>,
              detail::kPassedStructs<const T<double>, Real>);
    counts_.push_back(count);
  }

  detail::TableRows rows_;  // first member: rows are located relative to it
  std::vector<Count> counts_;
  Device device_;
  Precision precision_;
};

}  // namespace simuli
