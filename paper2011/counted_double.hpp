// A double that counts the operations made with it.
#pragma once

#include <cmath>
#include <cstdint>

namespace volccd {

struct OperationCounts {
  std::uint64_t additions = 0;  ///< and subtractions
  std::uint64_t multiplications = 0, divisions = 0, comparisons = 0, square_roots = 0;
  std::uint64_t absolute_values = 0;

  friend bool operator==(const OperationCounts&, const OperationCounts&) = default;
};

/// Computes bit for bit as double, and counts the operations in counts(). A change of sign is not counted. All values
/// of this type share one count, so that only one thread may compute with them at a time.
class CountedDouble {
 public:
  CountedDouble(double value = 0) : value_(value) {}  // NOLINT(google-explicit-constructor): takes the place of double

  double value() const { return value_; }

  /// The operations since the caller last set this value.
  static OperationCounts& counts() {
    static OperationCounts counts;
    return counts;
  }

  friend CountedDouble operator+(CountedDouble a, CountedDouble b) { return ++counts().additions, a.value_ + b.value_; }
  friend CountedDouble operator-(CountedDouble a, CountedDouble b) { return ++counts().additions, a.value_ - b.value_; }
  friend CountedDouble operator*(CountedDouble a, CountedDouble b) {
    return ++counts().multiplications, a.value_ * b.value_;
  }
  friend CountedDouble operator/(CountedDouble a, CountedDouble b) { return ++counts().divisions, a.value_ / b.value_; }
  friend CountedDouble operator-(CountedDouble a) { return -a.value_; }
  friend bool operator<(CountedDouble a, CountedDouble b) { return ++counts().comparisons, a.value_ < b.value_; }
  friend bool operator>(CountedDouble a, CountedDouble b) { return ++counts().comparisons, a.value_ > b.value_; }
  friend bool operator<=(CountedDouble a, CountedDouble b) { return ++counts().comparisons, a.value_ <= b.value_; }
  friend bool operator>=(CountedDouble a, CountedDouble b) { return ++counts().comparisons, a.value_ >= b.value_; }
  friend bool operator==(CountedDouble a, CountedDouble b) { return ++counts().comparisons, a.value_ == b.value_; }
  friend CountedDouble abs(CountedDouble a) { return ++counts().absolute_values, std::abs(a.value_); }
  friend CountedDouble sqrt(CountedDouble a) { return ++counts().square_roots, std::sqrt(a.value_); }

 private:
  double value_;
};

}  // namespace volccd
