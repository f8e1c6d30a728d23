// Serialisation of simulations: the same code writes the state to a checkpoint and reads it back.
#pragma once

#include <cstdint>
#include <istream>
#include <ostream>
#include <type_traits>
#include <vector>

#include <volccd/core/error.hpp>

namespace volccd::simulation {

/// Writes or reads values as they are in memory, so that only the same machine and build can read them. Throws
/// InputError when the stream ends early or fails.
class Archive {
 public:
  explicit Archive(std::ostream& out) : out_(&out) {}
  explicit Archive(std::istream& in) : in_(&in) {}

  bool reading() const { return in_ != nullptr; }

  template <typename T>
  void operator()(T& value) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes(&value, sizeof(T));
  }

  /// Writes or reads a vector of plain values (numbers, Vec3), with its size.
  template <typename T>
  void operator()(std::vector<T>& values) {
    static_assert(std::is_trivially_destructible_v<T>);
    std::uint64_t size = values.size();
    (*this)(size);
    if (reading()) values.resize(static_cast<std::size_t>(size));
    bytes(values.data(), values.size() * sizeof(T));
  }

 private:
  void bytes(void* data, std::size_t size) {
    if (size == 0) return;
    if (in_) in_->read(static_cast<char*>(data), static_cast<std::streamsize>(size));
    if (out_) out_->write(static_cast<const char*>(data), static_cast<std::streamsize>(size));
    if ((in_ && !*in_) || (out_ && !*out_)) throw InputError("checkpoint", "", "ends early or cannot be written");
  }

  std::istream* in_ = nullptr;
  std::ostream* out_ = nullptr;
};

}  // namespace volccd::simulation
