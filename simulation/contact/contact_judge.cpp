#include <volccd/simulation/contact/contact_judge.hpp>

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace volccd::simulation {
namespace {

/// A point with a weight below this is on the border of a feature.
constexpr double kEnd = 1e-9;
/// Sine of an angle below which directions count as perpendicular.
constexpr double kSlant = 0.1;
/// In separations: contacts within this distance of both copies of a split vertex are at a crack corner.
constexpr double kCorner = 5;

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

std::span<const Index> first_elements(const Features& features, const Contact& contact) {
  const Index slot = contact.features.a;
  return contact.kind == FeatureKind::vf ? features.vertex_elements(slot) : features.edge_elements(slot);
}

std::span<const Index> second_elements(const Features& features, const Contact& contact) {
  const Index slot = contact.features.b;
  return contact.kind == FeatureKind::vf ? features.triangle_elements(slot) : features.edge_elements(slot);
}

/// Normal of the triangle, or cross product of the edges. Not normalised.
Vec3 plane_normal(FeatureKind kind, const std::array<Vec3, 4>& x) {
  return kind == FeatureKind::vf ? Vec3((x[2] - x[1]).cross(x[3] - x[1])) : Vec3((x[1] - x[0]).cross(x[3] - x[2]));
}

bool is_inside(const Contact& contact) {
  return std::all_of(contact.weights.begin(), contact.weights.end(), [](double w) { return w > kEnd; });
}

/// A feature on the wrong side at the start is pushed back; one that comes from the wrong side during the step is not
/// resisted.
void turn_or_leave(FoundContact& found) {
  if (found.at_start)
    found.normal = -found.normal;
  else
    found.verdict = ContactVerdict::leaving;
}

}  // namespace

FoundContact ContactJudge::describe(const Contact& contact) const {
  const Topology& topology = s_.topology;
  const Features& features = topology.features();
  const std::array<Index, 4>& v = contact.vertices;
  FoundContact found;
  found.kind = contact.kind;
  found.features = v;
  found.slots = contact.features;
  found.toi = contact.toi;
  found.at_start = contact.at_start;
  found.normal = contact.normal;
  found.solid = true;
  found.verdict = ContactVerdict::resist;
  for (std::size_t i = 0; i < 4; ++i) {
    found.vertices[i] = v[i] / s_.copies;
    found.solid &= v[i] % s_.copies == 0;
    const bool first = i < (contact.kind == FeatureKind::vf ? 1u : 2u);
    found.weights[i] = first ? contact.weights[i] : -contact.weights[i];
  }
  const auto a = first_elements(features, contact), b = second_elements(features, contact);
  found.object_a = topology.mesh().object(a[0]);
  found.object_b = topology.mesh().object(b[0]);
  found.contact_class = found.object_a != found.object_b      ? ContactClass::inter
                        : all_adjacent(topology.mesh(), a, b) ? ContactClass::adjacent
                                                              : ContactClass::intra;
  judge(contact, found);
  found.gap0 = found.gap1 = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    found.gap0 += found.weights[i] * found.normal.dot(s_.motion.point(v[i], 0));
    found.gap1 += found.weights[i] * found.normal.dot(s_.motion.point(v[i], 1));
  }
  return found;
}

/// Vector from the centroid of the elements to the point, at the start.
Vec3 ContactJudge::outward(std::span<const Index> elements, const Vec3& point) const {
  const Mesh& mesh = s_.topology.mesh();
  Vec3 sum = Vec3::Zero();
  double count = 0;
  for (Index o : elements)
    for (Index v : mesh.vertices(o)) {
      sum += s_.motion.point(v, 0);
      ++count;
    }
  return point - sum / count;
}

