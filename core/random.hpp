// Deterministic random numbers, the same on every platform and standard library (std distributions are not).
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace volccd {

/// Mixes a 64-bit value (the finaliser of SplitMix64, Steele et al. 2014). hash_ids(a, b) replaces a random choice
/// where the result must depend on ids alone (invariant 5).
constexpr std::uint64_t mix(std::uint64_t x) {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}
constexpr std::uint64_t hash_ids(std::uint64_t a, std::uint64_t b) { return mix(mix(a) ^ b); }

/// The random number sequence SplitMix64.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() {
    const std::uint64_t value = mix(state_);
    state_ += 0x9e3779b97f4a7c15u;
    return value;
  }
  /// Uniform in [0, n), for n > 0; the bias is below n / 2^64.
  std::uint64_t below(std::uint64_t n) { return next() % n; }
  /// Uniform in [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  template <class T>
  void shuffle(std::vector<T>& values) {
    for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[below(i)]);
  }

 private:
  std::uint64_t state_;
};

}  // namespace volccd
