#include "optim/train/ranks/ranks.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace simuli {
namespace {

class OneRank final : public Ranks {
 public:
  [[nodiscard]] std::size_t rank() const override { return 0; }
  [[nodiscard]] std::size_t size() const override { return 1; }
  [[nodiscard]] std::span<const Message> all_gather(Message own) override {
    thread_local Message all;  // one_rank() is shared by all threads
    all = own;
    return {&all, 1};
  }
};

std::vector<bool> reported(Ranks& ranks, bool own) {
  const std::byte byte{static_cast<unsigned char>(own ? 1 : 0)};
  std::vector<bool> out;
  for (const Ranks::Message bytes : ranks.all_gather({&byte, 1}))
    out.push_back(bytes.front() != std::byte{0});
  return out;
}

std::vector<RankField> fields_in(Ranks::Message bytes) {
  RankReader reader(bytes);
  std::vector<std::uint64_t> count;
  reader.get(count);
  std::vector<RankField> fields(count.at(0));
  for (RankField& field : fields) {
    reader.get(field.name);
    reader.get(field.value);
  }
  return fields;
}

}  // namespace

bool Ranks::any(bool own) {
  if (size() == 1) return own;
  const std::vector<bool> all = reported(*this, own);
  return std::find(all.begin(), all.end(), true) != all.end();
}

bool Ranks::first(bool own) { return size() == 1 ? own : reported(*this, own).front(); }

void Ranks::wait_for_all() { static_cast<void>(any(false)); }

Ranks& one_rank() {
  static OneRank one;
  return one;
}

void RankReader::refuse() {
  throw Error(ErrorKind::kInternal, "ranks: found bytes of something else than was sent");
}

void need_same(Ranks& ranks, const std::vector<RankField>& fields) {
  if (ranks.size() == 1) return;
  RankWriter own;
  own.put(std::vector<std::uint64_t>{fields.size()});
  for (const RankField& field : fields) {
    own.put(field.name);
    own.put(field.value);
  }
  const Ranks::Bytes bytes = own.take();
  const std::span<const Ranks::Message> all = ranks.all_gather(bytes);
  const std::vector<RankField> expected = fields_in(all.front());
  for (std::size_t rank = 1; rank < all.size(); ++rank) {
    const std::vector<RankField> found = fields_in(all[rank]);
    for (std::size_t i = 0; i < std::max(found.size(), expected.size()); ++i) {
      const RankField none{"number of fields", fmt::format("{}", i)};
      const RankField& theirs = i < found.size() ? found[i] : none;
      const RankField& wanted = i < expected.size() ? expected[i] : none;
      if (theirs.name == wanted.name && theirs.value == wanted.value) continue;
      throw RanksDiffer(fmt::format(
          "rank {}: {}: found {}, expected {} of rank 0", rank, wanted.name, theirs.value, wanted.value));
    }
  }
}

}  // namespace simuli
