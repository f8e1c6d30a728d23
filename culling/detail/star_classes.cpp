#include <volccd/culling/detail/star_classes.hpp>

#include <algorithm>
#include <array>
#include <cmath>

#include <volccd/culling/detail/certified_sign.hpp>
#include <volccd/culling/detail/volume_signs.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kElementGrain = 1024, kVertexGrain = 256;
/// The other vertices of a tetrahedron as seen from v, at t = 0, in an order of positive determinant for a positive
/// volume.
struct Corner {
  Vec3 a, b, c;

  Corner(const Step& step, Index o, Index v, bool mirrored) {
    const std::span<const Index> t = step.topology.adjacency().vertices(o);
    constexpr std::array<std::array<std::uint8_t, 3>, 4> kOthers{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}};
    const auto i = static_cast<std::size_t>(std::find(t.begin(), t.end(), v) - t.begin());
    const Vec3 at = step.motion.point(v, 0);
    a = step.motion.point(t[kOthers[i][0]], 0) - at;
    b = step.motion.point(t[kOthers[i][mirrored ? 2 : 1]], 0) - at;
    c = step.motion.point(t[kOthers[i][mirrored ? 1 : 2]], 0) - at;
  }
  bool contains(const Vec3& d) const {
    return certainly_positive(d, b, c) && certainly_positive(a, d, c) && certainly_positive(a, b, d);
  }
  bool excludes(const Vec3& d) const {
    return certainly_negative(d, b, c) || certainly_negative(a, d, c) || certainly_negative(a, b, d);
  }
};

/// Whether the tetrahedra around v, all of nonzero volume at t = 0, go once around it: a direction in the first of them
/// is in no other.
bool goes_once_around(const Step& step, Index v, const std::vector<std::int8_t>& signs) {
  const std::span<const Index> star = step.features().vertex_elements(v);
  const Corner first(step, star[0], v, signs[star[0]] < 0);
  const Vec3 direction = first.a + first.b + first.c;
  if (!first.contains(direction)) return false;
  return std::all_of(star.begin() + 1, star.end(), [&](Index o) { return Corner(step, o, v, signs[o] < 0).excludes(direction); });
}

/// Whether the ring of boundary faces around v is a graph over one plane at all times: the normals of all faces have a
/// positive product with one direction, all through the step, and the ring goes once around it.
class RingTest {
 public:
  static constexpr std::size_t kMost = 64;

  RingTest(const Step& step, Index v, std::span<const Index> ring)
      : size_(ring.size()), control_points_(step.motion.control_points()) {
    if (size_ > kMost) return;
    for (int c = 0; c < control_points_; ++c) {
      const Vec3 at = step.motion.point(v, c);
      for (std::size_t i = 0; i < size_; ++i) sides_[i][static_cast<std::size_t>(c)] = step.motion.point(ring[i], c) - at;
    }
  }

  bool is_graph() const {
    if (size_ > kMost) return false;
    const Vec3 up = direction();
    for (std::size_t i = 0; i < size_; ++i)
      if (!stays_positive(up, sides_[i], sides_[next(i)])) return false;
    return winds_once(up);
  }

 private:
  using Side = std::array<Vec3, 3>;  ///< by control point

  std::size_t next(std::size_t i) const { return i + 1 == size_ ? 0 : i + 1; }

  /// Any direction is valid; this one, the sum of the unit normals at both ends, is likely to do.
  Vec3 direction() const {
    Vec3 sum = Vec3::Zero();
    for (const std::size_t c : {std::size_t{0}, static_cast<std::size_t>(control_points_ - 1)})
      for (std::size_t i = 0; i < size_; ++i) {
        const Vec3 normal = sides_[i][c].cross(sides_[next(i)][c]);
        const double square = normal.squaredNorm();
        if (square > 0) sum += normal / std::sqrt(square);
      }
    return sum;
  }

  /// det(up, a(t), b(t)) > 0 for all t: its Bernstein coefficients, each times a binomial, are.
  bool stays_positive(const Vec3& up, const Side& a, const Side& b) const {
    const int n = control_points_ - 1;
    for (int k = 0; k <= 2 * n; ++k) {
      double sum = 0, bound = 0;
      for (int i = std::max(0, k - n); i <= std::min(n, k); ++i) {
        const Vec3 &x = a[static_cast<std::size_t>(i)], &y = b[static_cast<std::size_t>(k - i)];
        const double weight = (n == 2 && i == 1 ? 2 : 1) * (n == 2 && k - i == 1 ? 2 : 1);
        const CertifiedDeterminant part(up, x, y);
        sum += weight * part.value;
        bound += weight * part.bound;
      }
      if (!(sum > 2 * bound)) return false;  // twice: for the sum's own rounding
    }
    return true;
  }

  /// At t = 0. The sectors of the faces in the plane across `up` are narrower than half a turn: a direction in the first of
  /// them is in no other.
  bool winds_once(const Vec3& up) const {
    const Vec3 d = sides_[0][0] + sides_[next(0)][0];
    if (!certainly_positive(up, sides_[0][0], d) || !certainly_positive(up, d, sides_[next(0)][0])) return false;
    for (std::size_t i = 1; i < size_; ++i)
      if (!certainly_negative(up, sides_[i][0], d) && !certainly_negative(up, d, sides_[next(i)][0])) return false;
    return true;
  }

  std::size_t size_;
  int control_points_;
  std::array<Side, kMost> sides_;
};

}  // namespace

