// Signs of volumes at the threshold where they are accepted as certain, compared with 113 bits: eight different
// elements at a time, which fill all vector lanes.
#include <volccd/culling/stars/detail/cone_signs.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <volccd/core/random.hpp>
#include <volccd/mesh/features.hpp>
#include <volccd/oracle/cases/shapes.hpp>

#include "culling/quad.hpp"
#include "culling/random_vector.hpp"

namespace volccd::detail {
namespace {

constexpr Index kElements = 8;

/// The control points of each vertex.
using MovingElement = std::vector<std::vector<Vec3>>;

/// Whether the volume is positive at some times, also if vertices are displaced by w/2 or -w/2, |w| <= separation. This
/// changes it by a dot product of w and the normal of a face, or the cross product of opposite edges.
bool stays_positive(const std::array<const std::vector<Vec3>*, 4>& corners, double separation) {
  constexpr int kTimes = 16;
  for (int i = 0; i <= kTimes; ++i) {
    const Quad t = Quad(i) / kTimes, d = separation;
    const Quad3 from = bezier(*corners[0], t);
    const Quad3 a = bezier(*corners[1], t) - from, b = bezier(*corners[2], t) - from, c = bezier(*corners[3], t) - from;
    const Quad3 ab = cross(a, b), bc = cross(b, c), ca = cross(c, a);
    const Quad volume = dot(a, bc);
    if (!(volume > 0)) return false;
    if (separation == 0) continue;
    for (const Quad3& area : {ab, bc, ca, ab + bc, bc + ca, ca + ab, ab + bc + ca})
      if (!(volume * volume > d * d * dot(area, area))) return false;
  }
  return true;
}

/// Eight elements of one type that have no common vertices. Their vertices are numbered in random order, on which the
/// diagonals of faces depend.
class Elements {
 public:
  enum class Order { own, common };  ///< whether the orders of different elements differ

  Elements(ElementType type, int control_points, Random& random, Order order = Order::own)
      : size_(static_cast<std::size_t>(vertex_count(type))),
        topology_(make_mesh(type, random, order)),
        motion_(topology_.mesh().vertex_count(), control_points) {}

  const MovingElement& element(Index o) const { return elements_[o]; }
  void set(Index o, MovingElement element) {
    for (std::size_t i = 0; i < size_; ++i)
      for (std::size_t c = 0; c < element[i].size(); ++c)
        motion_.set(vertices_[o][i], static_cast<int>(c), element[i][c]);
    elements_[o] = std::move(element);
  }

  /// Bit i of element o: the cone of vertex i is proven to be positive.
  std::array<unsigned, kElements> cones(double separation) const {
    std::array<ConeSigns, kElements> signs;
    cone_signs(step(separation), 0, kElements, signs.data());
    std::array<unsigned, kElements> bits;
    for (Index o = 0; o < kElements; ++o) bits[o] = signs[o].positive;
    return bits;
  }
  unsigned all_bits() const { return (1u << size_) - 1; }

  /// Whether all tetrahedra between a vertex and the triangles of the faces without it stay positive.
  bool cone_stays_positive(Index o, std::size_t vertex, double separation) const {
    const Index v = vertices_[o][vertex];
    for (const std::array<Index, 3>& t : oriented_boundary(topology_.mesh(), o))
      if (!on_face_of(o, vertex, t) &&
          !volccd::detail::stays_positive({&path(o, v), &path(o, t[0]), &path(o, t[1]), &path(o, t[2])}, separation))
        return false;
    return true;
  }

