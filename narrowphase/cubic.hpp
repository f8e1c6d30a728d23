// The elementary test that the paper used (Provot 1997; Bridson et al. 2002): roots of the coplanarity cubic, then an
// inside test at each, in doubles.
#pragma once

#include <volccd/narrowphase/narrow_phase.hpp>
#include <volccd/query/contact.hpp>

namespace volccd {

/// Contact is defined by distance: at a time when the four points are coplanar, the features are at most `tolerance`
/// times the size of the test apart. The size is the largest coordinate difference between the first point and another,
/// at t = 0 or 1. Reported is the first such time; it is 0 for a pair that touches at the start.
///
/// Missed contacts: none are known of tests whose coordinates span at most 300 bits (coordinate_bits()). The cubic's
/// coefficients have a rounding bound; a root that its sign changes do not prove is looked at again with coefficients
/// of twice the precision, and then with those of the short part of the step in which the sign stays open. Extra
/// contacts: only pairs that come within the tolerance. Time: within 1e-12 of the root, of a few degenerate tests
/// within 1e-6; where the points are coplanar for longer, as far as doubles can tell, the first time in that stretch at
/// which the features are within the tolerance.
///
/// Degenerate geometry (coplanar over a stretch of time, parallel edges, triangles and edges without extent, no
/// relative motion) is decided by the events at which coplanar features can begin to touch, and counted. The normal of
/// such a contact is the direction in which the features were apart just before; at t = 0, with the motion continued
/// backwards.
///
/// Two control points; no separation. Does not allocate but for the contacts. O(1) a test; with `coplanarity`, most
/// tests end in a vector kernel that proves the cubic free of roots.
class Cubic final : public NarrowPhase {
 public:
  struct Config {
    /// Inside test, relative to the size of the test.
    double tolerance = 1e-10;
    /// Before the cubic, drop tests whose features the x, y or z axis separates at both ends (Corollaries 1 and 3).
    bool axis_test = true;
    /// Drop tests whose cubic is proven free of roots by the signs of its Bernstein coefficients (Tang et al. 2010),
    /// one test a lane. The contacts are the same without; then every test goes on to the search for roots, one at a
    /// time.
    bool coplanarity = true;
  };
  static const Options<Config>& options();

  Cubic() : Cubic(Config{}) {}
  explicit Cubic(Config config) : config_(config) {}

  /// A contact found with t_max = 1 is found with the same bits for every t_max >= its time, and not for a smaller one.
  /// Pre: two control points, separation 0 (asserted; a pipeline refuses other combinations).
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override;

 private:
  Config config_;
};

StageDescriptor<NarrowPhase> describe_cubic();

}  // namespace volccd
