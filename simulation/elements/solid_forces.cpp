#include <volccd/simulation/elements/solid_forces.hpp>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <unordered_map>
#include <variant>

#include <Eigen/LU>

#include <volccd/core/error.hpp>
#include <volccd/simulation/elements/detail/solid_element.hpp>
#include <volccd/simulation/elements/material.hpp>

namespace volccd::simulation {

namespace {

using detail::SolidMaterial;
using detail::SolidShape;
using detail::SolidState;

/// All elements of one type, one row for each. Rows of removed elements are reused.
template <int N>
struct Table {
  static constexpr ElementType kType = N == 8 ? ElementType::hexahedron : ElementType::tetrahedron;
  static constexpr std::size_t kGrain = N == 8 ? 128 : 256;

  std::vector<SolidShape<N>> shapes;
  std::vector<SolidState<N>> states;
  std::vector<Index> empty;

  void archive(Archive& a) {
    a(shapes);
    a(states);
    a(empty);
  }
};

/// Position of the state of an element slot.
struct Place {
  std::uint8_t corners = 0;  ///< 4 or 8; 0: none
  Index row = 0;
};

/// The element's vertices, one for each corner. A wedge is a hexahedron whose second and third corner are the same, as
/// are the two over them: with half the mass of its parent, each vertex keeps its mass.
template <int N>
std::array<Index, N> corners_of(std::span<const Index> v) {
  if constexpr (N == 8)
    if (v.size() == 6) return {v[0], v[1], v[1], v[2], v[3], v[4], v[4], v[5]};
  std::array<Index, N> corners;
  std::copy(v.begin(), v.end(), corners.begin());
  return corners;
}

template <int N>
struct Element {
  SolidShape<N> shape;
  SolidState<N> state;
};

/// State from before the edit that a new element inherits.
struct Parent {
  std::variant<std::monostate, Element<4>, Element<8>> element;
  int children = 1;
};

struct Positions {
  std::span<const Vec3> reference, present;
};

[[noreturn]] void throw_type(const Mesh& mesh, Index slot) {
  throw InputError("model", "mesh", slot,
                   std::string("solids are tetrahedra or hexahedra, but the element in this slot is a ") +
                       to_string(mesh.type(slot)));
}

class SolidForces final : public ElementForces {
 public:
  explicit SolidForces(const Model& model);

  void add_masses(std::span<double> mass) const override;
  void add_forces(std::span<const Vec3> x, std::span<const Vec3> v, double dt, Executor& executor,
                  std::span<Vec3> force) override;
  double stable_step() const override { return step_; }
  void add_vertex_stress(std::span<VertexStress> out) const override;
  double elastic_energy() const override {
    return sum([](const auto& s) { return s.energy; });
  }
  double plastic_work() const override {
    return past_plastic_ + sum([](const auto& s) { return s.plastic_work; });
  }
  double numerical_work() const override {
    return past_numerical_ + sum([](const auto& s) { return s.numerical_work; });
  }
  void update(const Mesh& mesh, std::span<const Vec3> reference, std::span<const Vec3> present,
              const ElementHeritage& heritage) override;
  void archive(Archive& archive) override;

 private:
  template <typename Function>
  double sum(Function of_state) const {
    double total = 0;
    for (const auto& s : tetrahedra_.states) total += of_state(s);
    for (const auto& s : hexahedra_.states) total += of_state(s);
    return total;
  }
  template <int N>
  bool active(const SolidShape<N>& shape) const {
    return detail::is_active<N>(shape, materials_);
  }
  template <int N>
  Table<N>& table() {
    if constexpr (N == 4) return tetrahedra_;
    if constexpr (N == 8) return hexahedra_;
  }

  template <int N>
  void add_masses(const Table<N>& table, std::span<double> mass) const;
  template <int N>
  void compute(Table<N>& table, Vec3* out, std::span<const Vec3> x, std::span<const Vec3> v, double dt,
               Executor& executor);
  template <int N>
  void add_vertex_stress(const Table<N>& table, std::span<VertexStress> out) const;

  template <int N>
  void add(const Mesh& mesh, Index slot, const Positions& positions, const Parent& parent);
  void add(const Mesh& mesh, Index slot, const Positions& positions, const Parent& parent);
  template <int N>
  void remove(Index row);
  std::vector<Parent> parents_of(const ElementHeritage& heritage) const;
  template <int N>
  void index_places();
  void index_corners();