void StarClasses::find_degenerate(const Step& step, const StarTable& stars, Executor& executor) {
  const Mesh& mesh = step.mesh();
  const Index slots = mesh.element_slots();
  signs_.resize(slots);
  degenerate_.resize(slots);
  sound_.resize(slots);
  executor.parallel_for(slots, kElementGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    volume_signs(step, static_cast<Index>(begin), static_cast<Index>(end), signs_.data());
  });
  executor.parallel_for(slots, kElementGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t o = begin; o < end; ++o) {
      bool unsound = signs_[o] == 0;
      if (!unsound && mesh.type(static_cast<Index>(o)) == ElementType::tetrahedron)
        for (const StarTable::Neighbour& across : stars.neighbours(static_cast<Index>(o)))
          unsound = unsound || (across.element != kNone && signs_[o] * signs_[across.element] == (across.opposite ? -1 : 1));
      degenerate_[o] = unsound ? 1 : 0;
      sound_[o] = !unsound && mesh.type(static_cast<Index>(o)) == ElementType::tetrahedron ? 1 : 0;
    }
  });
}

void StarClasses::forget_degrees_around(const Step& step, Index element) {
  for (const Index v : step.mesh().vertices(element)) degrees_[v] = Degree::unknown;
}

/// The degree of a star can change only while a volume in it is 0, or with the topology. If this step does not begin where
/// the last one ended, the degree is that of before where the volumes keep their signs on the straight way in between.
void StarClasses::keep_degrees(const Step& step, const StarTable& stars, TopologyDelta::Extent changed,
                               Executor& executor) {
  const Index vertices = step.motion.vertex_count();
  const bool anew = changed == TopologyDelta::Extent::everything || last_.empty();
  if (anew) degrees_.assign(vertices, Degree::unknown);
  degrees_.resize(vertices, Degree::unknown);
  if (changed == TopologyDelta::Extent::edits)
    for (const Index v : stars.changed_vertices()) degrees_[v] = Degree::unknown;
  start_.resize(vertices);
  bool moved = false;
  for (Index v = 0; v < vertices; ++v) {
    start_[v] = step.motion.point(v, 0);
    if (v >= last_.size()) last_.push_back(start_[v]);
    moved = moved || last_[v] != start_[v];
  }
  if (moved && !anew) {
    gap_.set_linear(last_, start_);
    const Step way{step.topology, gap_, step.filter};
    gap_signs_.resize(signs_.size());
    executor.parallel_for(signs_.size(), kElementGrain, [&](std::size_t begin, std::size_t end, unsigned) {
      volume_signs(way, static_cast<Index>(begin), static_cast<Index>(end), gap_signs_.data());
    });
    for (Index o = 0; o < signs_.size(); ++o)
      if (gap_signs_[o] != signs_[o]) forget_degrees_around(step, o);
  }
  for (Index v = 0; v < vertices; ++v) last_[v] = step.motion.point(v, step.motion.control_points() - 1);
}

void StarClasses::classify(const Step& step, const StarTable& stars, Index v) {
  if (stars.kind(v) == StarKind::unused || suspect_[v] != 0) return;
  const bool volumes = step.mesh().type(step.features().vertex_elements(v)[0]) == ElementType::tetrahedron;
  if (volumes && degrees_[v] != Degree::one)
    degrees_[v] = goes_once_around(step, v, signs_) ? Degree::one : Degree::other;
  const bool around = !volumes || degrees_[v] == Degree::one;
  wound_[v] = !around && stars.kind(v) == StarKind::interior ? 1 : 0;
  const bool clear = around && (stars.kind(v) == StarKind::interior || RingTest(step, v, stars.ring(v)).is_graph());
  suspect_[v] = clear ? 0 : 1;
}

void StarClasses::update(const Step& step, const StarTable& stars, TopologyDelta::Extent changed, Executor& executor) {
  find_degenerate(step, stars, executor);
  keep_degrees(step, stars, changed, executor);
  const Index vertices = step.motion.vertex_count();
  suspect_.resize(vertices);
  wound_.assign(vertices, 0);
  for (Index v = 0; v < vertices; ++v) suspect_[v] = stars.kind(v) == StarKind::irregular ? 1 : 0;
  degenerate_count_ = 0;
  for (Index o = 0; o < degenerate_.size(); ++o) {
    if (degenerate_[o] == 0) continue;
    ++degenerate_count_;
    forget_degrees_around(step, o);
    for (const Index v : step.mesh().vertices(o)) suspect_[v] = 1;
  }
  executor.parallel_for(vertices, kVertexGrain, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t v = begin; v < end; ++v) classify(step, stars, static_cast<Index>(v));
  });
  suspects_.clear();
  for (Index v = 0; v < vertices; ++v)
    if (suspect_[v] != 0) suspects_.push_back(v);
  suspect_places_.assign(signs_.size(), 0);
  for (const Index v : suspects_)
    for (const Index o : step.features().vertex_elements(v)) {
      const std::span<const Index> corners = step.topology.adjacency().vertices(o);
      for (std::size_t i = 0; i < 4; ++i)
        suspect_places_[o] |= static_cast<std::uint8_t>((corners[i] == v ? 1 : 0) << i);
    }
}

std::size_t StarClasses::bytes() const {
  return signs_.capacity() + degenerate_.capacity() + sound_.capacity() + suspect_.capacity() + suspect_places_.capacity() + wound_.capacity() + degrees_.capacity() +
         (last_.capacity() + start_.capacity()) * sizeof(Vec3) + gap_.bytes() + gap_signs_.capacity() + suspects_.capacity() * sizeof(Index);
}

}  // namespace volccd::detail
