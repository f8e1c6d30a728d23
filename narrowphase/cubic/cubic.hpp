// The elementary test that the paper used (Provot 1997; Bridson et al. 2002): finds the roots of the coplanarity cubic,
// and tests at each root whether the features touch, in doubles.
#pragma once

#include <volccd/query/contact.hpp>
#include <volccd/query/roles/narrow_phase.hpp>

namespace volccd {

/// Contact is defined by a distance: at a time when the four points are coplanar, the features are at most `tolerance`
/// times the size of the test apart. The size is the largest coordinate difference between the first point and another
/// point, at t = 0 or 1. The first such time is reported; it is 0 for a pair that touches at t = 0.
///
/// Missed contacts: none are known for tests whose coordinates span at most 300 bits (coordinate_bits()). The
/// coefficients of the cubic have rounding bounds. A root that no certain change of sign proves is examined again with
/// coefficients of twice the precision, and then with the coefficients of the short time interval in which the sign
/// remains uncertain. Extra contacts: only pairs that come within the tolerance. Time: within 1e-12 of the root, or
/// within 1e-6 for a few degenerate tests. If the points are coplanar for longer, as far as doubles can determine, the
/// time is the first time in that interval at which the features are within the tolerance.
///
/// Degenerate geometry (points coplanar over a time interval, parallel edges, triangles and edges without extent, no
/// relative motion) is counted, and is decided by the events at which coplanar features can begin to touch. The normal
/// of such a contact is the direction in which the features were separated just before it; at t = 0, the motion is
/// extrapolated backwards.
///
/// Two control points; no separation. Allocates memory for contacts only. O(1) per test; with `coplanarity`, a vector
/// kernel decides most tests by proving that the cubic has no root.
class Cubic final : public NarrowPhase {
 public:
  struct Config {
    /// Largest distance of touching features, relative to the size of the test.
    double tolerance = 1e-10;
    /// Before the cubic is computed, drop tests whose features the x, y or z axis separates at both ends of the step
    /// (Corollaries 1 and 3).
    bool axis_test = true;
    /// Drop tests whose cubic has no root, as the signs of its Bernstein coefficients prove (Tang et al. 2010); a
    /// vector lane processes one test. Without this option the contacts are the same, but the search for roots
    /// processes every test, one at a time.
    bool coplanarity = true;
  };
  static const Options<Config>& options();

  Cubic() : Cubic(Config{}) {}
  explicit Cubic(Config config) : config_(config) {}

  /// A contact that is found with t_max = 1 is found with the same bits for every t_max >= its time, and is not found
  /// for a smaller t_max.
  /// Pre: two control points, separation 0 (asserted; a pipeline refuses other combinations).
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override;

 private:
  Config config_;
};

StageDescriptor<NarrowPhase> describe_cubic();

}  // namespace volccd