 private:
  Mesh make_mesh(ElementType type, Random& random, Order order) {
    Mesh mesh;
    mesh.add_vertices(static_cast<Index>(kElements * size_));
    for (Index o = 0; o < kElements; ++o) {
      const auto first = static_cast<Index>(o * size_);
      vertices_[o].resize(size_);
      std::iota(vertices_[o].begin(), vertices_[o].end(), first);
      if (o == 0 || order == Order::own)
        random.shuffle(vertices_[o]);
      else
        std::ranges::transform(vertices_[0], vertices_[o].begin(), [&](Index v) { return first + v; });
      ElementSpec element;
      element.type = type;
      element.id = o;
      element.vertices = vertices_[o];
      mesh.add_element(element);
    }
    return mesh;
  }
  /// Whether the triangle is on a face that contains the vertex.
  bool on_face_of(Index o, std::size_t vertex, const std::array<Index, 3>& triangle) const {
    bool found = false;
    volccd::visit_faces(face_stream(topology_.mesh().type(o)), [&](std::span<const std::uint8_t> face) {
      const auto has = [&](Index v) {
        return std::any_of(face.begin(), face.end(), [&](std::uint8_t i) { return vertices_[o][i] == v; });
      };
      found = found || (has(vertices_[o][vertex]) && std::all_of(triangle.begin(), triangle.end(), has));
    });
    return found;
  }
  Step step(double separation) const { return {topology_, motion_, filter_, separation}; }
  const std::vector<Vec3>& path(Index o, Index v) const {
    return elements_[o][static_cast<std::size_t>(std::find(vertices_[o].begin(), vertices_[o].end(), v) -
                                                 vertices_[o].begin())];
  }

