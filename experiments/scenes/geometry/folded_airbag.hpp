// An airbag's fabric, folded.
#pragma once

#include <vector>

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// Two round sheets joined at the rim. They lie flat in z = 0, except that zigzag folds along y place both sides on top
/// of the middle. In metres.
struct AirbagShape {
  double radius = 0.33;
  int folds = 4;         ///< on each side
  double gap = 0.0012;   ///< between the sheets, along z
  double rise = 0.0075;  ///< of the middle surface from one fold to the next, which separates the layers
};

/// A closed surface, whose triangles are counter-clockwise seen from outside. Object 0 is the sheet that is below in
/// the middle, object 1 the other one. The middle reaches from z = -gap / 2 to gap / 2, all other parts are above.
/// Folds are sharp and follow edges; at a fold, the outer sheet goes around the inner one with the same gap. Elements
/// without a common vertex are at least about a third of the gap apart. Edges are about as long as `spacing`.
/// Deterministic. Throws ConfigError for sizes that are not positive, and for a spacing with fewer than two rows
/// between folds.
Shape folded_airbag(const AirbagShape& airbag, double spacing);

/// The same with the spacing that gives about this number of triangles (within 2 % from some hundreds on).
Shape folded_airbag_of(const AirbagShape& airbag, int triangles);

}  // namespace volccd
