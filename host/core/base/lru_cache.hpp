#pragma once
#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <unordered_map>
#include <utility>

namespace simuli {

/// A least-recently-used cache within a budget of bytes. Entries held by callers stay alive after eviction; an
/// entry larger than the budget is returned and not stored.
template <class T, class Key = std::size_t, class Hash = std::hash<Key>>
class LruCache {
 public:
  explicit LruCache(std::size_t budget_bytes) : budget_bytes_(budget_bytes) {}

  /// Returns the entry of `key`, calling `make()` if it is missing. `bytes_of(entry)` is its size.
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
  /// Returns the entry of `key` and marks it as used; null if missing.
  [[nodiscard]] std::shared_ptr<const T> find(const Key& key) {
    const auto found = where_.find(key);
    if (found == where_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found->second);
    return found->second->value;
  }
  /// Removes and returns the entry of `key`; null if missing.
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
  std::list<Entry> entries_;  // most recently used first
  std::unordered_map<Key, typename std::list<Entry>::iterator, Hash> where_;
};

}  // namespace simuli
