// An airbag's fabric, folded.
#pragma once

#include <vector>

#include <volccd/oracle/cases/shapes.hpp>

namespace volccd {

/// Two round sheets joined at the rim, lying flat in z = 0 but for zigzag folds, whose lines run along y, that lay both
/// of its sides upon the middle: metres.
struct AirbagShape {
  double radius = 0.33;
  int folds = 4;         ///< a side
  double gap = 0.0012;   ///< between the sheets, along z
  double rise = 0.0075;  ///< of the middle surface from one fold to the next: what keeps layers apart
};

/// A closed surface, its triangles numbered counter-clockwise as seen from outside: object 0 the sheet that is below in
/// the middle, object 1 the other. The middle reaches from z = -gap / 2 to gap / 2, everything else is above. Folds are
/// sharp and follow edges; of the two sheets, the one outside is led around the other with the same gap. No two
/// elements without a common vertex come closer than about a third of the gap; edges as about as long as asked for.
/// Deterministic. Throws ConfigError for sizes not positive or a spacing for which there are not at least two rows
/// between folds.
Shape folded_airbag(const AirbagShape& airbag, double spacing);

/// With the spacing that comes nearest to this number of triangles, within 2 % from some hundreds on.
Shape folded_airbag_of(const AirbagShape& airbag, int triangles);

}  // namespace volccd
