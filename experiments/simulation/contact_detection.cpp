#include <volccd/experiments/simulation/contact_detection.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include <volccd/core/error.hpp>

namespace volccd::simulation {
namespace {

constexpr std::size_t kChunk = FeatureBlock::kCapacity;
/// Of the step: by how much a contact may be early.
constexpr double kTimeTolerance = 1e-3;
/// Of the step. What rests at the separation takes any number of them; it is taken to touch, sooner or later.
constexpr int kMostParts = 40;
/// Weights below are those of a point on the rim.
constexpr double kEnd = 1e-9;
/// Sine of an angle that counts as none.
constexpr double kSlant = 0.1;
/// Of the separation: how near to twins it is a corner of a crack.
constexpr double kCorner = 5;

/// Takes every pair that the filters leave: which of them touch is found out by each retest.
class TakeAll final : public NarrowPhase {
 public:
  int max_control_points() const override { return 3; }
  bool handles_separation() const override { return true; }
  void test(const Step& step, FeatureKind kind, std::span<const FeaturePair> pairs, std::vector<Contact>& contacts,
            NarrowCounters&) const override {
    for (const FeaturePair& pair : pairs)
      contacts.push_back(
          {kind, test_vertices(step.features(), kind, pair), 0, Vec3::Zero(), {0, 0, 0, 0}, Vec3::Zero(), false});
  }
};

Pipeline make_pipeline(const std::string& name) {
  Registry registry = Registry::standard();
  registry.add<NarrowPhase>(
      {"take-all",
       "every pair that filters leave",
       Guarantee::conservative,
       {},
       [](const OptionValues&) -> std::unique_ptr<NarrowPhase> { return std::make_unique<TakeAll>(); }});
  PipelineSpec spec = registry.pipeline(name);
  spec.narrow_phase = {"take-all", {}};
  // All that is not filtered out is kept in memory and tested again and again.
  if (spec.feature_filters.empty())
    spec.feature_filters = {{"feature-kdop", {}}, {"coplanarity", {}}, {"feature-csat", {}}};
  return Pipeline(registry, spec);
}

bool has_shells(const Mesh& mesh) {
  for (Index o = 0; o < mesh.element_slots(); ++o)
    if (mesh.alive(o) && is_shell(mesh.type(o))) return true;
  return false;
}

bool same(const ElementSpec& spec, const Mesh& mesh, Index o) {
  const std::span<const Index> vertices = mesh.vertices(o);
  return spec.type == mesh.type(o) && std::equal(vertices.begin(), vertices.end(), spec.vertices.begin());
}

bool share_vertex(const Mesh& mesh, Index a, Index b) {
  if (a == b) return true;
  for (Index v : mesh.vertices(a))
    for (Index w : mesh.vertices(b))
      if (v == w) return true;
  return false;
}

bool all_adjacent(const Mesh& mesh, std::span<const Index> a, std::span<const Index> b) {
  for (Index i : a)
    for (Index j : b)
      if (!share_vertex(mesh, i, j)) return false;
  return true;
}

bool have_common(std::span<const Index> a, std::span<const Index> b) {
  for (Index i : a)
    if (std::find(b.begin(), b.end(), i) != b.end()) return true;
  return false;
}

std::span<const Index> first_elements(const Features& features, FeatureKind kind, const std::array<Index, 4>& v) {
  return kind == FeatureKind::vf ? features.vertex_elements(v[0])
                                 : features.edge_elements(features.find_edge(v[0], v[1]));
}

std::span<const Index> second_elements(const Features& features, FeatureKind kind, const std::array<Index, 4>& v) {
  return kind == FeatureKind::vf ? features.triangle_elements(features.find_triangle(v[1], v[2], v[3]))
                                 : features.edge_elements(features.find_edge(v[2], v[3]));
}

/// Normal of the plane that both features are parallel to: of the triangle, or across both edges. Not normalised.
Vec3 plane_normal(FeatureKind kind, const std::array<Vec3, 4>& x) {
  return kind == FeatureKind::vf ? Vec3((x[2] - x[1]).cross(x[3] - x[1])) : Vec3((x[1] - x[0]).cross(x[3] - x[2]));
}

bool is_inside(const Contact& contact) {
  return std::all_of(contact.weights.begin(), contact.weights.end(), [](double w) { return w > kEnd; });
}

/// What is on the wrong side at the start is pushed back; what gets there from the wrong side is let out.
void turn_or_leave(FoundContact& found) {
  if (found.at_start)
    found.normal = -found.normal;
  else
    found.verdict = ContactVerdict::leaving;
}

}  // namespace

ContactDetection::ContactDetection(const Topology& model, std::span<const double> thickness,
                                   std::span<const Vec3> reference, Config config)
    : model_(model),
      thickness_(thickness.begin(), thickness.end()),
      reference_(reference.begin(), reference.end()),
      config_(std::move(config)),
      pipeline_(make_pipeline(config_.pipeline)),
      workspace_(pipeline_.make_workspace()),
      narrow_(Inclusion::Config{.time_tolerance = kTimeTolerance, .most_parts = kMostParts}) {
  for (const auto& [a, b] : config_.excluded) filter_.exclude(a, b);
  if (has_shells(model.mesh())) {
    thickener_.emplace(model.mesh());
    solid_ = std::make_unique<Topology>(thickener_->solid_mesh(model.mesh()));
    // Else edits would not fall on the same slots.
    if (solid_->mesh().element_slots() != model.mesh().element_slots())
      throw InputError("model", "mesh", "a mesh with shells has empty element slots");
  }
  mark_boundary();
  if (config_.features == ContactFeatures::surface) note_first_surface();
}

ContactDetection::~ContactDetection() = default;

void ContactDetection::follow(const TopologyEdit& edit, std::span<const double> thickness,
                              std::span<const Vec3> reference, std::span<const Index> origins) {
  origins_.assign(origins.begin(), origins.end());
  thickness_.assign(thickness.begin(), thickness.end());
  reference_.assign(reference.begin(), reference.end());
  candidates_.clear();
  vf_.clear();
  ee_.clear();
  placed0_.from.clear();
  placed1_.from.clear();
  if (thickener_) {
    const Mesh& mesh = model_.mesh();
    thickener_.emplace(mesh);
    TopologyEdit solids;
    solids.new_vertex_ids = solid_vertex_ids(edit.new_vertex_ids);
    solids.removed = edit.removed;
    for (const ElementSpec& added : edit.added)
      solids.added.push_back(thickener_->solid_element(mesh, mesh.find_element(added.id)));
    solid_->apply(solids);
    // Sheets may have turned over with the edit: their other prisms are put in anew, each into its own slot.
    for (Index o = 0; o < mesh.element_slots(); ++o) {
      if (!mesh.alive(o) || !is_shell(mesh.type(o))) continue;
      ElementSpec spec = thickener_->solid_element(mesh, o);
      if (!same(spec, solid_->mesh(), o)) solid_->apply({{o}, {}, {std::move(spec)}});
    }
  }
  mark_boundary();
}

Index ContactDetection::origin(Index vertex) const {
  const Index copies = thickener_ ? 3 : 1, v = vertex / copies;
  return v < origins_.size() ? copies * origins_[v] + vertex % copies : vertex;
}

std::array<Index, 3> ContactDetection::origin_of_triangle(Index f) const {
  const auto& v = collision_topology().features().triangle(f);
  std::array<Index, 3> result = {origin(v[0]), origin(v[1]), origin(v[2])};
  std::sort(result.begin(), result.end());
  return result;
}

/// Faces of more than three vertices with all triangles that they could be cut into: a vertex that splits may turn a
/// diagonal.
void ContactDetection::note_first_surface() {
  const Mesh& mesh = collision_topology().mesh();
  const Features& features = collision_topology().features();
  std::vector<std::array<Index, 3>> triangles;
  const auto take_face = [&](std::span<const Index> face) {
    triangles.clear();
    bool outside = false;
    for (std::size_t i = 0; i < face.size(); ++i)
      for (std::size_t j = i + 1; j < face.size(); ++j)
        for (std::size_t k = j + 1; k < face.size(); ++k) {
          const Index f = features.find_triangle(face[i], face[j], face[k]);
          outside |= f != kNone && boundary_triangle_[f] != 0;
          triangles.push_back({face[i], face[j], face[k]});
          std::sort(triangles.back().begin(), triangles.back().end());
        }
    if (outside) first_surface_.insert(first_surface_.end(), triangles.begin(), triangles.end());
  };
  std::vector<Index> face;
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.alive(o)) continue;
    const std::span<const std::uint8_t> stream = face_stream(mesh.type(o));  // no polytopes in a simulation
    for (std::size_t at = 0; at < stream.size(); at += 1 + stream[at]) {
      face.clear();
      for (std::size_t i = 1; i <= stream[at]; ++i) face.push_back(mesh.vertices(o)[stream[at + i]]);
      take_face(face);
    }
  }
  std::sort(first_surface_.begin(), first_surface_.end());
}

