// Continuous separating axis test between elements (CSAT): Section 4, Theorem 1, Corollaries 2 and 4, Algorithm 2.
#pragma once

#include <volccd/query/roles/element_culling.hpp>

namespace volccd {

/// How the separating axis L of a test is chosen. Every choice is deterministic: random picks are hashes of element
/// ids.
enum class CsatAxis {
  face,           ///< as in the paper: normal at t = 0 of a face; for an edge, its cross product with an edge of the
                  ///< other element. Face and edge are picked once for each element pair
  predetermined,  ///< the 13 axes of the 26-DOP, one after the other
  velocity,       ///< direction of the mean relative motion
  centroid,       ///< line between the means of the control points
  optimal         ///< iterative search that starts at `centroid`: finds an axis if there is one, except for the limit
                  ///< `iterations` and for rounding
};

enum class CsatMode {
  features,  ///< Algorithm 2: each vertex of a against b, each vertex of b against a, each edge of a against b
  pair,      ///< one axis that separates the two elements
  both       ///< first `pair`, then `features` for the remaining pairs
};

/// Culls with axes L onto which the projections of two point sets remain disjoint: the projection of q - p has the same
/// sign for all vertices p of one set and q of the other, at each control point. By the convex-hull property it has
/// that sign throughout the step, for straight and for curved trajectories (Theorem 1 for two control points).
///
/// Guarantee: conservative in floating point for any finite coordinates. A sign is used only if the magnitude exceeds
/// its rounding bound (numerics/rounding.hpp), and with step.separation = d > 0 also d |L|; an overflow means
/// "not separated". For step.t_max < 1 the control points of the motion over [0, t_max] are used.
///
/// Mode `features` drops a pair as contact_free if no test of it remains: all vertices of a and of b and all edges of a
/// (or of b) are masked. Element pairs with more than 32 vertices in an element, and motions with more than 3 control
/// points, are not culled.
///
/// `optimal` decides whether the origin is outside conv{B_c - A_c}, the convex hull of the Minkowski differences at all
/// control points c, by the Gilbert-Johnson-Keerthi algorithm on their common support function. One iteration is
/// O(vertices). For the axes `centroid` and `optimal`, many whole pairs are first tested together in single precision,
/// with separate rounding bounds (docs/csat.md). The verdict on a pair depends neither on the other pairs of its batch
/// nor on the processor.
class Csat final : public ElementCulling {
 public:
  struct Config {
    CsatAxis axis = CsatAxis::optimal;
    CsatMode mode = CsatMode::both;
    int iterations = 8;       ///< maximum number of axes that `optimal` tries, in each precision
    bool edges_of_b = false;  ///< mode `features` also tests the edges of b against a
  };
  static const Options<Config>& options();

  explicit Csat(const Config& config) : config_(config) {}

  void run(const Step& step, StageState& state, unsigned worker, PairBatch& batch) const override;

 private:
  Config config_;
};

StageDescriptor<ElementCulling> describe_csat();

}  // namespace volccd
