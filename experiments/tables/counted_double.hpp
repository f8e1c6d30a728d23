// A double that counts what is done with it.
#pragma once

#include <cmath>
#include <cstdint>

namespace volccd {

struct OperationCounts {
  std::uint64_t additions = 0;  ///< and subtractions
  std::uint64_t multiplications = 0, divisions = 0, comparisons = 0, square_roots = 0;

  friend bool operator==(const OperationCounts&, const OperationCounts&) = default;
};

/// Calculates as double does, bit for bit, and counts into counts(). A change of sign is not counted. Thread rule: all
/// values of this type share one count, so that only one thread may calculate with them at a time.
class CountedDouble {
 public:
  CountedDouble(double value = 0) : value_(value) {}  // NOLINT(google-explicit-constructor): takes the place of double

  double value() const { return value_; }

  /// Since the caller last set it.
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
  friend CountedDouble sqrt(CountedDouble a) { return ++counts().square_roots, std::sqrt(a.value_); }

 private:
  double value_;
};

}  // namespace volccd
