#include <volccd/simulation/elements/shell_forces.hpp>

#include <algorithm>
#include <cmath>
#include <tuple>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>
#include <volccd/simulation/elements/detail/shell_kernels.hpp>
#include <volccd/simulation/elements/detail/shell_tables.hpp>

namespace volccd::simulation {
namespace {

using namespace detail;

/// Vertices in a chunk of the sum over blocks.
constexpr std::size_t kShellVertexGrain = 4096;

std::vector<ShellElement> read_elements(const Mesh& mesh, std::span<const Vec3> positions) {
  std::vector<ShellElement> elements;
  for (Index slot = 0; slot < mesh.element_slots(); ++slot) {
    if (mesh.type(slot) == ElementType::quad)
      throw InputError("model", "elements", mesh.element_id(slot), "is a quad; shells are made of triangles");
    if (mesh.type(slot) != ElementType::triangle) continue;
    ShellElement element;
    element.slot = slot;
    element.object = mesh.object(slot);
    const auto vertices = mesh.vertices(slot);
    for (std::size_t k = 0; k < 3; ++k) {
      element.vertices[k] = vertices[k];
      element.corners[k] = positions[vertices[k]];
      if (!element.corners[k].allFinite()) throw InputError("model", "positions", vertices[k], "is not finite");
    }
    elements.push_back(element);
  }
  return elements;
}

std::vector<ShellLaw> read_laws(const Model& model, const std::vector<ShellElement>& elements) {
  std::vector<ShellLaw> laws(model.bodies.size());
  std::vector<bool> done(model.bodies.size(), false);
  for (const ShellElement& e : elements) {
    const auto object = static_cast<std::size_t>(e.object);
    if (e.object < 0 || object >= laws.size()) throw InputError("model", "bodies", e.object, "does not exist");
    if (!done[object]) laws[object] = ShellLaw(model.bodies[object], e.object);
    done[object] = true;
  }
  return laws;
}

double area_of(const std::array<Vec3, 3>& corners) {
  return 0.5 * (corners[1] - corners[0]).cross(corners[2] - corners[0]).norm();
}

/// Computes the forces of one block from its own copy of positions and velocities.
void run_block(ShellTables& t, std::size_t index, std::span<const Vec3> x, std::span<const Vec3> v, double dt,
               std::vector<double>& scratch) {
  const ShellBlock& block = t.blocks[index];
  double* copy = scratch.data();
  double* forces = copy + t.greatest_copy * kCopyStride;
  const std::size_t count = block.vertices_end - block.vertices_begin;
  for (std::size_t i = 0; i < count; ++i) {
    const Index vertex = t.block_vertices[block.vertices_begin + i];
    double* at = copy + i * kCopyStride;
    for (int k = 0; k < 3; ++k) at[k] = x[vertex][k];
    for (int k = 0; k < 3; ++k) at[3 + k] = v[vertex][k];
  }
  std::fill_n(forces, count * kForceStride, 0.0);
  add_block_forces(t, index, copy, dt, forces);
  for (std::size_t i = 0; i < count; ++i) {
    const double* at = forces + i * kForceStride;
    t.block_forces[block.vertices_begin + i] = {at[0], at[1], at[2]};
  }
}

void sum_blocks(ShellTables& t, double dt) {
  t.elastic = 0;
  t.greatest = {};
  double power = 0;
  for (const ShellSums& sums : t.sums) {
    t.elastic += sums.elastic;
    t.plastic += sums.plastic;
    power += sums.viscous_power;
    t.greatest.membrane = std::max(t.greatest.membrane, sums.membrane);
    t.greatest.hinge = std::max(t.greatest.hinge, sums.hinge);
    t.greatest.hinge_damping = std::max(t.greatest.hinge_damping, sums.hinge_damping);
  }
  t.numerical += power * dt;
}

/// Sets the rest angles of edges that merging has created to their present angles.
void settle_pending(ShellTables& t, std::span<const Vec3> x) {
  ShellHinges& h = t.hinges;
  for (const Index i : t.pending) {
    const ShellBlock& block =
        *std::find_if(t.blocks.begin(), t.blocks.end(), [&](const ShellBlock& b) { return i < b.hinges_end; });
    const auto at = [&](std::size_t k) -> const Vec3& {
      return x[t.block_vertices[block.vertices_begin + static_cast<std::size_t>(h.vertices[k][i]) / kCopyStride]];
    };
    h.rest[i] = h.last[i] = h.reference[i] = hinge_angle(at(0), at(1), at(2), at(3));
  }
  t.pending.clear();
}

/// State of triangles and hinges before an edit, found by slot.
class Before {
 public:
  explicit Before(const ShellTables& old) : old_(old) {
    for (std::size_t i = 0; i < old.elements.size(); ++i) set(element_, old.elements[i].slot, static_cast<Index>(i));
    for (std::size_t i = 0; i < old.triangles.element.size(); ++i) {
      const Index e = old.triangles.element[i];
      if (e != kNone) set(triangle_, old.elements[e].slot, static_cast<Index>(i));
    }
    for (std::size_t i = 0; i < old.hinges.elements.size(); ++i) {
      const auto [a, b] = old.hinges.elements[i];
      if (a != kNone) pairs_.push_back({old.elements[a].slot, old.elements[b].slot, static_cast<Index>(i)});
    }
    std::sort(pairs_.begin(), pairs_.end());
    pending_.assign(old.hinges.rest.size(), false);
    for (const Index i : old.pending) pending_[i] = true;
  }