void ContactDetection::mark_boundary() {
  const Features& features = collision_topology().features();
  boundary_vertex_.assign(features.vertex_slots(), 0);
  boundary_edge_.assign(features.edge_slots(), 0);
  boundary_triangle_.assign(features.triangle_slots(), 0);
  for (Index f = 0; f < features.triangle_slots(); ++f) {
    if (features.triangle_elements(f).size() != 1) continue;
    if (!first_surface_.empty() &&
        !std::binary_search(first_surface_.begin(), first_surface_.end(), origin_of_triangle(f)))
      continue;
    boundary_triangle_[f] = 1;
    const auto& v = features.triangle(f);
    for (Index i : v) boundary_vertex_[i] = 1;
    for (std::size_t i = 0; i < 3; ++i)
      if (const Index e = features.find_edge(v[i], v[(i + 1) % 3]); e != kNone) boundary_edge_[e] = 1;
  }
}

const std::vector<Vec3>& ContactDetection::place(std::span<const Vec3> x, Placed& placed, Executor& executor) const {
  if (!std::equal(x.begin(), x.end(), placed.from.begin(), placed.from.end())) {
    thickener_->positions(x, thickness_, placed.to, executor);
    placed.from.assign(x.begin(), x.end());
  }
  return placed.to;
}