  std::vector<SolidMaterial> materials_;
  Table<4> tetrahedra_;
  Table<8> hexahedra_;
  std::vector<Place> places_;                     ///< by element slot
  double past_plastic_ = 0, past_numerical_ = 0;  ///< works of removed elements
  double step_ = std::numeric_limits<double>::infinity();

  Index vertices_ = 0;
  std::vector<Vec3> corner_forces_;   ///< those of tetrahedra first
  std::vector<Index> corners_begin_;  ///< by vertex, with one more entry: index into corners_
  std::vector<Index> corners_;        ///< indices into corner_forces_, ascending at each vertex
  std::vector<double> steps_;         ///< stable step, by worker
  std::vector<Index> broken_;         ///< by worker: smallest slot of an element whose deformation is not finite
};

SolidForces::SolidForces(const Model& model) : vertices_(model.mesh.vertex_count()) {
  const Mesh& mesh = model.mesh;
  if (model.positions.size() != vertices_) throw InputError("model", "positions", "one a vertex is needed");
  for (const Body& body : model.bodies) {
    check_material(body.material, body.name);
    materials_.emplace_back(body);
  }
  places_.resize(mesh.element_slots());
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o) || is_shell(mesh.type(o))) continue;
    if (mesh.type(o) == ElementType::wedge) throw_type(mesh, o);
    add(mesh, o, {model.positions, model.positions}, Parent{});
    const Place place = places_[o];
    const double volume =
        place.corners == 4 ? tetrahedra_.shapes[place.row].volume : hexahedra_.shapes[place.row].volume;
    if (!(volume > 0)) throw InputError("model", "positions", o, "the element in this slot has no volume at rest");
  }
  index_corners();
}

template <int N>
void SolidForces::add_masses(const Table<N>& table, std::span<double> mass) const {
  for (const SolidShape<N>& shape : table.shapes) {
    if (shape.slot == kNone) continue;
    const double share = shape.volume * materials_[shape.body].material.density * shape.packing / N;
    for (const Index v : shape.vertices) mass[v] += share;
  }
}

void SolidForces::add_masses(std::span<double> mass) const {
  add_masses(tetrahedra_, mass);
  add_masses(hexahedra_, mass);
}

template <int N>
void SolidForces::compute(Table<N>& table, Vec3* out, std::span<const Vec3> x, std::span<const Vec3> v, double dt,
                          Executor& executor) {
  const detail::SolidRun<N> run{table.shapes, table.states, materials_, x, v, dt, out};
  executor.parallel_for(table.shapes.size(), Table<N>::kGrain,
                        [&](std::size_t begin, std::size_t end, unsigned worker) {
                          const detail::SolidBound bound = detail::solid_forces(run, begin, end);
                          steps_[worker] = std::min(steps_[worker], bound.step);
                          broken_[worker] = std::min(broken_[worker], bound.broken);
                        });
}

void SolidForces::add_forces(std::span<const Vec3> x, std::span<const Vec3> v, double dt, Executor& executor,
                             std::span<Vec3> force) {
  assert(x.size() >= vertices_ && v.size() >= vertices_ && force.size() >= vertices_ && dt >= 0);
  steps_.assign(executor.workers(), std::numeric_limits<double>::infinity());
  broken_.assign(executor.workers(), kNone);
  compute(tetrahedra_, corner_forces_.data(), x, v, dt, executor);
  compute(hexahedra_, corner_forces_.data() + 4 * tetrahedra_.shapes.size(), x, v, dt, executor);
  if (const Index slot = *std::min_element(broken_.begin(), broken_.end()); slot != kNone) {
    throw Error("the deformation of the solid element in slot " + std::to_string(slot) + " is not finite");
  }
  step_ = *std::min_element(steps_.begin(), steps_.end());
  executor.parallel_for(vertices_, 1024, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t vertex = begin; vertex < end; ++vertex) {
      Vec3 total = force[vertex];
      for (Index c = corners_begin_[vertex]; c < corners_begin_[vertex + 1]; ++c) total += corner_forces_[corners_[c]];
      force[vertex] = total;
    }
  });
}

template <int N>
void SolidForces::add_vertex_stress(const Table<N>& table, std::span<VertexStress> out) const {
  for (std::size_t row = 0; row < table.shapes.size(); ++row) {
    const SolidShape<N>& shape = table.shapes[row];
    if (!active(shape)) continue;
    const SolidState<N>& state = table.states[row];
    const Eigen::Matrix3d stress = detail::stress_times_volume(shape, materials_[shape.body], state) / N;
    // A flat element still has stress, and needs a weight for it.
    const double volume = shape.volume * std::max(0.05, state.deformation.determinant()) / N;
    for (const Index v : shape.vertices) {
      out[v].stress += stress;
      out[v].plastic_strain += state.plastic_strain * volume;
      out[v].volume += volume;
    }
  }
}

