#include <volccd/simulation/elements/principal_stress.hpp>

#include <Eigen/Eigenvalues>

namespace volccd::simulation {

PrincipalStress greatest_principal(const Eigen::Matrix3d& stress) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(stress);
  const Vec3 direction = solver.eigenvectors().col(2);
  Eigen::Index largest = 0;
  direction.cwiseAbs().maxCoeff(&largest);
  return {solver.eigenvalues()[2], direction[largest] < 0 ? Vec3(-direction) : direction};
}

}  // namespace volccd::simulation
