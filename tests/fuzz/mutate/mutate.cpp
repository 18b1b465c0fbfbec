#include "tests/fuzz/mutate/mutate.hpp"

#include <array>
#include <bit>
#include <limits>

namespace simuli::test {

static_assert(std::endian::native == std::endian::little,
              "number_at() is for files of little endian numbers");

double Choice::edge() {
  constexpr std::array kEdges{0.0,
                              -0.0,
                              1.0,
                              -1.0,
                              0.5,
                              2.0,
                              1e-9,
                              1e-300,
                              5e-324,
                              1e9,
                              1e19,
                              -1e19,
                              3.4028235e38,
                              1e39,
                              1e308,
                              -1e308,
                              3.141592653589793,
                              6.283185307179586,
                              127.0,
                              256.0,
                              65535.0,
                              65537.0,
                              2147483647.0,
                              -2147483648.0,
                              4294967296.0,
                              9007199254740993.0};
  switch (below(8)) {
    case 0:
      return std::numeric_limits<double>::quiet_NaN();
    case 1:
      return below(2) == 0 ? std::numeric_limits<double>::infinity()
                           : -std::numeric_limits<double>::infinity();
    case 2:
      return std::normal_distribution<double>(0.0, 10.0)(random);
    default:
      return kEdges[below(kEdges.size())];
  }
}

std::string mutated_numbers(std::string bytes, std::size_t bytes_of_one, Choice& choice) {
  const std::size_t count = bytes.size() / bytes_of_one;
  if (count == 0 || choice.below(4) == 0) return choice.change(bytes);
  const std::size_t at = choice.below(count) * bytes_of_one;
  if (bytes_of_one == sizeof(double)) {
    put_number(bytes, at, choice.edge());
  } else {
    // Beyond float's range: infinity, which is an edge as well.
    const double edge = choice.edge();
    constexpr double kMost = std::numeric_limits<float>::max();
    put_number(bytes,
               at,
               edge > kMost    ? std::numeric_limits<float>::infinity()
               : edge < -kMost ? -std::numeric_limits<float>::infinity()
                               : static_cast<float>(edge));
  }
  return bytes;
}

std::optional<std::string> mutated(Form form, const std::string& input, Choice& choice) {
  switch (form) {
    case Form::kBytes:
      return std::nullopt;
    case Form::kText:
      return mutated_text(input, choice);
    case Form::kJson:
      return mutated_json(input, choice);
    case Form::kPly:
      return mutated_ply(input, choice);
    case Form::kSpz:
      return mutated_spz(input, choice);
    case Form::kExr:
      return mutated_exr(input, choice);
    case Form::kWire:
      return mutated_wire(input, choice);
    case Form::kRecords:
      return mutated_records(input, choice);
    case Form::kMcap:
      return mutated_mcap(input, choice);
  }
  return std::nullopt;
}

}  // namespace simuli::test