  const ShellElement* element(Index slot) const {
    const Index i = get(element_, slot);
    return i == kNone ? nullptr : &old_.elements[i];
  }

  /// The plastic flow of the parent in the frame of the child.
  void pass_on(Index parent, ShellTables& t, std::size_t triangle) const {
    const Index from = get(triangle_, parent);
    if (from == kNone) return;
    const ShellTriangles& old = old_.triangles;
    ShellTriangles& tri = t.triangles;
    tri.strain[triangle] = old.strain[from];
    const auto& corners = old_.elements[old.element[from]].corners;
    const auto& new_corners = t.elements[tri.element[triangle]].corners;
    std::array<double, 4> shape;
    for (std::size_t k = 0; k < 4; ++k) shape[k] = old.shape[k][from];
    if (corners != new_corners) {
      const RestFrame a(corners), b(new_corners);
      const auto c = [&](std::size_t i, std::size_t j) { return a.axes[i].dot(b.axes[j]); };
      const std::array<double, 4> turn = {c(0, 0), c(0, 1), c(1, 0), c(1, 1)},
                                  back = {turn[0], turn[2], turn[1], turn[3]};
      const std::array<double, 4> flow = product2(back, product2(product2(old.edges[from], shape), turn));
      // Two triangles in different planes have no common plane for the flow.
      if (!(std::fabs(turn[0] * turn[3] - turn[1] * turn[2]) > 0.5)) return;
      shape = product2(inverse2(b.edges), flow);
    }
    for (std::size_t k = 0; k < 4; ++k) tri.shape[k][triangle] = shape[k];
  }

  /// Hinge between these two triangles, kNone if there was none; `turned`: they were in the other order.
  Index hinge(Index a, Index b, bool& turned) const {
    turned = false;
    for (const auto& [first, second] : {std::pair(a, b), std::pair(b, a)}) {
      const auto at = std::lower_bound(pairs_.begin(), pairs_.end(), std::tuple(first, second, Index{0}));
      if (at != pairs_.end() && std::get<0>(*at) == first && std::get<1>(*at) == second) return std::get<2>(*at);
      turned = true;
    }
    return kNone;
  }

  bool pending(Index hinge) const { return pending_[hinge]; }

  void pass_on_hinge(Index from, bool turned, ShellHinges& h, std::size_t to) const {
    const ShellHinges& old = old_.hinges;
    // The angle's sign is that of the first triangle's normal.
    const double sign = turned && !old.opposed[from] ? -1 : 1;
    h.rest[to] = h.reference[to] + sign * (old.rest[from] - old.reference[from]);
    h.last[to] = h.reference[to] + sign * (old.last[from] - old.reference[from]);
    if (std::isfinite(old.virgin[from])) h.capacity[to] = h.virgin[to] * (old.capacity[from] / old.virgin[from]);
  }

 private:
  static void set(std::vector<Index>& table, Index slot, Index value) {
    if (slot >= table.size()) table.resize(slot + 1, kNone);
    table[slot] = value;
  }
  static Index get(const std::vector<Index>& table, Index slot) { return slot < table.size() ? table[slot] : kNone; }