void SolidForces::add_vertex_stress(std::span<VertexStress> out) const {
  add_vertex_stress(tetrahedra_, out);
  add_vertex_stress(hexahedra_, out);
}

/// History: what does not depend on an element's type.
template <int From, int To>
void inherit_history(const SolidState<From>& from, SolidState<To>& to) {
  to.deformation = from.deformation;
  to.viscous_pressure = from.viscous_pressure;
  to.plastic_metric = from.plastic_metric;
  to.plastic_strain = from.plastic_strain;
}

/// The state of a piece of `parent`.
template <int From, int To>
void inherit(const Element<From>& parent, Element<To>& piece) {
  inherit_history(parent.state, piece.state);
  if (parent.shape.volume > 0) piece.state.energy = parent.state.energy * (piece.shape.volume / parent.shape.volume);
}

/// The shape at rest of a piece of a hexahedron is the one that the parent's deformation maps to the piece's present
/// shape, so that it has the parent's stress. (Hourglass modes are not inherited.) Returns false if there is no such
/// shape.
bool pull_back(const Element<8>& parent, const std::array<Index, 8>& corners, std::span<const Vec3> present,
               SolidShape<8>& shape) {
  const Eigen::Matrix3d back = parent.state.deformation.inverse();
  std::array<Vec3, 8> x;
  for (std::size_t i = 0; i < 8; ++i) x[i] = back * (present[corners[i]] - present[corners[0]]);
  return back.allFinite() && detail::set_shape<8>(x, shape, corners[1] == corners[2]);
}

template <int N>
void set_reference_shape(const std::array<Index, N>& corners, std::span<const Vec3> reference, SolidShape<N>& shape) {
  std::array<Vec3, N> x;
  for (int i = 0; i < N; ++i) x[i] = reference[corners[i]];
  detail::set_shape<N>(x, shape, N == 8 && corners[1] == corners[2]);
}

/// A piece of `parent`.
template <int N>
Element<N> piece_of(const Parent& parent, const std::array<Index, N>& corners, const Positions& positions) {
  Element<N> piece;
  const auto* tetrahedron = std::get_if<Element<4>>(&parent.element);
  const auto* hexahedron = std::get_if<Element<8>>(&parent.element);
  if constexpr (N == 8) {
    if (!hexahedron || !pull_back(*hexahedron, corners, positions.present, piece.shape))
      set_reference_shape<N>(corners, positions.reference, piece.shape);
    if (hexahedron && piece.shape.volume > 0)
      piece.shape.packing =
          hexahedron->shape.packing * hexahedron->shape.volume / (parent.children * piece.shape.volume);
  } else {
    set_reference_shape<N>(corners, positions.reference, piece.shape);
  }
  piece.state.modes = piece.shape.modes;
  if (tetrahedron) inherit(*tetrahedron, piece);
  if (hexahedron) inherit(*hexahedron, piece);
  return piece;
}

template <int N>
void SolidForces::add(const Mesh& mesh, Index slot, const Positions& positions, const Parent& parent) {
  const std::array<Index, N> corners = corners_of<N>(mesh.vertices(slot));
  const Element<N>* same_type = std::get_if<Element<N>>(&parent.element);
  Element<N> element = same_type && parent.children == 1 ? *same_type : piece_of<N>(parent, corners, positions);
  element.state.plastic_work = element.state.numerical_work = 0;  // counted for the parent already
  element.shape.vertices = corners;
  element.shape.slot = slot;
  element.shape.body = static_cast<std::uint32_t>(mesh.object(slot));

  Table<N>& to = table<N>();
  if (to.empty.empty()) {
    to.empty.push_back(static_cast<Index>(to.shapes.size()));
    to.shapes.emplace_back();
    to.states.emplace_back();
  }
  const Index row = to.empty.back();
  to.empty.pop_back();
  to.shapes[row] = element.shape;
  to.states[row] = element.state;
  places_[slot] = {N, row};
  if (active(element.shape)) {
    step_ = std::min(step_, detail::stable_step<N>(element.shape, element.state, materials_));
  }
}

