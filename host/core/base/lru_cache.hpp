#pragma once
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <unordered_map>
#include <utility>

namespace simuli {

/// Keeps what was used last within a budget of bytes. What a caller still holds stays alive when it is
/// dropped from the cache; an entry larger than the whole budget is handed out and not kept.
template <class T, class Key = std::size_t, class Hash = std::hash<Key>>
class LruCache {
 public:
  explicit LruCache(std::size_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// The entry under `key`, made by `make()` unless it is here. `bytes_of(entry)` is its size.
  template <class Make, class BytesOf>
  std::shared_ptr<const T> get(const Key& key, const Make& make, const BytesOf& bytes_of) {
    if (auto found = find(key)) return found;
    auto value = std::make_shared<const T>(make());
    const std::size_t bytes = bytes_of(*value);
    if (bytes > budget_bytes_) return value;
    while (used_bytes_ + bytes > budget_bytes_) {
      used_bytes_ -= entries_.back().bytes;
      where_.erase(entries_.back().key);
      entries_.pop_back();
    }
    entries_.push_front({key, bytes, value});
    where_[key] = entries_.begin();
    used_bytes_ += bytes;
    return value;
  }
  /// The entry under `key`, now the one used last; null: not here.
  [[nodiscard]] std::shared_ptr<const T> find(const Key& key) {
    const auto found = where_.find(key);
    if (found == where_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found->second);
    return found->second->value;
  }
  /// The entry under `key`, which is no longer kept; null: not here.
  [[nodiscard]] std::shared_ptr<const T> take(const Key& key) {
    auto value = find(key);
    if (value) {
      used_bytes_ -= entries_.front().bytes;
      where_.erase(key);
      entries_.pop_front();
    }
    return value;
  }
  [[nodiscard]] std::size_t used_bytes() const { return used_bytes_; }
  [[nodiscard]] std::size_t size() const { return entries_.size(); }

 private:
  struct Entry {
    Key key;
    std::size_t bytes;
    std::shared_ptr<const T> value;
  };
  std::size_t budget_bytes_;
  std::size_t used_bytes_ = 0;
  std::list<Entry> entries_;  // last used first
  std::unordered_map<Key, typename std::list<Entry>::iterator, Hash> where_;
};

}  // namespace simuli