/// A substep begins where the one before it has ended, and is looked at several times with other ends.
void ContactDetection::set_motion(std::span<const Vec3> x0, std::span<const Vec3> x1, Executor& executor) {
  if (!thickener_) return motion_.set_linear(x0, x1);
  if (std::equal(x0.begin(), x0.end(), placed1_.from.begin(), placed1_.from.end())) std::swap(placed0_, placed1_);
  motion_.set_linear(place(x0, placed0_, executor), place(x1, placed1_, executor));
}

void ContactDetection::query(std::span<const Vec3> x0, std::span<const Vec3> x1, std::span<const Vec3> ahead,
                             Executor& executor) {
  set_motion(x0, ahead.empty() ? x1 : ahead, executor);
  queried_ = motion_;
  queried_end_ = ahead.empty() ? 1 : 0.5;
  find_middles();
  reach_ = std::clamp(spread(), config_.least_margin, config_.most_margin);
  pipeline_.run({collision_topology(), motion_, filter_, config_.separation + reach_}, workspace_, executor, result_);
  candidates_.clear();
  for (const Contact& contact : result_.contacts)
    if (!share_shell(contact.vertices, contact.kind)) candidates_.push_back({contact.kind, contact.vertices});
  find_slots();
}

/// How far apart displacements of vertices are: contacts will not change them by more.
double ContactDetection::spread() const {
  Eigen::AlignedBox3d box;
  for (Index v = 0; v < motion_.vertex_count(); ++v) box.extend(Vec3(motion_.point(v, 1) - motion_.point(v, 0)));
  return box.isEmpty() ? 0 : 2 * box.diagonal().norm();
}

bool ContactDetection::share_shell(const std::array<Index, 4>& v, FeatureKind kind) const {
  if (!thickener_) return false;
  const std::size_t first = kind == FeatureKind::vf ? 1 : 2;
  for (std::size_t i = 0; i < first; ++i)
    for (std::size_t j = first; j < 4; ++j)
      if (v[i] / 3 == v[j] / 3) return true;
  return false;
}

void ContactDetection::find_slots() {
  const Features& features = collision_topology().features();
  vf_.clear();
  ee_.clear();
  for (const auto& [kind, v] : candidates_) {
    if (kind == FeatureKind::vf) {
      vf_.push_back({v[0], features.find_triangle(v[1], v[2], v[3])});
    } else {
      const Index a = features.find_edge(v[0], v[1]), b = features.find_edge(v[2], v[3]);
      ee_.push_back({std::min(a, b), std::max(a, b)});
    }
  }
}

bool ContactDetection::covers(std::span<const Vec3> x0, std::span<const Vec3> x1, Executor& executor) {
  set_motion(x0, x1, executor);
  if (queried_.vertex_count() != motion_.vertex_count()) return false;
  const double reach = reach_ * reach_ / 4;
  for (Index v = 0; v < motion_.vertex_count(); ++v)
    for (int end = 0; end < 2; ++end)
      if (!((motion_.point(v, end) - queried_.position(v, end * queried_end_)).squaredNorm() <= reach)) return false;
  return true;
}

