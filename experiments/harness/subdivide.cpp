#include <volccd/experiments/harness/subdivide.hpp>

#include <algorithm>
#include <array>
#include <unordered_map>
#include <vector>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

/// An intermediate mesh: control points of each vertex, and elements.
struct Draft {
  int control_points;
  std::vector<std::vector<Vec3>> at;  ///< [control point][vertex]
  std::vector<ElementSpec> elements;

  Index vertex_count() const { return static_cast<Index>(at[0].size()); }
};

struct CornersHash {
  std::size_t operator()(const std::array<Index, 4>& key) const {
    std::uint64_t hash = 0;
    for (const Index v : key) hash = (hash ^ v) * 0x9e3779b97f4a7c15u, hash ^= hash >> 29;
    return static_cast<std::size_t>(hash);
  }
};

/// Divides all elements once.
class Divider {
 public:
  Divider(Draft& draft, Division division) : draft_(draft), through_(division == Division::everywhere) {}

  void run() {
    std::vector<ElementSpec> old;
    old.swap(draft_.elements);
    for (const ElementSpec& element : old) divide(element);
  }

 private:
  /// The vertex at the centroid of these corners; a single corner is its own centroid. Two elements share at most four
  /// of them.
  Index middle(std::vector<Index> corners) {
    if (corners.size() == 1) return corners[0];
    std::sort(corners.begin(), corners.end());
    if (corners.size() > 4) return add(corners);
    std::array<Index, 4> key;
    key.fill(kNone);
    std::copy(corners.begin(), corners.end(), key.begin());
    const auto [place, is_new] = middles_.try_emplace(key, 0);
    if (is_new) place->second = add(corners);
    return place->second;
  }

  Index add(const std::vector<Index>& corners) {
    const Index v = draft_.vertex_count();
    for (std::vector<Vec3>& points : draft_.at) {
      Vec3 sum = Vec3::Zero();
      for (const Index corner : corners) sum += points[corner];
      points.push_back(sum / static_cast<double>(corners.size()));
    }
    return v;
  }

  void put(const ElementSpec& parent, std::vector<Index> vertices) {
    ElementSpec child;
    child.type = parent.type;
    child.vertices = std::move(vertices);
    child.object = parent.object;
    child.id = static_cast<std::int64_t>(draft_.elements.size());
    draft_.elements.push_back(std::move(child));
  }

  void divide(const ElementSpec& element) {
    switch (element.type) {
      case ElementType::quad: return divide_boxes(element, 2);
      case ElementType::hexahedron: return divide_boxes(element, 3);
      case ElementType::triangle: return divide_prisms(element, 1);
      case ElementType::wedge: return divide_prisms(element, 2);
      case ElementType::tetrahedron:
        if (through_) return divide_tetrahedron(element);
        [[fallthrough]];
      default: throw ConfigError(std::string("elements of type ") + to_string(element.type) + " cannot be divided");
    }
  }

