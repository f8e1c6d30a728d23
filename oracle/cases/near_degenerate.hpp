// VF and EE tests, and pairs of elements around them, whose features touch by construction or miss each other by a few
// units in the last place.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <volccd/core/random.hpp>
#include <volccd/narrowphase/exact/exact_predicates.hpp>
#include <volccd/query/pairs.hpp>

namespace volccd::cases {

/// The source of a generator's random choices: a seed, a list that rapidcheck makes and shrinks, or the input of a fuzz
/// target. 0 is always the simplest choice, and is returned after the end of a list or an input. Neither is copied.
class Choices {
 public:
  explicit Choices(std::uint64_t seed) : random_(seed) {}
  explicit Choices(const std::vector<std::uint32_t>& list) : random_(0), list_(&list) {}
  explicit Choices(std::span<const std::uint8_t> bytes) : random_(0), bytes_(bytes), from_bytes_(true) {}

  /// In [0, n). Takes one byte of an input if n <= 256, otherwise four, of which the first is the lowest.
  int below(int n) {
    const std::uint32_t value = from_bytes_ ? next_bytes(n <= 256 ? 1 : 4) : next();
    return static_cast<int>(value % static_cast<std::uint32_t>(n));
  }
  bool one_in(int n) { return below(n) == n - 1; }
  /// In [-range, range].
  double lattice(int range) {
    const int k = below(2 * range + 1);
    return k % 2 ? (k + 1) / 2 : -k / 2;
  }
  template <std::size_t N>
  double pick(const double (&values)[N]) {
    return values[below(static_cast<int>(N))];
  }

 private:
  std::uint32_t next() {
    if (!list_) return static_cast<std::uint32_t>(random_.next() >> 32);
    return at_ < list_->size() ? (*list_)[at_++] : 0;
  }
  std::uint32_t next_bytes(std::size_t count) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < count && at_ < bytes_.size(); ++i) value |= std::uint32_t{bytes_[at_++]} << 8 * i;
    return value;
  }

  Random random_;
  const std::vector<std::uint32_t>* list_ = nullptr;
  std::span<const std::uint8_t> bytes_;
  bool from_bytes_ = false;
  std::size_t at_ = 0;
};

using Curve = std::array<Vec3, 3>;

/// Two sets of points. VF: point 0 of the first set is the vertex, points 0..2 of the second are the triangle. EE:
/// points 0 and 1 of each set are an edge. Further points belong to elements around the features.
struct Case {
  FeatureKind kind = FeatureKind::vf;
  int control_points = 2;
  std::array<std::vector<Curve>, 2> sets;
  double separation = 0;
  /// A time by which the features have come within the separation, in exact arithmetic. Negative: not known.
  double touch = -1;

  std::size_t own(std::size_t set) const { return kind == FeatureKind::ee ? 2 : set == 0 ? 1 : 3; }
};

enum class Separation { none, some };

/// A case with sets of `first` and `second` points (at least those of the features).
Case near_degenerate(Choices& choices, FeatureKind kind, int control_points, std::size_t first, std::size_t second,
                     Separation separation = Separation::none);
/// A case without further points, whose kind and number of control points are chosen as well.
Case near_degenerate_test(Choices& choices, Separation separation = Separation::none);

/// The features of a case as bare coordinates, for exact predicates. Does not refer to the case.
class Coordinates {
 public:
  explicit Coordinates(const Case& c);
  TestMotion motion() const;
  /// Greatest difference of coordinates of two points at the same control point.
  double size() const;

 private:
  FeatureKind kind_;
  int control_points_;
  std::array<std::array<double, 9>, 4> points_;
};

/// Whether the features come within the separation by t_max, as known or as decided exactly.
bool touches(const Case& c, double t_max);

/// Coordinates as hexadecimal literals, to be pasted into a test.
std::string to_text(const Case& c);

}  // namespace volccd::cases
