// Continuous separating axis test between elements (CSAT): Section 4, Theorem 1, Corollaries 2 and 4, Algorithm 2.
#pragma once

#include <volccd/culling/element_culling.hpp>

namespace volccd {

/// Where the separating axis L of a test comes from. Every strategy is deterministic: picks hash the element ids.
enum class CsatAxis {
  face,           ///< the paper's: normal at t = 0 of a face, for an edge its cross product with an edge of the other
                  ///< element; face and edge are picked once for each pair of elements
  predetermined,  ///< the 13 axes of the 26-DOP, in turn
  velocity,       ///< direction of the mean relative motion
  centroid,       ///< line between the means of the control points
  optimal         ///< searched from `centroid` on: finds an axis whenever there is one, up to `iterations` and rounding
};

enum class CsatMode {
  features,  ///< Algorithm 2: each vertex of a against b, each vertex of b against a, each edge of a against b
  pair,      ///< one axis that separates the whole elements
  both       ///< pair, then features of the pairs that are left
};

/// Culls with axes L onto which the projections of two point sets stay disjoint: q - p has a projection of one sign for
/// all vertices p of one set and q of the other, at each control point. By the convex-hull property that sign holds all
/// through the step, for straight and for curved trajectories alike (Theorem 1 for two control points).
///
/// Guarantee: conservative in floating point, for any finite coordinates. A sign counts only beyond its rounding bound
/// (query/rounding.hpp), with step.separation = d > 0 only beyond d |L|; overflow counts as not separated. For
/// step.t_max < 1 the control points of the motion over [0, t_max] are taken.
///
/// Features mode drops a pair as contact_free when no test of it is left: all vertices of a and of b and all edges of a
/// (or of b) masked. Elements of more than 32 vertices, and motions of more than 3 control points, pass untouched.
///
/// `optimal` decides whether the origin is outside conv{B_c - A_c}, the hull of the Minkowski differences at the
/// control points: Gilbert-Johnson-Keerthi on their common support function. O(vertices) an iteration. Whole pairs with
/// axis `centroid` or `optimal` are tested many at a time in single precision first, with its own rounding bounds
/// (docs/csat.md); the verdict on a pair depends neither on the other pairs of its batch nor on the processor.
class Csat final : public ElementCulling {
 public:
  struct Config {
    CsatAxis axis = CsatAxis::optimal;
    CsatMode mode = CsatMode::both;
    int iterations = 8;       ///< most axes that `optimal` tries, in either precision
    bool edges_of_b = false;  ///< features mode tests the edges of b against a, too
  };
  static const Options<Config>& options();

  explicit Csat(const Config& config) : config_(config) {}

  void run(const Step& step, StageState& state, unsigned worker, PairBatch& batch) const override;

 private:
  Config config_;
};

StageDescriptor<ElementCulling> describe_csat();

}  // namespace volccd