void ContactDetection::contacts(std::span<const Vec3> x0, std::span<const Vec3> x1, double separation,
                                Executor& executor, std::vector<FoundContact>& found) {
  found.clear();
  if (candidates() == 0) return;
  set_motion(x0, x1, executor);
  test(vf_, ee_, separation, executor, found);
}

void ContactDetection::keep_touching(Executor& executor, std::vector<FoundContact>& found) {
  std::vector<FeaturePair> vf, ee;
  for (const FoundContact& c : found) {
    if (c.verdict != ContactVerdict::resist) continue;
    // Features come no nearer than by the motion that is left of any of their vertices relative to any of the other's.
    const std::size_t first = c.kind == FeatureKind::vf ? 1 : 2;
    double most = 0;
    for (std::size_t i = 0; i < first; ++i)
      for (std::size_t j = first; j < 4; ++j)
        most = std::max(most, (motion_.point(c.features[i], 1) - motion_.point(c.features[i], 0) -
                               motion_.point(c.features[j], 1) + motion_.point(c.features[j], 0))
                                  .norm());
    const double apart = c.at_start ? std::abs(c.gap0) : config_.separation;
    if ((1 - c.toi + 1e-3) * most >= apart * (1 - 1e-3)) (c.kind == FeatureKind::vf ? vf : ee).push_back(slots(c));
  }
  found.clear();
  if (!vf.empty() || !ee.empty()) test(vf, ee, 0, executor, found);
  std::erase_if(found, [](const FoundContact& c) { return c.verdict != ContactVerdict::resist || c.at_start; });
}

FeaturePair ContactDetection::slots(const FoundContact& c) const {
  const Features& features = collision_topology().features();
  const auto& v = c.features;
  if (c.kind == FeatureKind::vf) return {v[0], features.find_triangle(v[1], v[2], v[3])};
  const Index a = features.find_edge(v[0], v[1]), b = features.find_edge(v[2], v[3]);
  return {std::min(a, b), std::max(a, b)};
}

void ContactDetection::test(const std::vector<FeaturePair>& vf, const std::vector<FeaturePair>& ee, double separation,
                            Executor& executor, std::vector<FoundContact>& found) {
  const Step step{collision_topology(), motion_, filter_, separation};
  const std::size_t vf_chunks = (vf.size() + kChunk - 1) / kChunk, ee_chunks = (ee.size() + kChunk - 1) / kChunk;
  if (chunks_.size() < vf_chunks + ee_chunks) chunks_.resize(vf_chunks + ee_chunks);
  while (blocks_.size() < executor.workers()) blocks_.push_back(std::make_unique<FeatureBlock>());
  executor.parallel_for(vf_chunks + ee_chunks, 1, [&](std::size_t begin, std::size_t end, unsigned worker) {
    NarrowCounters counters;
    std::vector<Contact> contacts;
    std::vector<FeaturePair> close;
    for (std::size_t c = begin; c < end; ++c) {
      const bool is_vf = c < vf_chunks;
      const std::vector<FeaturePair>& pairs = is_vf ? vf : ee;
      const std::size_t first = (is_vf ? c : c - vf_chunks) * kChunk;
      contacts.clear();
      const FeatureKind kind = is_vf ? FeatureKind::vf : FeatureKind::ee;
      filter(step, kind, std::span(pairs).subspan(first, std::min(kChunk, pairs.size() - first)), *blocks_[worker],
             close);
      narrow_.test(step, kind, close, contacts, counters);
      chunks_[c].clear();
      for (const Contact& contact : contacts) chunks_[c].push_back(describe(contact));
    }
  });
  for (std::size_t c = 0; c < vf_chunks + ee_chunks; ++c)
    found.insert(found.end(), chunks_[c].begin(), chunks_[c].end());
}

/// Most of the pairs that a query has left are further apart than the separation in a substep.
void ContactDetection::filter(const Step& step, FeatureKind kind, std::span<const FeaturePair> pairs,
                              FeatureBlock& block, std::vector<FeaturePair>& close) const {
  std::array<std::uint8_t, FeatureBlock::kCapacity> keep;
  block.gather(step, kind, pairs);
  const std::span<std::uint8_t> flags(keep.data(), block.padded_size());
  std::fill(flags.begin(), flags.end(), std::uint8_t{1});
  kdop_filter_.filter(step, block, flags);
  csat_filter_.filter(step, block, flags);
  close.clear();
  for (std::size_t i = 0; i < pairs.size(); ++i)
    if (keep[i] != 0) close.push_back(pairs[i]);
}

