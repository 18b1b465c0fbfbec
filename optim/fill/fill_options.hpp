#pragma once
// Whether places behind actors that nobody has seen are filled.
#include "host/base/allowed.hpp"

namespace simuli {

struct FillOptions {
  bool fill = true;
};

/// The keys that users set, with what is allowed and what it means (host/base/fields.hpp).
template <class F>
constexpr void visit_fields(FillOptions& o, F&& field) {
  field("actors.fill",
        o.fill,
        "fill plausibly what only actors ever stood before, for when they are moved or removed");
}

}  // namespace simuli
