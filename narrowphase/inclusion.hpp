// The certified elementary test: never misses a contact, and reports hardly one too many.
#pragma once

#include <volccd/narrowphase/narrow_phase.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

/// How near an undecided test comes at least, in sizes of the test.
inline constexpr double kUndecidedDistance = 0x1p-40;

enum class Undecided {
  report,  ///< as a contact, and count it
  exact    ///< decide in rational arithmetic
};

/// Guarantees, for the given doubles taken as exact:
/// - No contact is missed: a test is dropped only if every moment of the step is proven free of contact.
/// - Time: never late; early by at most `time_tolerance`.
/// - Undecided tests, counted in NarrowCounters::undecided, stay open in a part of the step shorter than 2^-44. They
///   are reported (time: the start of that part) or, with `undecided=exact`, decided by `exact`: no contact too many.
///   What is reported comes closer than kUndecidedDistance times its size (the greatest coordinate difference between
///   its points at the control points). Where the features stay near each other for longer than the tolerance, or the
///   search is cut short after `most_parts`, `exact` decides in either case. The exception are coordinates that span
///   more than `exact_bits` bits (1 beside 1e-300, say): such a test stays undecided and is reported, perhaps earlier
///   than the tolerance says and although the features stay further apart.
/// - With a separation, which `exact` does not know, all undecided tests are reported: a pair that only grazes it may
///   be reported earlier than the tolerance says, and one whose search was cut short may stay further off.
///
/// Way: pieces of the step, from the left. A piece is free of contact if the Bernstein coefficients of the coplanarity
/// polynomial have one sign, or if an axis separates the features' control points; the axes tried are the directions
/// between the closest points at the likely time of contact, and the one that worked last. It begins with a contact for
/// certain if the polynomial changes sign while the features overlap as seen along a fixed direction. Else it is split.
/// Every sign is trusted beyond its rounding bound only (docs/numerics.md). Most tests end in a vector kernel before.
///
/// Two or three control points, any separation. Does not allocate but for the contacts (and in `exact`). See also
/// Snyder et al. 1993 and Wang et al. 2021 for inclusion-based tests, Tang et al. 2010 and 2014 for Bernstein signs.
class Inclusion final : public NarrowPhase {
 public:
  struct Config {
    /// How early a contact may be reported, in steps.
    double time_tolerance = 1e-9;
    Undecided undecided = Undecided::report;
    int most_parts = 1000;  ///< of a test that the search looks at
    /// Bits that the coordinates of a test may span (coordinate_bits()) for `exact` to decide what the search leaves
    /// open for too long. Costs: docs/narrowphase_exact.md; a third of a second was the longest seen up to 1024 bits,
    /// seconds over the range of all doubles. Ordinary data: 53 to 150. `undecided=exact` knows no such limit.
    int exact_bits = 1024;
  };
  static const Options<Config>& options();

  Inclusion() : Inclusion(Config{}) {}
  explicit Inclusion(Config config) : config_(config) {}

  int max_control_points() const override { return 3; }
  bool handles_separation() const override { return true; }
  double time_tolerance() const override { return config_.time_tolerance; }

  /// A contact found with t_max = 1 is found with the same bits for every t_max >= its time, and not for a smaller one.
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override;

 private:
  void test_one(const Step& step, FeatureKind kind, const std::array<Index, 4>& vertices,
                std::vector<Contact>& contacts, NarrowCounters& counters) const;

  Config config_;
};

StageDescriptor<NarrowPhase> describe_inclusion();

}  // namespace volccd