/// Features that touch exactly have no direction between them, so that it is taken from the positions of their
/// elements. Zero if these do not determine it (around a vertex that has just been split, most pairs that touch will
/// never press against each other).
Vec3 ContactJudge::made_up_normal(const Contact& contact) const {
  const Features& features = s_.topology.features();
  const std::array<Index, 4>& v = contact.vertices;
  const Vec3 apart = outward(second_elements(features, contact), contact.point) -
                     outward(first_elements(features, contact), contact.point);
  std::array<Vec3, 4> x;
  for (std::size_t i = 0; i < 4; ++i) x[i] = s_.motion.position(v[i], contact.toi);
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

/// For features of one element: 1 if the normal points to the side on which the first feature lies in the shape at
/// rest, -1 if to the other side, 0 if that shape does not determine the side.
int ContactJudge::side_in_reference(const FoundContact& found) const {
  std::array<Vec3, 4> rest, now;
  for (std::size_t i = 0; i < 4; ++i) {
    rest[i] = s_.reference[found.vertices[i]];
    now[i] = s_.motion.position(found.features[i], found.toi);
  }
  const Vec3 n0 = plane_normal(found.kind, rest), n1 = plane_normal(found.kind, now);
  const Vec3 apart = found.kind == FeatureKind::vf ? Vec3(rest[0] - rest[1]) : Vec3(rest[0] - rest[2]);
  const double at_rest = n0.dot(apart), here = n1.dot(found.normal);
  if (std::abs(at_rest) < 1e-3 * n0.norm() * apart.norm() || std::abs(here) < 0.1 * n1.norm()) return 0;
  return (at_rest > 0) == (here > 0) ? 1 : -1;
}

/// Whether, for a point off the edge in direction `normal`, the nearest point of the surface around the edge is on the
/// edge: no triangle there extends towards the point.
bool ContactJudge::faces(Index v0, Index v1, const Vec3& normal, double toi, bool boundary_only) const {
  const Topology& topology = s_.topology;
  const Features& features = topology.features();
  const Vec3 x0 = s_.motion.position(v0, toi), along = s_.motion.position(v1, toi) - x0;
  for (Index o : features.edge_elements(features.find_edge(v0, v1)))
    for (Index f : features.element_triangles(o)) {
      const auto& t = features.triangle(f);
      if (boundary_only && !s_.surface.has_triangle(f)) continue;
      if (std::find(t.begin(), t.end(), v0) == t.end() || std::find(t.begin(), t.end(), v1) == t.end()) continue;
      const Index third = t[0] != v0 && t[0] != v1 ? t[0] : t[1] != v0 && t[1] != v1 ? t[1] : t[2];
      Vec3 across = s_.motion.position(third, toi) - x0;
      across -= across.dot(along) / along.squaredNorm() * along;
      if (normal.dot(across) > kSlant * across.norm()) return false;
    }
  return true;
}

/// The same for a vertex and the edges at it.
bool ContactJudge::faces(Index vertex, const Vec3& normal, double toi) const {
  const Features& features = s_.topology.features();
  const Vec3 x = s_.motion.position(vertex, toi);
  for (Index o : features.vertex_elements(vertex))
    for (Index e : features.element_edges(o)) {
      const auto& edge = features.edge(e);
      if (edge[0] != vertex && edge[1] != vertex) continue;
      const Vec3 along = s_.motion.position(edge[edge[0] == vertex ? 1 : 0], toi) - x;
      if (normal.dot(along) > kSlant * along.norm()) return false;
    }
  return true;
}

/// The same for the nearest point of a VF contact if it is on the triangle's border. If false, another triangle is
/// nearer.
bool ContactJudge::rim_faces(const Contact& contact) const {
  std::array<Index, 3> rim{};
  std::size_t n = 0;
  for (std::size_t i = 1; i < 4; ++i)
    if (contact.weights[i] > kEnd) rim[n++] = contact.vertices[i];
  if (n == 1) return faces(rim[0], contact.normal, contact.toi);
  return n == 3 || faces(rim[0], rim[1], contact.normal, contact.toi, s_.surface.alone());
}

/// Whether the features meet near two copies of a split vertex. At such a crack corner all features at one copy are
/// near all features at the other, in arbitrary directions, until the copies have moved apart.
bool ContactJudge::at_twins(const Contact& contact) const {
  const std::size_t first = contact.kind == FeatureKind::vf ? 1 : 2;
  const auto& w = contact.weights;
  const auto heaviest = [&](std::size_t begin, std::size_t end) {
    return static_cast<std::size_t>(
        std::max_element(w.begin() + static_cast<std::ptrdiff_t>(begin), w.begin() + static_cast<std::ptrdiff_t>(end)) -
        w.begin());
  };
  const std::size_t i = heaviest(0, first), j = heaviest(first, 4);
  const Index a = contact.vertices[i], b = contact.vertices[j];
  if (s_.surface.origin(a) != s_.surface.origin(b)) return false;
  const double near = kCorner * s_.separation;
  return (s_.motion.position(a, contact.toi) - contact.point).norm() <= near &&
         (s_.motion.position(b, contact.toi) - contact.point).norm() <= near;
}

void ContactJudge::judge(const Contact& contact, FoundContact& found) const {
  const Features& features = s_.topology.features();
  const bool vf = contact.kind == FeatureKind::vf;
  const auto [first, second] = contact.features;
  const bool boundary1 = vf ? s_.surface.has_vertex(first) : s_.surface.has_edge(first);
  const bool boundary2 = vf ? s_.surface.has_triangle(second) : s_.surface.has_edge(second);
  const auto give_up = [&] { found.verdict = ContactVerdict::ignore; };
  if (s_.surface.alone() && !(boundary1 && boundary2)) return give_up();
  const bool adjacent = found.contact_class == ContactClass::adjacent;
  if (adjacent && !s_.adjacent) return give_up();
  // At an end of an edge, the vertex is also near the triangles at the other edge, which are tested as well.
  if (!vf && !is_inside(contact)) return give_up();
  if (at_twins(contact)) return give_up();
  if (found.normal.isZero(0)) {
    if (!adjacent) found.normal = made_up_normal(contact);
    if (found.normal.isZero(0)) give_up();
    return;
  }
  const auto a = first_elements(features, contact), b = second_elements(features, contact);
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

void ContactJudge::judge_triangle(const Contact& contact, FoundContact& found, std::span<const Index> elements) const {
  std::array<Vec3, 4> x;
  Vec3 at_start = Vec3::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    x[i] = s_.motion.position(contact.vertices[i], contact.toi);
    if (i > 0) at_start += s_.motion.point(contact.vertices[i], 0) / 3;
  }
  Vec3 n = plane_normal(FeatureKind::vf, x);
  if (n.dot(outward(elements, at_start)) < 0) n = -n;
  if (found.normal.dot(n) > -kSlant * n.norm()) return;
  // Beyond the border of the triangle and behind its plane, the next triangle is nearer.
  if (is_inside(contact))
    turn_or_leave(found);
  else
    found.verdict = ContactVerdict::ignore;
}

void ContactJudge::judge_edges(const Contact& contact, FoundContact& found, std::span<const Index> a,
                               std::span<const Index> b) const {
  const std::array<Index, 4>& v = contact.vertices;
  const Vec3 m1 = outward(a, (s_.motion.point(v[0], 0) + s_.motion.point(v[1], 0)) / 2);
  const Vec3 m2 = outward(b, (s_.motion.point(v[2], 0) + s_.motion.point(v[3], 0)) / 2);
  const Vec3& n = found.normal;
  if (n.dot(m1) > kSlant * m1.norm() && n.dot(m2) < -kSlant * m2.norm()) return turn_or_leave(found);
  if (!faces(v[2], v[3], n, contact.toi, true) || !faces(v[0], v[1], -n, contact.toi, true))
    found.verdict = ContactVerdict::ignore;
}

/// Interior features have no outward side. Whether a feature moves out of a body is decided from the centroids of the
/// elements at the features, or of their objects; such a motion is not resisted.
bool ContactJudge::comes_out(const FoundContact& found, std::span<const Index> a, std::span<const Index> b) const {
  const Vec3 elements = outward(b, Vec3::Zero()) - outward(a, Vec3::Zero());
  const double along = found.normal.dot(elements);
  if (std::abs(along) > 0.3 * elements.norm()) return along < 0;
  if (found.contact_class != ContactClass::inter) return false;
  const auto middle = [&](std::int32_t object) { return s_.middles[static_cast<std::size_t>(object)]; };
  return found.normal.dot(middle(found.object_a) - middle(found.object_b)) < 0;
}

}  // namespace volccd::simulation
