// A small finite-element solver whose contacts come from volccd: a block falls onto a clamped beam and breaks it.
// docs/into_a_solver.md goes through this file; examples/python/solver.py is the same program in Python.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <Eigen/Dense>

#include <volccd/core/error.hpp>
#include <volccd/pipelines/detector.hpp>

using namespace volccd;
using Mat3 = Eigen::Matrix3d;
using Points = std::vector<Vec3>;

namespace {

// Units: m, kg, s.
constexpr double kTimeStep = 1e-3;
constexpr int kSteps = 300;
constexpr double kDensity = 1000, kShearModulus = 2e5, kLame = 3e5, kGravity = 9.81;
constexpr double kStrainLimit = 0.3;  // of the largest principal Green strain; beyond it, an element breaks
constexpr double kSeparation = 1e-5;  // distance at which features stop approaching each other
constexpr int kSweeps = 5;            // passes over the contacts in which impulses are applied
constexpr int kMaxParts = 10;         // parts of a step; the rest of its time is omitted
// The block at the beginning; the beam has its corner at the origin.
const Vec3 kImpactVelocity(0, 0, -6), kSpin(6, 4, 2);
const Vec3 kBlockSize(0.4, 0.36, 0.4), kBlockCentre(0.97, 0.21, 0.41);

enum Body : std::int32_t { beam, block };

/// Adds a box of nx * ny * nz cubes, each divided into six tetrahedra of positive volume.
void add_box(Mesh& mesh, Points& x, Body body, const Vec3& origin, const Vec3& size, const std::array<Index, 3>& n) {
  const Index first = mesh.vertex_count();
  const auto vertex = [&](Index i, Index j, Index k) { return first + (i * (n[1] + 1) + j) * (n[2] + 1) + k; };
  for (Index i = 0; i <= n[0]; ++i)
    for (Index j = 0; j <= n[1]; ++j)
      for (Index k = 0; k <= n[2]; ++k)
        x.push_back(origin + size.cwiseProduct(Vec3(double(i) / n[0], double(j) / n[1], double(k) / n[2])));
  mesh.add_vertices(static_cast<Index>(x.size()) - first);

  // Paths along the edges of a cube from (0,0,0) to (1,1,1); those of odd permutations exchange two vertices.
  constexpr int axes[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  for (Index i = 0; i < n[0]; ++i)
    for (Index j = 0; j < n[1]; ++j)
      for (Index k = 0; k < n[2]; ++k)
        for (int path = 0; path < 6; ++path) {
          std::array<Index, 3> corner = {i, j, k};
          std::vector<Index> tetrahedron = {vertex(i, j, k)};
          for (const int axis : axes[path]) {
            ++corner[axis];
            tetrahedron.push_back(vertex(corner[0], corner[1], corner[2]));
          }
          if (path >= 3) std::swap(tetrahedron[1], tetrahedron[2]);
          mesh.add_element(
              {.type = ElementType::tetrahedron, .vertices = tetrahedron, .object = body, .id = mesh.element_count()});
        }
}

/// Both bodies, as one mesh with one array of positions and velocities.
class Solver {
 public:
  // The detectors use all threads of the machine. They find contacts within a body and inversions, too.
  Solver() : detector_(make_mesh(x_), {.threads = 0}), judge_(mesh(), {.pipeline = "NavCCD", .threads = 0}) {
    elements_.resize(mesh().element_slots());
    std::vector<double> mass(x_.size(), 0.0);
    v_.assign(x_.size(), Vec3::Zero());
    for (Index o = 0; o < mesh().element_slots(); ++o) {
      const Mat3 edges = edge_matrix(mesh().vertices(o), x_);
      elements_[o] = {edges.inverse(), edges.determinant() / 6};
      for (const Index v : mesh().vertices(o)) {
        mass[v] += kDensity * elements_[o].volume / 4;
        if (mesh().object(o) == block) v_[v] = kImpactVelocity + kSpin.cross(x_[v] - kBlockCentre);
      }
    }
    for (std::size_t v = 0; v < x_.size(); ++v) {
      const bool clamped = x_[v].x() == 0 || x_[v].x() == 2;
      inverse_mass_.push_back(clamped ? 0 : 1 / mass[v]);
    }
    rest_ = x_;
    first_energy_ = min_energy_ = energy();
  }

  bool good() const { return good_; }

  /// One step: candidate velocities; contacts, response and the largest safe motion; then elements that break.
  void advance() {
    add_forces();
    move();
    remove_broken_elements();
  }

  void print_heading() const { std::puts("time [s]  removed  contacts  shortened  height [m]  energy [J]"); }
  void print() const {
    std::printf("%8.3f  %7d  %8d  %9d  %10.4f  %10.2f\n", time_, removed_, contact_count_, shortened_, height(),
                energy());
  }

 private:
  struct Element {
    Mat3 inverse_rest;  ///< of the matrix of edges at rest
    double volume;      ///< at rest
  };

  const Mesh& mesh() const { return detector_.mesh(); }

  static Mesh make_mesh(Points& x) {
    Mesh mesh;
    add_box(mesh, x, beam, {0, 0, 0}, {2, 0.4, 0.2}, {10, 2, 1});
    add_box(mesh, x, block, kBlockCentre - kBlockSize / 2, kBlockSize, {2, 2, 2});
    return mesh;
  }

  static Mat3 edge_matrix(std::span<const Index> tetrahedron, const Points& x) {
    Mat3 edges;
    for (int i = 0; i < 3; ++i) edges.col(i) = x[tetrahedron[i + 1]] - x[tetrahedron[0]];
    return edges;
  }
  Mat3 deformation_gradient(Index o) const { return edge_matrix(mesh().vertices(o), x_) * elements_[o].inverse_rest; }

  /// Calls body(slot, deformation gradient F) for each element.
  template <class Body>
  void for_each_element(Body body) const {
    for (Index o = 0; o < mesh().element_slots(); ++o)
      if (mesh().is_live(o)) body(o, deformation_gradient(o));
  }

  /// Explicit step of the velocities: gravity and neo-Hookean elements, P = mu (F - F^-T) + lambda ln(det F) F^-T.
  void add_forces() {
    Points force(x_.size(), Vec3::Zero());
    for_each_element([&](Index o, const Mat3& f) {
      const Mat3 inverse = f.inverse().transpose();
      const Mat3 stress = kShearModulus * (f - inverse) + kLame * std::log(f.determinant()) * inverse;
      const Mat3 forces = -elements_[o].volume * stress * elements_[o].inverse_rest.transpose();
      const auto vertices = mesh().vertices(o);
      for (int i = 0; i < 3; ++i) {
        force[vertices[i + 1]] += forces.col(i);
        force[vertices[0]] -= forces.col(i);
      }
    });
    for (std::size_t v = 0; v < x_.size(); ++v)
      if (inverse_mass_[v] > 0) v_[v] += kTimeStep * (inverse_mass_[v] * force[v] - Vec3(0, 0, kGravity));
  }

  /// The positions of the vertices after a time.
  Points moved(double time) const {
    Points x1 = x_;
    for (std::size_t v = 0; v < x_.size(); ++v) x1[v] += time * v_[v];
    return x1;
  }

  /// The velocity at which the features of a contact separate along its normal; negative if they approach.
  struct Approach {
    std::array<double, 4> weights;  ///< of the velocities; negative on the second feature
    double speed = 0, inverse_mass = 0;
  };
  Approach approach(const Contact& contact) const {
    Approach result{contact.weights};
    for (int i = contact.kind == FeatureKind::vf ? 1 : 2; i < 4; ++i) result.weights[i] *= -1;
    for (int i = 0; i < 4; ++i) {
      const Index v = contact.vertices[i];
      result.speed += result.weights[i] * contact.normal.dot(v_[v]);
      result.inverse_mass += result.weights[i] * result.weights[i] * inverse_mass_[v];
    }
    return result;
  }

  /// Moves all vertices by their velocities for the time of a step, in as many parts as the contacts demand.
  void move() {
    double left = kTimeStep;
    for (int part = 0; left > 0 && part < kMaxParts; ++part) {
      respond(left);
      const std::optional<Contact> earliest = detector_.first(x_, moved(left));
      const double share = earliest ? 0.9 * earliest->toi : 1;  // the largest safe step, with a reserve
      before_ = std::exchange(x_, moved(share * left));
      left *= 1 - share;
      check();
      if (earliest) stick(*earliest);
    }
    time_ += kTimeStep - left;
  }

  /// Contacts of the motion that comes next, in which features touch or come within the separation, and their impulses.
  void respond(double time) {
    detector_.set_separation(kSeparation);
    const std::vector<Contact>& contacts = detector_.step(x_, moved(time)).contacts;
    detector_.set_separation(0);
    for (int sweep = 0; sweep < kSweeps; ++sweep)
      for (const Contact& contact : contacts) apply_impulse(contact);
    contact_count_ += static_cast<int>(contacts.size());
  }

  /// An inelastic impulse: afterwards, the features no longer approach each other.
  void apply_impulse(const Contact& contact) {
    const Approach found = approach(contact);
    if (found.speed >= 0 || found.inverse_mass == 0) return;
    const double impulse = -found.speed / found.inverse_mass;
    for (int i = 0; i < 4; ++i) {
      const Index v = contact.vertices[i];
      v_[v] += impulse * found.weights[i] * inverse_mass_[v] * contact.normal;
    }
  }

  /// For a contact that the impulses have not resolved, since they disturb each other: its vertices continue with their
  /// common mean velocity.
  void stick(const Contact& contact) {
    Vec3 velocity = Vec3::Zero();  // if one of them is clamped
    if (std::ranges::none_of(contact.vertices, [&](Index v) { return inverse_mass_[v] == 0; })) {
      double mass = 0;
      for (const Index v : contact.vertices) {
        velocity += v_[v] / inverse_mass_[v];
        mass += 1 / inverse_mass_[v];
      }
      velocity /= mass;
    }
    for (const Index v : contact.vertices) v_[v] = velocity;
    ++shortened_;
  }

  /// An element whose largest principal Green strain exceeds the limit is removed. Its vertices keep their mass.
  void remove_broken_elements() {
    std::vector<std::int64_t> broken;
    for_each_element([&](Index o, const Mat3& f) {
      const Mat3 strain = (f.transpose() * f - Mat3::Identity()) / 2;
      const Eigen::SelfAdjointEigenSolver<Mat3> eigen(strain, Eigen::EigenvaluesOnly);
      if (eigen.eigenvalues().maxCoeff() > kStrainLimit) broken.push_back(mesh().element_id(o));
    });
    if (broken.empty()) return;
    for (Detector* detector : {&detector_, &judge_}) detector->edit({.removed = broken});
    removed_ += static_cast<int>(broken.size());
  }

  /// What the solver promises, checked after every motion: nothing touches in it (by another pipeline), no element is
  /// inverted, and the energy does not grow.
  void check() {
    const std::size_t touching = judge_.step(before_, x_).contacts.size();
    double min_volume = HUGE_VAL;
    for_each_element([&](Index, const Mat3& f) { min_volume = std::min(min_volume, f.determinant()); });
    min_energy_ = std::min(min_energy_, energy());
    const double gain = (energy() - min_energy_) / first_energy_;
    if (touching == 0 && min_volume > 0 && gain < 0.02) return;
    std::printf("t = %.4f s: %zu contacts in the accepted motion, least volume %.3g of that at rest, energy %+.2f %%\n",
                time_, touching, min_volume, 100 * gain);
    good_ = false;
  }

  /// Kinetic, elastic and potential energy. The potential energy is 0 at the beginning.
  double energy() const {
    double sum = 0;
    for (std::size_t v = 0; v < x_.size(); ++v)
      if (inverse_mass_[v] > 0) sum += (v_[v].squaredNorm() / 2 + kGravity * (x_[v] - rest_[v]).z()) / inverse_mass_[v];
    for_each_element([&](Index o, const Mat3& f) {
      const double log_volume = std::log(f.determinant());
      sum += elements_[o].volume * (kShearModulus / 2 * (f.squaredNorm() - 3) - kShearModulus * log_volume +
                                    kLame / 2 * log_volume * log_volume);
    });
    return sum;
  }

  /// Mean height of the vertices of the block, weighted by their elements.
  double height() const {
    double sum = 0;
    int count = 0;
    for_each_element([&](Index o, const Mat3&) {
      if (mesh().object(o) != block) return;
      for (const Index v : mesh().vertices(o)) {
        sum += x_[v].z();
        ++count;
      }
    });
    return sum / count;
  }

  Points x_, v_, rest_, before_;      ///< positions and velocities now; positions at rest and before the last motion
  std::vector<double> inverse_mass_;  ///< by vertex; 0: clamped
  /// They keep the tables of the mesh, which are built in the first step and updated after edits.
  Detector detector_, judge_;
  std::vector<Element> elements_;  ///< by element slot
  double time_ = 0, first_energy_ = 0, min_energy_ = 0;
  int removed_ = 0, contact_count_ = 0, shortened_ = 0;
  bool good_ = true;
};

}  // namespace

int main() {
  try {
    Solver solver;
    solver.print_heading();
    for (int step = 0; step < kSteps && solver.good(); ++step) {
      if (step % 30 == 0) solver.print();
      solver.advance();
    }
    solver.print();
    return solver.good() ? 0 : 1;
  } catch (const Error& error) {
    std::fprintf(stderr, "solver: %s\n", error.what());
    return 2;
  }
}
