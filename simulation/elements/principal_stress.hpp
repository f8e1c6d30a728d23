// The greatest principal stress, normal to whose direction cracks open.
#pragma once

#include <volccd/numerics/types.hpp>

namespace volccd::simulation {

struct PrincipalStress {
  double value;
  Vec3 direction;  ///< of length 1; its largest component is positive, since an eigenvector's sign means nothing
};

/// `stress`: symmetric and finite.
PrincipalStress greatest_principal(const Eigen::Matrix3d& stress);

}  // namespace volccd::simulation