void SolidForces::add(const Mesh& mesh, Index slot, const Positions& positions, const Parent& parent) {
  const std::int32_t object = mesh.object(slot);
  if (object < 0 || static_cast<std::size_t>(object) >= materials_.size()) {
    throw InputError("model", "bodies", slot,
                     "the element in this slot is of object " + std::to_string(object) + ", which has no body");
  }
  switch (mesh.type(slot)) {
    case ElementType::tetrahedron: return add<4>(mesh, slot, positions, parent);
    case ElementType::hexahedron:
    case ElementType::wedge: return add<8>(mesh, slot, positions, parent);
    default: throw_type(mesh, slot);
  }
}

template <int N>
void SolidForces::remove(Index row) {
  Table<N>& from = table<N>();
  past_plastic_ += from.states[row].plastic_work;
  past_numerical_ += from.states[row].numerical_work;
  from.shapes[row] = SolidShape<N>();
  from.states[row] = SolidState<N>();
  from.empty.push_back(row);
}

std::vector<Parent> SolidForces::parents_of(const ElementHeritage& heritage) const {
  std::unordered_map<Index, int> children;
  for (const Index parent : heritage.parents) ++children[parent];
  std::vector<Parent> parents(heritage.added.size());
  for (std::size_t k = 0; k < parents.size(); ++k) {
    const Index slot = heritage.parents[k];
    if (slot >= places_.size()) continue;
    const auto [corners, row] = places_[slot];
    if (corners == 4) parents[k].element = Element<4>{tetrahedra_.shapes[row], tetrahedra_.states[row]};
    if (corners == 8) parents[k].element = Element<8>{hexahedra_.shapes[row], hexahedra_.states[row]};
    parents[k].children = children[slot];
  }
  return parents;
}

void SolidForces::update(const Mesh& mesh, std::span<const Vec3> reference, std::span<const Vec3> present,
                         const ElementHeritage& heritage) {
  assert(heritage.parents.size() == heritage.added.size() && reference.size() >= mesh.vertex_count() &&
         present.size() >= mesh.vertex_count());
  const std::vector<Parent> parents = parents_of(heritage);
  for (const Index slot : heritage.removed) {
    const auto [corners, row] = places_[slot];
    if (corners == 4) remove<4>(row);
    if (corners == 8) remove<8>(row);
    places_[slot] = {};
  }
  places_.resize(mesh.element_slots());
  for (std::size_t k = 0; k < heritage.added.size(); ++k) {
    const Index slot = heritage.added[k];
    if (!is_shell(mesh.type(slot))) add(mesh, slot, {reference, present}, parents[k]);
  }
  vertices_ = mesh.vertex_count();
  index_corners();
}

/// Lists the corners at each vertex.
void SolidForces::index_corners() {
  const auto each = [&](auto visit) {
    Index corner = 0;
    for (const auto& shape : tetrahedra_.shapes) {
      for (const Index v : shape.vertices) visit(v, corner++, active(shape));
    }
    for (const auto& shape : hexahedra_.shapes) {
      for (const Index v : shape.vertices) visit(v, corner++, active(shape));
    }
  };
  corners_begin_.assign(vertices_ + 2, 0);
  each([&](Index v, Index, bool counts) {
    if (counts) ++corners_begin_[v + 2];
  });
  for (std::size_t v = 2; v < corners_begin_.size(); ++v) corners_begin_[v] += corners_begin_[v - 1];
  corners_.resize(corners_begin_.back());
  each([&](Index v, Index corner, bool counts) {
    if (counts) corners_[corners_begin_[v + 1]++] = corner;
  });
  corner_forces_.resize(4 * tetrahedra_.shapes.size() + 8 * hexahedra_.shapes.size(), Vec3::Zero());
}

template <int N>
void SolidForces::index_places() {
  const Table<N>& rows = table<N>();
  for (Index row = 0; row < rows.shapes.size(); ++row) {
    const Index slot = rows.shapes[row].slot;
    if (slot == kNone) continue;
    if (slot >= places_.size()) places_.resize(slot + 1);
    places_[slot] = {N, row};
  }
}

void SolidForces::archive(Archive& a) {
  tetrahedra_.archive(a);
  hexahedra_.archive(a);
  a(past_plastic_);
  a(past_numerical_);
  a(step_);
  if (!a.reading()) return;
  std::fill(places_.begin(), places_.end(), Place{});
  index_places<4>();
  index_places<8>();
  index_corners();
}

}  // namespace

std::unique_ptr<ElementForces> make_solid_forces(const Model& model) { return std::make_unique<SolidForces>(model); }

}  // namespace volccd::simulation
