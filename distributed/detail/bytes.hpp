// Numbers as bytes of a message, and back.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstring>
#include <span>
#include <type_traits>
#include <vector>

#include <volccd/distributed/exchange.hpp>

namespace volccd::distributed::detail {

template <class T>
void put_values(Bytes& bytes, std::span<const T> values) {
  static_assert(std::is_trivially_copyable_v<T>);
  const std::size_t size = bytes.size();
  bytes.resize(size + values.size_bytes());
  if (!values.empty()) std::memcpy(bytes.data() + size, values.data(), values.size_bytes());
}
template <class T>
void put_values(Bytes& bytes, const std::vector<T>& values) {
  put_values(bytes, std::span<const T>(values));
}
template <class T>
void put(Bytes& bytes, const T& value) {
  put_values(bytes, std::span<const T>(&value, 1));
}

/// Reads what the functions above wrote, in the same order and with the same types.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : rest_(bytes) {}

  bool at_end() const { return rest_.empty(); }

  template <class T>
  T get() {
    T value;
    copy(&value, sizeof value);
    return value;
  }
  /// Appends `count` values.
  template <class T>
  void append(std::size_t count, std::vector<T>& values) {
    const std::size_t size = values.size();
    values.resize(size + count);
    copy(values.data() + size, count * sizeof(T));
  }

 private:
  void copy(void* to, std::size_t size) {
    assert(size <= rest_.size());
    if (size > 0) std::memcpy(to, rest_.data(), size);
    rest_ = rest_.subspan(size);
  }

  std::span<const std::byte> rest_;
};

/// All values of a message that consists of values of one type.
template <class T>
std::vector<T> values_of(const Bytes& bytes) {
  std::vector<T> values;
  Reader(bytes).append(bytes.size() / sizeof(T), values);
  return values;
}

}  // namespace volccd::distributed::detail