  /// Divides quads and hexahedra by a grid of three points along each axis. In VTK's order, the vertices of a layer go
  /// around it.
  void divide_boxes(const ElementSpec& element, int axes) {
    constexpr int kRound[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const int layers = axes == 3 ? 2 : 1;
    Index centre = kNone;  // the centroid of all eight corners, which no other element has
    const auto point = [&](int i, int j, int k) {
      if (centre != kNone && axes == 3 && i == 1 && j == 1 && k == 1) return centre;
      std::vector<Index> corners;
      for (int c = 0; c < 4 * layers; ++c) {
        const int at[3] = {2 * kRound[c % 4][0], 2 * kRound[c % 4][1], 2 * (c / 4)};
        const int wanted[3] = {i, j, k};
        bool between = true;
        for (int axis = 0; axis < axes; ++axis) between &= wanted[axis] == 1 || wanted[axis] == at[axis];
        if (between) corners.push_back(element.vertices[static_cast<std::size_t>(c)]);
      }
      const Index v = middle(corners);
      if (corners.size() == 8) centre = v;
      return v;
    };
    for (int k = 0; k < (through_ ? layers : 1); ++k)
      for (const auto& low : kRound) {
        std::vector<Index> vertices;
        for (int c = 0; c < 4 * layers; ++c)
          vertices.push_back(
              point(low[0] + kRound[c % 4][0], low[1] + kRound[c % 4][1], through_ ? k + c / 4 : 2 * (c / 4)));
        put(element, std::move(vertices));
      }
  }

  /// Divides triangles, and wedges as two layers of triangles.
  void divide_prisms(const ElementSpec& element, int layers) {
    constexpr int kParts[4][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}, {3, 4, 5}};       // of the points below
    constexpr int kPoints[6][2] = {{0, 0}, {1, 1}, {2, 2}, {0, 1}, {1, 2}, {2, 0}};  // corners between which they lie
    const auto point = [&](int p, int height) {
      std::vector<Index> corners;
      for (int layer = 0; layer < layers; ++layer) {
        if (layers == 2 && height != 1 && height != 2 * layer) continue;
        corners.push_back(element.vertices[static_cast<std::size_t>(3 * layer + kPoints[p][0])]);
        if (kPoints[p][1] != kPoints[p][0])
          corners.push_back(element.vertices[static_cast<std::size_t>(3 * layer + kPoints[p][1])]);
      }
      return middle(corners);
    };
    for (int layer = 0; layer < (through_ ? layers : 1); ++layer)
      for (const auto& part : kParts) {
        std::vector<Index> vertices;
        for (int end = 0; end < layers; ++end)
          for (const int p : part) vertices.push_back(point(p, through_ ? layer + end : 2 * end));
        put(element, std::move(vertices));
      }
  }

  /// Divides a tetrahedron into four at its corners, and the octahedron between them into four around a diagonal (Bey
  /// 1995).
  void divide_tetrahedron(const ElementSpec& element) {
    const std::vector<Index>& v = element.vertices;
    const Index a = middle({v[0], v[1]}), b = middle({v[0], v[2]}), c = middle({v[0], v[3]});
    const Index d = middle({v[1], v[2]}), e = middle({v[1], v[3]}), f = middle({v[2], v[3]});
    put(element, {v[0], a, b, c});
    put(element, {a, v[1], d, e});
    put(element, {b, d, v[2], f});
    put(element, {c, e, f, v[3]});
    put(element, {a, b, c, e});
    put(element, {a, d, b, e});
    put(element, {b, f, c, e});
    put(element, {b, d, f, e});
  }

  Draft& draft_;
  const bool through_;
  std::unordered_map<std::array<Index, 4>, Index, CornersHash> middles_;
};

/// The elements of a mesh with only the vertices that they use.
Draft draft_of(const Mesh& mesh, const Motion& motion) {
  Draft draft{motion.control_points(), {}, {}};
  draft.at.resize(static_cast<std::size_t>(motion.control_points()));
  std::vector<Index> place(mesh.vertex_count(), kNone);
  for (Index o = 0; o < mesh.element_slots(); ++o) {
    if (!mesh.is_live(o)) continue;
    ElementSpec element;
    element.type = mesh.type(o);
    element.object = mesh.object(o);
    for (const Index v : mesh.vertices(o)) {
      if (place[v] == kNone) {
        place[v] = draft.vertex_count();
        for (int c = 0; c < motion.control_points(); ++c)
          draft.at[static_cast<std::size_t>(c)].push_back(motion.point(v, c));
      }
      element.vertices.push_back(place[v]);
    }
    element.id = static_cast<std::int64_t>(draft.elements.size());
    draft.elements.push_back(std::move(element));
  }
  return draft;
}

}  // namespace

RefinedStep refine(const Topology& topology, const Motion& motion, int times, Division division) {
  Draft draft = draft_of(topology.mesh(), motion);
  for (int i = 0; i < times; ++i) Divider(draft, division).run();
  RefinedStep result{{}, Motion(draft.vertex_count(), draft.control_points)};
  result.mesh.add_vertices(draft.vertex_count());
  for (const ElementSpec& element : draft.elements) result.mesh.add_element(element);
  for (Index v = 0; v < draft.vertex_count(); ++v)
    for (int c = 0; c < draft.control_points; ++c) result.motion.set(v, c, draft.at[static_cast<std::size_t>(c)][v]);
  return result;
}

}  // namespace volccd
