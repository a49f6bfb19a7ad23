// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <list>
#include <unordered_map>
#include <utility>

namespace m100::lab::identify {

/// Mixes the bits of a hash value into another.
inline std::size_t mixed(std::size_t seed, std::size_t value) {
  return seed ^ (value + 0x9E3779B97F4A7C15ULL + (seed << 6U) + (seed >> 2U));
}

/// Values by key; the one that was used longest ago is dropped first. Cost: O(1).
template <typename Key, typename Value, typename Hash>
class RecentlyUsed {
 public:
  /// nullptr: not known. Valid until the value is dropped.
  Value* find(const Key& key) {
    const auto known = index_.find(key);
    if (known == index_.end()) {
      return nullptr;
    }
    values_.splice(values_.begin(), values_, known->second);
    return &values_.front().second;
  }
  /// Keeps at most `max_count` values, this one among them. Precondition: the key is not known.
  Value& keep(const Key& key, Value value, std::size_t max_count) {
    while (!values_.empty() && values_.size() >= max_count) {
      index_.erase(values_.back().first);
      values_.pop_back();
    }
    values_.emplace_front(key, std::move(value));
    index_.emplace(key, values_.begin());
    return values_.front().second;
  }

 private:
  std::list<std::pair<Key, Value>> values_;  ///< most recently used first
  std::unordered_map<Key, typename std::list<std::pair<Key, Value>>::iterator, Hash> index_;
};

}  // namespace m100::lab::identify