FoundContact ContactDetection::describe(const Contact& contact) const {
  const Topology& topology = collision_topology();
  const Features& features = topology.features();
  const std::array<Index, 4>& v = contact.vertices;
  FoundContact found;
  found.kind = contact.kind;
  found.features = v;
  found.toi = contact.toi;
  found.at_start = contact.at_start;
  found.normal = contact.normal;
  found.solid = true;
  found.verdict = ContactVerdict::resist;
  for (std::size_t i = 0; i < 4; ++i) {
    found.vertices[i] = thickener_ ? v[i] / 3 : v[i];
    found.solid &= !thickener_ || v[i] % 3 == 0;
    const bool first = i < (contact.kind == FeatureKind::vf ? 1u : 2u);
    found.weights[i] = first ? contact.weights[i] : -contact.weights[i];
  }
  const auto a = first_elements(features, contact.kind, v), b = second_elements(features, contact.kind, v);
  found.object_a = topology.mesh().object(a[0]);
  found.object_b = topology.mesh().object(b[0]);
  found.contact_class = found.object_a != found.object_b      ? ContactClass::inter
                        : all_adjacent(topology.mesh(), a, b) ? ContactClass::adjacent
                                                              : ContactClass::intra;
  judge(contact, found);
  found.gap0 = found.gap1 = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    found.gap0 += found.weights[i] * found.normal.dot(motion_.point(v[i], 0));
    found.gap1 += found.weights[i] * found.normal.dot(motion_.point(v[i], 1));
  }
  return found;
}

/// From the middle of the elements to the point, at the start.
Vec3 ContactDetection::outward(std::span<const Index> elements, const Vec3& point) const {
  const Mesh& mesh = collision_topology().mesh();
  Vec3 sum = Vec3::Zero();
  double count = 0;
  for (Index o : elements)
    for (Index v : mesh.vertices(o)) {
      sum += motion_.point(v, 0);
      ++count;
    }
  return point - sum / count;
}

/// Features that touch to the bit show no direction: it comes from where their elements lie. Zero if these do not tell
/// (around a vertex that has just been split, most pairs touch that will never press against each other).
Vec3 ContactDetection::made_up_normal(const Contact& contact) const {
  const Features& features = collision_topology().features();
  const std::array<Index, 4>& v = contact.vertices;
  const Vec3 apart = outward(second_elements(features, contact.kind, v), contact.point) -
                     outward(first_elements(features, contact.kind, v), contact.point);
  std::array<Vec3, 4> x;
  for (std::size_t i = 0; i < 4; ++i) x[i] = motion_.position(v[i], contact.toi);
  Vec3 n = plane_normal(contact.kind, x);
  if (contact.kind == FeatureKind::ee) {
    const Vec3 e = x[1] - x[0];
    if (n.norm() < 1e-6 * e.norm() * (x[3] - x[2]).norm()) {
      n = apart - apart.dot(e) / e.squaredNorm() * e;
      if (n.norm() < 0.3 * apart.norm()) return Vec3::Zero();
    }
  }
  const double length = n.norm(), across = n.dot(apart);
  if (!(std::abs(across) > 0.3 * length * apart.norm())) return Vec3::Zero();
  return (across > 0 ? n : Vec3(-n)) / length;
}

/// For features of one element: 1 if the normal points to the side on which the first lies in the shape at rest, -1 if
/// to the other, 0 if that shape does not tell.
int ContactDetection::side_in_reference(const FoundContact& found) const {
  std::array<Vec3, 4> rest, now;
  for (std::size_t i = 0; i < 4; ++i) {
    rest[i] = reference_[found.vertices[i]];
    now[i] = motion_.position(found.features[i], found.toi);
  }
  const Vec3 n0 = plane_normal(found.kind, rest), n1 = plane_normal(found.kind, now);
  const Vec3 apart = found.kind == FeatureKind::vf ? Vec3(rest[0] - rest[1]) : Vec3(rest[0] - rest[2]);
  const double at_rest = n0.dot(apart), here = n1.dot(found.normal);
  if (std::abs(at_rest) < 1e-3 * n0.norm() * apart.norm() || std::abs(here) < 0.1 * n1.norm()) return 0;
  return (at_rest > 0) == (here > 0) ? 1 : -1;
}