  const ShellTables& old_;
  std::vector<Index> element_, triangle_;  ///< by slot
  std::vector<std::tuple<Index, Index, Index>> pairs_;
  std::vector<bool> pending_;
};

/// Corners of the rest shape after an edit: those of the parent where its vertex is kept or was merged into another,
/// the reference position where the vertex came with the edit.
void inherit_corners(const ShellElement& parent, Index vertices_before, ShellElement& child) {
  for (std::size_t k = 0; k < 3; ++k) {
    if (child.vertices[k] >= vertices_before) continue;
    const auto same = std::find(parent.vertices.begin(), parent.vertices.end(), child.vertices[k]);
    child.corners[k] =
        parent.corners[same == parent.vertices.end() ? k : static_cast<std::size_t>(same - parent.vertices.begin())];
  }
}

/// Whether both triangles of a hinge have the edge at the same place at rest.
bool edge_fits(const ShellTables& t, std::size_t hinge) {
  const ShellElement &a = t.elements[t.hinges.elements[hinge][0]], &b = t.elements[t.hinges.elements[hinge][1]];
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      if (a.vertices[i] != b.vertices[j]) continue;
      const double size2 = (a.corners[1] - a.corners[0]).squaredNorm() + (a.corners[2] - a.corners[0]).squaredNorm();
      if ((a.corners[i] - b.corners[j]).squaredNorm() > 1e-20 * size2) return false;
    }
  }
  return true;
}

}  // namespace

ShellForces::ShellForces(const Model& model) : tables_(std::make_unique<ShellTables>()) {
  std::vector<ShellElement> elements = read_elements(model.mesh, model.positions);
  tables_->laws = read_laws(model, elements);
  tables_->build(std::move(elements), model.mesh.vertex_count());
  // For stable_step(); forces at rest are none.
  std::vector<Vec3> zero(model.positions.size(), Vec3::Zero()), forces = zero;
  SerialExecutor serial;
  add_forces(model.positions, zero, 0, serial, forces);
}

ShellForces::~ShellForces() = default;

void ShellForces::add_masses(std::span<double> mass) const {
  for (const ShellElement& e : tables_->elements) {
    const ShellLaw& law = tables_->laws[static_cast<std::size_t>(e.object)];
    const double share = law.density * law.thickness * area_of(e.corners) / 3;
    for (const Index v : e.vertices) mass[v] += share;
  }
}

void ShellForces::add_forces(std::span<const Vec3> x, std::span<const Vec3> v, double dt, Executor& executor,
                             std::span<Vec3> force) {
  ShellTables& t = *tables_;
  if (!t.pending.empty()) settle_pending(t, x);
  const std::size_t size = t.greatest_copy * (kCopyStride + kForceStride);
  while (t.scratch.size() < executor.workers()) t.scratch.emplace_back(size);
  executor.parallel_for(t.blocks.size(), 1, [&](std::size_t begin, std::size_t end, unsigned worker) {
    for (std::size_t i = begin; i < end; ++i) run_block(t, i, x, v, dt, t.scratch[worker]);
  });
  executor.parallel_for(t.used.size(), kShellVertexGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) {
      Vec3 sum = t.block_forces[t.places[t.offsets[i]]];
      for (Index k = t.offsets[i] + 1; k < t.offsets[i + 1]; ++k) sum += t.block_forces[t.places[k]];
      force[t.used[i]] += sum;
    }
  });
  t.positions.assign(x.begin(), x.end());
  sum_blocks(t, dt);
}

double ShellForces::stable_step() const {
  // Membranes and hinges share the mass of a triangle: their frequencies add as squares. Leapfrog with the velocity of
  // half a step ago is stable while squared frequency dt^2 / 4 + damping dt / 2 <= 1.
  const ShellSums& g = tables_->greatest;
  const double stiff = g.membrane + g.hinge, damping = 2 * kShellDamping * std::sqrt(g.membrane) + g.hinge_damping;
  return stiff > 0 ? 4 / (damping + std::sqrt(damping * damping + 4 * stiff)) : kNever;
}

