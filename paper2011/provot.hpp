// The elementary test of 2011, for Table I as the paper measured it: plain scalar code.
#pragma once

#include <volccd/query/roles/narrow_phase.hpp>

namespace volccd {

/// Provot 1997 and Bridson et al. 2002 as published (paper2011/provot_test.hpp): finds the real roots of the
/// coplanarity cubic in [0,1] in ascending order, and tests at each root whether the vertex is inside the triangle or
/// the edges intersect. Tests are performed one at a time in doubles, without filters before the root search, rounding
/// bounds or vector instructions. Compared with `cubic`, it lacks later improvements.
///
/// It may miss contacts at which the cubic touches zero without a change of sign (grazing), contacts at t = 0 that
/// rounding moves out of the step, contacts of features that stay in one plane (tested at t = 0 and t = 1 only), and
/// contacts of triangles without area at the time of contact (counted as degenerate). It may report false contacts
/// within the tolerance. Times are within about 1e-13 of a single root of a well-conditioned cubic. It misses 28 per
/// cent of the near-degenerate tests that touch (tests/paper2011/provot_test.cpp), and none of the random ones:
/// docs/narrowphase_provot.md.
///
/// Two control points; no separation. Allocates memory for contacts only. O(1) per test.
class Provot final : public NarrowPhase {
 public:
  struct Config {
    /// By how much weights (barycentric coordinates, edge parameters) may be outside [0,1]; for parallel edges, the
    /// distance relative to the longer edge. Bridson et al. use a rounding tolerance of 1e-6 in lengths; the default is
    /// that of `cubic`.
    double tolerance = 1e-10;
  };
  static const Options<Config>& options();

  Provot() : Provot(Config{}) {}
  explicit Provot(Config config) : config_(config) {}

  /// A contact that is found with t_max = 1 is found with the same bits for every t_max >= its time, and is not found
  /// for a smaller t_max.
  /// Pre: two control points, separation 0 (asserted; a pipeline refuses other combinations).
  void run(const Step& step, StageState& state, unsigned worker, const TestBlock& block, std::vector<Contact>& contacts,
           NarrowCounters& counters) const override;

 private:
  Config config_;
};

StageDescriptor<NarrowPhase> describe_provot();

}  // namespace volccd