/// Whether the surface at an edge has its nearest point to what lies off it along `normal` on the edge: no triangle
/// there goes on towards it.
bool ContactDetection::faces(Index v0, Index v1, const Vec3& normal, double toi, bool boundary_only) const {
  const Topology& topology = collision_topology();
  const Features& features = topology.features();
  const Vec3 x0 = motion_.position(v0, toi), along = motion_.position(v1, toi) - x0;
  for (Index o : features.edge_elements(features.find_edge(v0, v1)))
    for (Index f : features.element_triangles(o)) {
      const auto& t = features.triangle(f);
      if (boundary_only && !boundary_triangle_[f]) continue;
      if (std::find(t.begin(), t.end(), v0) == t.end() || std::find(t.begin(), t.end(), v1) == t.end()) continue;
      const Index third = t[0] != v0 && t[0] != v1 ? t[0] : t[1] != v0 && t[1] != v1 ? t[1] : t[2];
      Vec3 across = motion_.position(third, toi) - x0;
      across -= across.dot(along) / along.squaredNorm() * along;
      if (normal.dot(across) > kSlant * across.norm()) return false;
    }
  return true;
}

/// The same for a vertex and the edges there.
bool ContactDetection::faces(Index vertex, const Vec3& normal, double toi) const {
  const Features& features = collision_topology().features();
  const Vec3 x = motion_.position(vertex, toi);
  for (Index o : features.vertex_elements(vertex))
    for (Index e : features.element_edges(o)) {
      const auto& edge = features.edge(e);
      if (edge[0] != vertex && edge[1] != vertex) continue;
      const Vec3 along = motion_.position(edge[edge[0] == vertex ? 1 : 0], toi) - x;
      if (normal.dot(along) > kSlant * along.norm()) return false;
    }
  return true;
}

/// For a vertex whose nearest point is on the rim of the triangle: else another triangle there is nearer.
bool ContactDetection::rim_faces(const Contact& contact) const {
  std::array<Index, 3> rim{};
  std::size_t n = 0;
  for (std::size_t i = 1; i < 4; ++i)
    if (contact.weights[i] > kEnd) rim[n++] = contact.vertices[i];
  if (n == 1) return faces(rim[0], contact.normal, contact.toi);
  return n == 3 || faces(rim[0], rim[1], contact.normal, contact.toi, boundary_only());
}

/// Whether the features meet next to vertices that were one before it split. There a crack has its corner: all features
/// at the one are near all at the other, in directions that mean nothing, until they have come apart.
bool ContactDetection::at_twins(const Contact& contact) const {
  const std::size_t first = contact.kind == FeatureKind::vf ? 1 : 2;
  const auto& w = contact.weights;
  const auto heaviest = [&](std::size_t begin, std::size_t end) {
    return static_cast<std::size_t>(
        std::max_element(w.begin() + static_cast<std::ptrdiff_t>(begin), w.begin() + static_cast<std::ptrdiff_t>(end)) -
        w.begin());
  };
  const std::size_t i = heaviest(0, first), j = heaviest(first, 4);
  const Index a = contact.vertices[i], b = contact.vertices[j];
  if (origin(a) != origin(b)) return false;
  const double near = kCorner * config_.separation;
  return (motion_.position(a, contact.toi) - contact.point).norm() <= near &&
         (motion_.position(b, contact.toi) - contact.point).norm() <= near;
}

