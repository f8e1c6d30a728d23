// The certified elementary test: never misses a contact, and reports almost no false contacts.
#pragma once

#include <volccd/query/contact.hpp>
#include <volccd/query/roles/narrow_phase.hpp>

namespace volccd {

/// Features of an undecided test without a separation come closer to each other than this value, relative to the size
/// of the test.
inline constexpr double kUndecidedDistance = 0x1p-40;

enum class Undecided {
  report,  ///< report as a contact, and count
  exact    ///< decide in rational arithmetic
};

/// Guarantees, for the given doubles regarded as exact:
/// - No contact is missed: a test is dropped only if all times of the step are proven free of contact.
/// - The reported time is never late, and early by at most `time_tolerance`.
/// - A test is undecided if it remains open in an interval of the step that is shorter than 2^-44. It is counted in
///   NarrowCounters::undecided. By default it is reported, and its time is the start of that interval; with
///   `undecided=exact`, `exact` decides it, so that there are no false contacts. The features of a reported test come
///   closer than kUndecidedDistance times its size (the greatest coordinate difference between its points at the
///   control points), beyond the separation. If the features stay near each other for longer than the tolerance, or the
///   search ends after `max_intervals`, `exact` decides with either option. Exception: if the coordinates span more
///   than `exact_bits` bits (for example 1 and 1e-300), such a test remains undecided and is reported; its time may be
///   earlier than the tolerance allows, and its features may be further apart.
///
/// Method: the step is divided into intervals, which are processed in ascending order. An interval is free of contact
/// if the Bernstein coefficients of the coplanarity polynomial have the same sign, or if an axis separates the control
/// points of the features; the axes are the directions between the closest points at the likely time of contact, and
/// the last successful axis. An interval certainly begins with a contact if the polynomial changes its sign while the
/// features overlap in the projection along a fixed direction. Otherwise the interval is split. With a separation, the
/// axis turns with the direction between the closest points, and two points within the separation are a contact. A sign
/// is used only if the magnitude exceeds its rounding bound (docs/numerics.md). Vector kernels decide most tests before
/// this search. With a separation or three control points, they only drop tests that the search would drop as well
/// (with a small `max_intervals`, also tests that it would give up and report), and, with a separation, find the
/// contacts at t = 0 that it would find.
///
/// Two or three control points, any separation. Allocates memory for contacts only (and in `exact`). See also Snyder et
/// al. 1993 and Wang et al. 2021 for inclusion-based tests, Tang et al. 2010 and 2014 for Bernstein signs.
class Inclusion final : public NarrowPhase {
 public:
  struct Config {
    /// How early a contact may be reported, as a fraction of the step.
    double time_tolerance = 1e-9;
    Undecided undecided = Undecided::report;
    int max_intervals = 1000;  ///< maximum number of intervals that the search examines per test
    /// Largest number of bits that the coordinates of a test may span (coordinate_bits()) if `exact` is to decide a
    /// test that the search leaves open for too long. The time that `exact` takes increases with them: the longest time
    /// observed is a third of a second up to 1024 bits, and seconds for the full range of doubles. Ordinary data span
    /// 53 to 150 bits. `undecided=exact` ignores this limit.
    int exact_bits = 1024;
  };
  static const Options<Config>& options();

  Inclusion() : Inclusion(Config{}) {}
  explicit Inclusion(Config config) : config_(config) {}

  int max_control_points() const override { return 3; }
  bool handles_separation() const override { return true; }
  double time_tolerance() const override { return config_.time_tolerance; }

  /// A contact that is found with t_max = 1 is found with the same bits for every t_max >= its time, and is not found
  /// for a smaller t_max.
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override;

  /// With a separation: those of which doubles prove it.
  void find_at_start(const Step& step, const TestBlock& block, std::vector<Contact>& contacts,
                     std::span<std::uint8_t> keep) const override;

 private:
  void test_one(const Step& step, FeatureKind kind, const std::array<Index, 4>& vertices,
                std::vector<Contact>& contacts, NarrowCounters& counters) const;

  Config config_;
};

StageDescriptor<NarrowPhase> describe_inclusion();

}  // namespace volccd
