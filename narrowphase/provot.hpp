// The elementary test of 2011, for the paper's Table I as it was measured then: scalar, plainly written.
#pragma once

#include <volccd/narrowphase/narrow_phase.hpp>

namespace volccd {

/// Provot 1997 and Bridson et al. 2002 as published (narrowphase/provot_test.hpp): real roots of the coplanarity cubic
/// in [0,1], in ascending order, and at each the inside test of a vertex in a triangle or of two edges. One test at a
/// time, in doubles; no filter before the roots, no rounding bounds, no vector registers. What it leaves out of `cubic`
/// is what has been learnt since.
///
/// May miss: contacts at which the cubic touches zero without a change of sign (grazing), contacts at t = 0 that
/// rounding moves out of the step, features that stay in one plane (looked at at t = 0 and t = 1 only), triangles
/// without area at the time of contact (counted as degenerate). May invent: what the tolerance lets through. Times:
/// within about 1e-13 of a single root of a well-conditioned cubic. Of near-degenerate tests that touch
/// (tests/narrowphase/provot_test.cpp) it misses 28 per cent, of random ones none: docs/narrowphase_provot.md.
///
/// Two control points; no separation. Does not allocate but for the contacts. O(1) a test.
class Provot final : public NarrowPhase {
 public:
  struct Config {
    /// By how much weights (barycentric coordinates, parameters of edges) may lie outside [0,1]; of parallel edges, the
    /// distance relative to the longer one. Bridson et al. have a rounding tolerance of 1e-6 in lengths; the default is
    /// that of `cubic`.
    double tolerance = 1e-10;
  };
  static const Options<Config>& options();

  Provot() : Provot(Config{}) {}
  explicit Provot(Config config) : config_(config) {}

  /// A contact found with t_max = 1 is found with the same bits for every t_max >= its time, and not for a smaller one.
  /// Pre: two control points, separation 0 (asserted; a pipeline refuses other combinations).
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override;

 private:
  Config config_;
};

StageDescriptor<NarrowPhase> describe_provot();

}  // namespace volccd