void ContactDetection::judge(const Contact& contact, FoundContact& found) const {
  const Features& features = collision_topology().features();
  const std::array<Index, 4>& v = contact.vertices;
  const bool vf = contact.kind == FeatureKind::vf;
  const Index first = vf ? v[0] : features.find_edge(v[0], v[1]);
  const Index second = vf ? features.find_triangle(v[1], v[2], v[3]) : features.find_edge(v[2], v[3]);
  const bool boundary1 = (vf ? boundary_vertex_ : boundary_edge_)[first];
  const bool boundary2 = (vf ? boundary_triangle_ : boundary_edge_)[second];
  const auto give_up = [&] { found.verdict = ContactVerdict::ignore; };
  if (boundary_only() && !(boundary1 && boundary2)) return give_up();
  const bool adjacent = found.contact_class == ContactClass::adjacent;
  if (adjacent && !config_.adjacent) return give_up();
  // An end of an edge near another edge: a vertex near the triangles there, which are tested as well.
  if (!vf && !is_inside(contact)) return give_up();
  if (at_twins(contact)) return give_up();
  if (found.normal.isZero(0)) {
    if (!adjacent) found.normal = made_up_normal(contact);
    if (found.normal.isZero(0)) give_up();
    return;
  }
  const auto a = first_elements(features, contact.kind, v), b = second_elements(features, contact.kind, v);
  if (adjacent && have_common(a, b)) {
    if (side_in_reference(found) < 0) turn_or_leave(found);
    return;
  }
  if (vf && !rim_faces(contact)) return give_up();
  if (boundary1 && boundary2)
    vf ? judge_triangle(contact, found, b) : judge_edges(contact, found, a, b);
  else if (comes_out(found, a, b))
    found.verdict = ContactVerdict::leaving;
}

void ContactDetection::judge_triangle(const Contact& contact, FoundContact& found,
                                      std::span<const Index> elements) const {
  std::array<Vec3, 4> x;
  Vec3 at_start = Vec3::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    x[i] = motion_.position(contact.vertices[i], contact.toi);
    if (i > 0) at_start += motion_.point(contact.vertices[i], 0) / 3;
  }
  Vec3 n = plane_normal(FeatureKind::vf, x);
  if (n.dot(outward(elements, at_start)) < 0) n = -n;
  if (found.normal.dot(n) > -kSlant * n.norm()) return;
  // Past the rim of the triangle and behind its plane: there the next triangle is nearer.
  if (is_inside(contact))
    turn_or_leave(found);
  else
    found.verdict = ContactVerdict::ignore;
}

void ContactDetection::judge_edges(const Contact& contact, FoundContact& found, std::span<const Index> a,
                                   std::span<const Index> b) const {
  const std::array<Index, 4>& v = contact.vertices;
  const Vec3 m1 = outward(a, (motion_.point(v[0], 0) + motion_.point(v[1], 0)) / 2);
  const Vec3 m2 = outward(b, (motion_.point(v[2], 0) + motion_.point(v[3], 0)) / 2);
  const Vec3& n = found.normal;
  if (n.dot(m1) > kSlant * m1.norm() && n.dot(m2) < -kSlant * m2.norm()) return turn_or_leave(found);
  if (!faces(v[2], v[3], n, contact.toi, true) || !faces(v[0], v[1], -n, contact.toi, true))
    found.verdict = ContactVerdict::ignore;
}

/// Features in the interior have no outside: what has got there is let out, as far as the middles of the elements at
/// the features tell, or those of their objects, and not let in.
bool ContactDetection::comes_out(const FoundContact& found, std::span<const Index> a, std::span<const Index> b) const {
  const Vec3 elements = outward(b, Vec3::Zero()) - outward(a, Vec3::Zero());
  const double along = found.normal.dot(elements);
  if (std::abs(along) > 0.3 * elements.norm()) return along < 0;
  if (found.contact_class != ContactClass::inter) return false;
  const auto middle = [&](std::int32_t object) { return middles_[static_cast<std::size_t>(object)]; };
  return found.normal.dot(middle(found.object_a) - middle(found.object_b)) < 0;
}

void ContactDetection::find_middles() {
  const Mesh& mesh = collision_topology().mesh();
  std::vector<double> count;
  middles_.clear();
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.alive(o)) continue;
    const auto object = static_cast<std::size_t>(mesh.object(o));
    if (object >= count.size()) {
      count.resize(object + 1, 0);
      middles_.resize(object + 1, Vec3::Zero());
    }
    for (Index v : mesh.vertices(o)) middles_[object] += motion_.point(v, 0);
    count[object] += static_cast<double>(mesh.vertices(o).size());
  }
  for (std::size_t i = 0; i < count.size(); ++i)
    if (count[i] > 0) middles_[i] /= count[i];
}

void ContactDetection::archive(Archive& archive) {
  static_assert(std::is_trivially_copyable_v<Candidate>);
  archive(candidates_);
  archive(middles_);
  if (!archive.reading()) return;
  for (const Candidate& candidate : candidates_)
    for (Index v : candidate.vertices)
      if (v >= collision_topology().mesh().vertex_count()) throw InputError("checkpoint", "contacts", "damaged");
  find_slots();
}

}  // namespace volccd::simulation