  std::size_t size_;
  std::array<std::vector<Index>, kElements> vertices_;
  Topology topology_;
  Motion motion_;
  ObjectFilter filter_;
  std::array<MovingElement, kElements> elements_;
};

/// Checks all bits of the present elements. Returns their number.
int expect_true(const Elements& elements, double separation) {
  const std::array<unsigned, kElements> bits = elements.cones(separation);
  int count = 0;
  for (Index o = 0; o < kElements; ++o)
    for (std::size_t v = 0; bits[o] >> v != 0; ++v) {
      if ((bits[o] >> v & 1) == 0) continue;
      ++count;
      EXPECT_TRUE(elements.cone_stays_positive(o, v, separation)) << "element " << o << ", vertex " << v;
      if (bits[o] == elements.all_bits() && bits[o] == 0xf) break;  // the same tetrahedron for each vertex
    }
  return count;
}

/// An element as a function of a number in [0, 1].
using Family = std::function<MovingElement(double)>;

/// Finds, for each family, where elements cease to be proven positive, beginning with 0, and checks all bits on both
/// sides. Returns the number of families that are neither proven at 1 nor refused at 0.
int expect_true_at_thresholds(Elements& elements, const std::array<Family, kElements>& families, double separation) {
  std::array<double, kElements> good{}, bad;
  bad.fill(1);
  const auto set_all = [&](const std::array<double, kElements>& at) {
    for (Index o = 0; o < kElements; ++o) elements.set(o, families[o](at[o]));
  };
  set_all(good);
  const std::array<unsigned, kElements> at_start = elements.cones(separation);
  for (int i = 0; i < 40; ++i) {
    std::array<double, kElements> middle;
    for (Index o = 0; o < kElements; ++o) middle[o] = (good[o] + bad[o]) / 2;
    set_all(middle);
    const std::array<unsigned, kElements> bits = elements.cones(separation);
    for (Index o = 0; o < kElements; ++o) (bits[o] == elements.all_bits() ? good : bad)[o] = middle[o];
  }
  set_all(bad);
  expect_true(elements, separation);
  set_all(good);
  expect_true(elements, separation);
  int found = 0;
  for (Index o = 0; o < kElements; ++o) found += at_start[o] == elements.all_bits() && good[o] < 0.999 ? 1 : 0;
  return found;
}

MovingElement mapped(MovingElement element, const std::function<Vec3(const Vec3&)>& map) {
  for (std::vector<Vec3>& path : element)
    for (Vec3& p : path) p = map(p);
  return element;
}

/// An element with a positive volume and edges of length 1 along the axes.
std::vector<Vec3> plain_shape(ElementType type) {
  switch (type) {
    case ElementType::tetrahedron: return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    case ElementType::pyramid: return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {.5, .5, 1}};
    case ElementType::wedge: return {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
    default: return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  }
}

/// The same, jittered, stretched and turned.
std::vector<Vec3> shape_of(ElementType type, Random& random) {
  std::vector<Vec3> x = plain_shape(type);
  const double jitter = type == ElementType::tetrahedron ? 0.5 : 0.1;
  for (Vec3& p : x) p += jitter * random_vector(random);
  Vec3 stretch(std::exp2(random.uniform(-4, 0)), std::exp2(random.uniform(-4, 0)), std::exp2(random.uniform(-4, 0)));
  stretch /= stretch.maxCoeff();
  const auto turn = Eigen::AngleAxisd(random.uniform(0, 6), random_vector(random).normalized());
  for (Vec3& p : x) p = turn * Vec3(p.cwiseProduct(stretch));
  return x;
}

/// Four points about the corners of a square, so flat that a displacement across it is decisive; they move across it in
/// opposite directions.
MovingElement flat_tetrahedron(int control_points, double amount, std::uint64_t seed) {
  Random random(seed);
  constexpr double kThickness = 0x1p-6;
  MovingElement element;
  const Vec3 corners[4] = {{0, 0, 0}, {1, 1, 0}, {0, 1, 1}, {1, 0, 1}};
  for (const Vec3& corner : corners) {
    const Vec3 at = corner.cwiseProduct(Vec3(1, 1, kThickness)) + 0.03 * Vec3(random.uniform(), random.uniform(), 0);
    const double way = (corner.z() > 0 ? -1 : 1) * amount * kThickness * random.uniform(0.9, 1);
    element.emplace_back();
    for (int c = 0; c < control_points; ++c)
      element.back().push_back(at + Vec3(0, 0, way * (control_points == 3 && c == 1 ? 4 : 2 * c - control_points + 1)));
  }
  return element;
}

/// A random affine motion, with the middle control points moved by themselves, and a little motion of each vertex.
MovingElement moving(const std::vector<Vec3>& at, int control_points, double amount, std::uint64_t seed) {
  Random random(seed);
  Eigen::Matrix3d change;
  const double affine = random.uniform() < 0.5 ? amount : 0.1 * amount;
  for (int k = 0; k < 3; ++k) change.col(k) = affine * random_vector(random);
  const Vec3 base = 0.3 * random_vector(random);
  MovingElement element;
  for (const Vec3& p : at) {
    element.push_back({p});
    const Vec3 bend = (random.uniform() < 0.2 ? 0.5 : 0.05) * amount * random_vector(random);
    if (control_points == 3) element.back().push_back(Vec3(p + 0.5 * (change * (p - base)) + bend));
    element.back().push_back(Vec3(p + change * (p - base) + 0.05 * amount * random_vector(random)));
  }
  return element;
}

/// The motion from one linear map of the element to another one.
MovingElement between(const std::vector<Vec3>& at, int control_points, const Eigen::Matrix3d& from,
                      const Eigen::Matrix3d& to) {
  MovingElement element;
  for (const Vec3& p : at) {
    element.push_back({Vec3(from * p)});
    if (control_points == 3) element.back().push_back(Vec3(0.5 * (from + to) * p));
    element.back().push_back(Vec3(to * p));
  }
  return element;
}

/// Edges become longer in a motion that changes no volume.
MovingElement sheared(const std::vector<Vec3>& at, int control_points, Random& random) {
  const Vec3 normal = random_vector(random).normalized(),
             way = std::exp2(random.uniform(-2, 6)) * normal.unitOrthogonal();
  const Eigen::Matrix3d still = Eigen::Matrix3d::Identity();
  return between(at, control_points, still, still + way * normal.transpose());
}

/// One edge becomes long and another one short while their plane turns. Areas are greatest in between.
MovingElement exchanged(const std::vector<Vec3>& at, int control_points, Random& random) {
  const double k = std::exp2(random.uniform(0, 2)), thickness = std::exp2(random.uniform(-8, -2));
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(random.uniform(0, 2), Vec3::Unit(random.below(2))).matrix();
  return between(at, control_points, Vec3(1 / k, k, thickness).asDiagonal(),
                 turn * Vec3(k, 1 / k, thickness).asDiagonal());
}

/// One of the motions above.
MovingElement any_motion(ElementType type, int control_points, Random& random) {
  const std::vector<Vec3> at = shape_of(type, random);
  const double amount = random.uniform(0, 2);
  switch (random.below(6)) {
    case 0: return moving(at, control_points, 0, 0);
    case 1:
      if (type == ElementType::tetrahedron) return flat_tetrahedron(control_points, 0.1 * amount, random.next());
      [[fallthrough]];
    case 2: return sheared(at, control_points, random);
    case 3: return exchanged(plain_shape(type), control_points, random);
    default: return moving(at, control_points, amount, random.next());
  }
}

struct Case {
  ElementType type;
  int rounds;
};
const std::array<Case, 4> kCases{
    {{ElementType::tetrahedron, 60}, {ElementType::pyramid, 8}, {ElementType::wedge, 8}, {ElementType::hexahedron, 6}}};

/// Calls run(case, control points, random, round).
template <class Run>
void for_all_cases(std::uint64_t seed, Run&& run) {
  for (const Case& c : kCases)
    for (const int control_points : {2, 3}) {
      Random random(seed);
      SCOPED_TRACE(to_string(c.type) + std::string(", control points: ") + std::to_string(control_points));
      for (int round = 0; round < c.rounds && !testing::Test::HasFailure(); ++round)
        run(c, control_points, random, round);
    }
}

// Elements that shrink until a separation may turn them over.
TEST(ConeSigns, AreCertainUpToTheGreatestSeparation) {
  int found = 0;
  for_all_cases(1, [&](const Case& c, int control_points, Random& random, int) {
    Elements elements(c.type, control_points, random);
    std::array<Family, kElements> families;
    for (Family& family : families) {
      const MovingElement whole = any_motion(c.type, control_points, random);
      family = [whole](double x) { return mapped(whole, [x](const Vec3& p) { return Vec3((1 - x) * p); }); };
    }
    found += expect_true_at_thresholds(elements, families, 0.001);
  });
  EXPECT_GT(found, 500);
}

// Elements that move more and more until they turn over.
TEST(ConeSigns, AreCertainUpToTheGreatestMotion) {
  int found = 0;
  for_all_cases(2, [&](const Case& c, int control_points, Random& random, int round) {
    Elements elements(c.type, control_points, random);
    std::array<Family, kElements> families;
    for (Family& family : families) {
      const std::uint64_t seed = random.next();
      const std::vector<Vec3> at = shape_of(c.type, random);
      if (round % 2 == 1 && c.type == ElementType::tetrahedron)
        family = [=](double x) { return flat_tetrahedron(control_points, x, seed); };
      else
        family = [=](double x) { return moving(at, control_points, 3 * x, seed); };
    }
    found += expect_true_at_thresholds(elements, families, 0);
  });
  EXPECT_GT(found, 500);
}

/// Points about a plane, so that the volume at the end is about as large as its rounding errors. At the start the
/// element is like that, too, or much smaller than at the end, with a positive volume. In some tetrahedra, one edge has
/// about the direction of an axis, and the other two have about the same direction across it.
MovingElement rounded_sliver(ElementType type, int control_points, bool small_at_start, Random& random) {
  const std::vector<Vec3> at = shape_of(type, random);
  const Vec3 u = random_vector(random), w = random_vector(random);
  const std::uint64_t axis = type == ElementType::tetrahedron ? random.below(6) : 3;
  std::vector<Vec3> flat;
  for (const Vec3& p : at) {
    Vec3 q = p.x() * u + p.y() * w;
    for (int k = 0; k < 3; ++k) q[k] += 0x1p-53 * random.uniform(-2, 2);
    flat.push_back(q);
  }
  if (axis < 3) {
    flat = {Vec3::Zero(), flat[1], flat[1] * random.uniform(0.5, 2), flat[1]};
    for (const std::size_t i : {1, 2}) {
      for (int k = 0; k < 3; ++k) flat[i][k] += 0x1p-53 * random.uniform(-2, 2);
      flat[i][static_cast<Eigen::Index>(axis)] *= 0x1p-30;
    }
    flat[3] = 0x1p-30 * flat[3];
    flat[3][static_cast<Eigen::Index>(axis)] = 1;
    if (random.below(2) == 0) std::rotate(flat.begin() + 1, flat.begin() + 3, flat.end());
  }
  const Vec3 place = random_vector(random);  // so that differences are rounded
  for (Vec3& p : flat) p += place;
  MovingElement element;
  for (std::size_t i = 0; i < at.size(); ++i) {
    element.push_back({small_at_start ? Vec3(0x1p-30 * at[i]) : flat[i]});
    for (int c = 1; c < control_points; ++c) element.back().push_back(flat[i]);
  }
  return element;
}

TEST(ConeSigns, AndVolumesOfSliversAreNotDecidedByRounding) {
  int doubtful = 0;
  for_all_cases(3, [&](const Case& c, int control_points, Random& random, int) {
    Elements elements(c.type, control_points, random);
    for (int i = 0; i < (c.type == ElementType::tetrahedron ? 60 : 10); ++i) {
      for (Index o = 0; o < kElements; ++o) elements.set(o, rounded_sliver(c.type, control_points, i % 2 == 1, random));
      expect_true(elements, 0);
      for (Index o = 0; o < kElements; ++o) doubtful += elements.cone_stays_positive(o, 0, 0) ? 0 : 1;
    }
  });
  EXPECT_GT(doubtful, 1000);
}

/// A pyramid over a unit square of which one edge, `edge`, was shortened to `length`.
MovingElement pyramid_with_short_edge(int control_points, std::size_t edge, double length, Random& random) {
  std::vector<Vec3> at = plain_shape(ElementType::pyramid);
  for (std::size_t i = 0; i < 5; ++i) at[i] += 0.03 * random_vector(random);
  const std::size_t next = (edge + 1) % 4;
  at[next] = at[edge] + length * (at[next] - at[edge]).normalized();
  return moving(at, control_points, 0, 0);
}

// A displacement of the short edge turns over the tetrahedra at it, whose other edges are long. A bound without the
// product of the latter would be too small. All elements have the same diagonal, because the less sharp of two bounds
// decides only if it does so for all vector lanes.
TEST(ConeSigns, OfElementsWithAShortEdgeAreCertain) {
  constexpr double kSeparation = 0.001;
  constexpr unsigned kApex = 1u << 4;
  int certain = 0, doubtful = 0;
  for (const int control_points : {2, 3})
    for (std::uint64_t seed = 1; seed <= 8; ++seed)
      for (std::size_t edge = 0; edge < 4; ++edge)
        for (const double length : {0.5, 0.8, 1.2, 3.0}) {
          Random random(seed);
          Elements elements(ElementType::pyramid, control_points, random, Elements::Order::common);
          for (Index o = 0; o < kElements; ++o)
            elements.set(o, pyramid_with_short_edge(control_points, edge, length * kSeparation, random));
          expect_true(elements, kSeparation);
          const std::array<unsigned, kElements> bits = elements.cones(kSeparation);
          for (Index o = 0; o < kElements; ++o) {
            certain += (bits[o] & kApex) != 0 ? 1 : 0;
            doubtful += elements.cone_stays_positive(o, 4, kSeparation) ? 0 : 1;
          }
        }
  EXPECT_GT(certain, 300);
  EXPECT_GT(doubtful, 300);
}

/// Three corners of the base of a pyramid, and its apex, as given; the fourth corner is far below them. Of the
/// tetrahedra of its cones, the one of the four points may be flat, while the others have large volumes. Pre: the
/// points follow each other, seen from above, around a convex quad.
std::vector<Vec3> pyramid_below(const std::array<Vec3, 4>& points, double depth, Random& random) {
  const Vec3 middle = 0.25 * (points[0] + points[1] + points[2] + points[3]);
  const Vec3 up = (points[2] - points[0]).cross(points[3] - points[1]).normalized();
  return {points[0], points[1], points[2], middle - depth * up + 0.1 * depth * random_vector(random), points[3]};
}

// All four faces of the flat tetrahedron are as large as a triangle in the box of the element can be, and its opposite
// edges approach each other.
TEST(ConeSigns, OfPyramidsWithLargeFlatFacesAreCertain) {
  constexpr double kThickness = 0x1p-8;
  int certain = 0, doubtful = 0;
  for (const int control_points : {2, 3})
    for (int round = 0; round <= 40; ++round) {
      const double amount = 0.02 * round;  // of the thickness; they meet at 0.5
      Random random(static_cast<std::uint64_t>(round));
      Elements elements(ElementType::pyramid, control_points, random);
      for (Index o = 0; o < kElements; ++o) {
        const double h = kThickness * random.uniform(0.1, 1);
        const std::vector<Vec3> at =
            pyramid_below({Vec3(0, 0, 0), Vec3(1, 0, h), Vec3(1, 1, 0), Vec3(0, 1, h)}, 8 * h, random);
        MovingElement element;
        for (std::size_t i = 0; i < 5; ++i) {
          const double way = i == 3 ? 0 : (at[i].z() > 0 ? -amount : amount) * h;
          element.emplace_back();
          for (int c = 0; c < control_points; ++c)
            element.back().push_back(at[i] + Vec3(0, 0, way * (2.0 * c / (control_points - 1) - 1)));
        }
        elements.set(o, element);
        doubtful += elements.cone_stays_positive(o, 0, 0) ? 0 : 1;
      }
      expect_true(elements, 0);
      for (const unsigned bits : elements.cones(0)) certain += bits == elements.all_bits() ? 1 : 0;
    }
  EXPECT_GT(certain, 300);
  EXPECT_GT(doubtful, 200);
}

// Resting pyramids of which one tetrahedron has a volume about as large as its rounding errors.
TEST(ConeSigns, OfPyramidsWithASliverAreNotDecidedByRounding) {
  int certain = 0, doubtful = 0;
  for (const int control_points : {2, 3})
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      Random random(seed);
      Elements elements(ElementType::pyramid, control_points, random);
      for (Index o = 0; o < kElements; ++o) {
        const Vec3 u = random_vector(random), w = random_vector(random), place = random_vector(random);
        std::array<Vec3, 4> flat{place, place + u, place + u + w, place + w};
        const double size = o == 0 ? 0x1p-20 : 0x1p-53;  // the first one has a volume whose sign is certain
        for (Vec3& p : flat) p += size * random_vector(random);
        elements.set(o, moving(pyramid_below(flat, 1, random), control_points, 0, 0));
        doubtful += elements.cone_stays_positive(o, 0, 0) ? 0 : 1;
      }
      expect_true(elements, 0);
      for (const unsigned bits : elements.cones(0)) certain += bits == elements.all_bits() ? 1 : 0;
    }
  EXPECT_GT(certain, 20);
  EXPECT_GT(doubtful, 200);
}

}  // namespace
}  // namespace volccd::detail