void ShellForces::add_vertex_stress(std::span<VertexStress> out) const {
  const ShellTables& t = *tables_;
  const ShellTriangles& tri = t.triangles;
  for (std::size_t i = 0; i < tri.element.size(); ++i) {
    if (tri.element[i] == kNone) continue;
    const ShellElement& e = t.elements[tri.element[i]];
    const ShellLaw& law = t.laws[static_cast<std::size_t>(e.object)];
    Eigen::Matrix<double, 3, 2> edges;
    edges << t.positions[e.vertices[1]] - t.positions[e.vertices[0]],
        t.positions[e.vertices[2]] - t.positions[e.vertices[0]];
    Eigen::Matrix2d shape;
    shape << tri.shape[0][i], tri.shape[1][i], tri.shape[2][i], tri.shape[3][i];
    const Eigen::Matrix<double, 3, 2> f = edges * shape;
    const Eigen::Matrix2d c = f.transpose() * f;
    const double mean = 0.5 * (c(0, 0) + c(1, 1)), half = 0.5 * (c(0, 0) - c(1, 1)),
                 radius = std::sqrt(half * half + c(0, 1) * c(0, 1));
    MembraneStep step{};
    step.squared_stretch[0] = mean + radius;
    step.squared_stretch[1] = mean - radius;
    elastic_membrane(law, step);
    const double turn = 0.5 * (step.stress[0] - step.stress[1]) / std::max(radius, 1e-300);
    const Eigen::Matrix2d s = 0.5 * (step.stress[0] + step.stress[1]) * Eigen::Matrix2d::Identity() +
                              turn * (c - mean * Eigen::Matrix2d::Identity());
    // Kirchhoff stress times the volume at rest is Cauchy stress times the volume now.
    const Eigen::Matrix3d stress = f * s * f.transpose() * tri.volume[i];
    const double dilation = (1 - 2 * law.poisson_ratio) / law.youngs_modulus * (step.kirchhoff[0] + step.kirchhoff[1]);
    const double volume = tri.volume[i] * (1 + dilation);
    for (const Index v : e.vertices) {
      out[v].stress += stress;
      out[v].plastic_strain += tri.strain[i] * volume;
      out[v].volume += volume;
    }
  }
}

double ShellForces::elastic_energy() const { return tables_->elastic; }
double ShellForces::plastic_work() const { return tables_->plastic; }
double ShellForces::numerical_work() const { return tables_->numerical; }
std::size_t ShellForces::triangle_count() const { return tables_->deformable; }
std::size_t ShellForces::hinge_count() const { return tables_->hinge_count; }

void ShellForces::update(const Mesh& mesh, std::span<const Vec3> reference, std::span<const Vec3> /*present*/,
                         const ElementHeritage& heritage) {
  const ShellTables old = *tables_;
  ShellTables& t = *tables_;
  const Before before(old);
  std::vector<Index> source(mesh.element_slots());
  for (Index slot = 0; slot < source.size(); ++slot) source[slot] = slot;
  for (std::size_t i = 0; i < heritage.added.size(); ++i) source[heritage.added[i]] = heritage.parents[i];
  std::vector<ShellElement> elements = read_elements(mesh, reference);
  // New vertices lie where the parent's did, until they move.
  t.positions.assign(reference.begin(), reference.end());
  std::copy(old.positions.begin(), old.positions.end(), t.positions.begin());
  for (ShellElement& e : elements) {
    if (static_cast<std::size_t>(e.object) >= t.laws.size())
      throw InputError("model", "bodies", e.object, "does not exist");
    const ShellElement* parent = before.element(source[e.slot]);
    if (!parent) continue;
    inherit_corners(*parent, old.mesh_vertices, e);
    for (std::size_t k = 0; k < 3; ++k) {
      if (e.vertices[k] >= old.mesh_vertices) t.positions[e.vertices[k]] = old.positions[parent->vertices[k]];
    }
  }
  t.build(std::move(elements), mesh.vertex_count());
  for (std::size_t i = 0; i < t.triangles.element.size(); ++i) {
    if (t.triangles.element[i] == kNone) continue;
    before.pass_on(source[t.elements[t.triangles.element[i]].slot], t, i);
  }
  for (std::size_t i = 0; i < t.hinges.elements.size(); ++i) {
    const auto [a, b] = t.hinges.elements[i];
    if (a == kNone) continue;
    bool turned = false;
    const Index from = before.hinge(source[t.elements[a].slot], source[t.elements[b].slot], turned);
    if (from != kNone) before.pass_on_hinge(from, turned, t.hinges, i);
    if (from == kNone ? !edge_fits(t, i) : before.pending(from)) t.pending.push_back(static_cast<Index>(i));
  }
}

void ShellForces::archive(Archive& archive) { tables_->archive(archive); }

std::unique_ptr<ElementForces> make_shell_forces(const Model& model) { return std::make_unique<ShellForces>(model); }

}  // namespace volccd::simulation
