#include <volccd/oracle/cases/shapes.hpp>

#include <algorithm>
#include <numeric>

#include <volccd/core/error.hpp>
#include <volccd/core/random.hpp>

namespace volccd {

namespace {

/// Corner c of a cell in VTK hexahedron order, as lattice offsets.
constexpr int kCorner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
/// Faces of the cell, outward.
constexpr int kFace[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
/// Kuhn's division along the diagonal 0-6 is the same in every cell, so that the mesh is conforming.
constexpr int kKuhn[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
/// The first triangle of a wedge is clockwise as seen from the second one (VTK).
constexpr int kWedges[2][6] = {{0, 2, 1, 4, 6, 5}, {0, 3, 2, 4, 7, 6}};

class BlockBuilder {
 public:
  BlockBuilder(int nx, int ny, int nz) : nx_(nx), ny_(ny) {
    if (nx < 1 || ny < 1 || nz < 0) throw ConfigError("block: needs at least one cell in each direction");
    for (int z = 0; z <= nz; ++z)
      for (int y = 0; y <= ny; ++y)
        for (int x = 0; x <= nx; ++x) shape_.positions.emplace_back(x, y, z);
  }

  void add_cell(ElementType type, int x, int y, int z) {
    std::array<Index, 8> corner{};
    for (std::size_t c = 0; c < 8; ++c) corner[c] = lattice(x + kCorner[c][0], y + kCorner[c][1], z + kCorner[c][2]);
    switch (type) {
      case ElementType::hexahedron: add(type, {corner.begin(), corner.end()}); break;
      case ElementType::tetrahedron:
        for (const auto& tet : kKuhn) add(type, pick(corner, tet));
        break;
      case ElementType::wedge:
        for (const auto& wedge : kWedges) add(type, pick(corner, wedge));
        break;
      case ElementType::pyramid: add_pyramids(corner, Vec3(x + 0.5, y + 0.5, z + 0.5)); break;
      case ElementType::polytope: add_polytope(corner); break;
      default: throw ConfigError("block: no such cell type");
    }
  }

  /// The shell cell whose lower corner is lattice point (x, y, z), in the plane z.
  void add_shell(ElementType type, int x, int y, int z) {
    const Index a = lattice(x, y, z), b = lattice(x + 1, y, z), c = lattice(x + 1, y + 1, z), d = lattice(x, y + 1, z);
    if (type == ElementType::quad) {
      add(type, {a, b, c, d});
    } else {
      add(type, {a, b, c});
      add(type, {a, c, d});
    }
  }

  Shape build() { return std::move(shape_); }

 private:
  Index lattice(int x, int y, int z) const { return static_cast<Index>((z * (ny_ + 1) + y) * (nx_ + 1) + x); }

  template <std::size_t N>
  static std::vector<Index> pick(const std::array<Index, 8>& corner, const int (&local)[N]) {
    std::vector<Index> vertices;
    for (const int c : local) vertices.push_back(corner[static_cast<std::size_t>(c)]);
    return vertices;
  }

  ElementSpec& add(ElementType type, std::vector<Index> vertices) {
    ElementSpec spec;
    spec.type = type;
    spec.vertices = std::move(vertices);
    spec.id = static_cast<std::int64_t>(shape_.elements.size());
    shape_.elements.push_back(std::move(spec));
    return shape_.elements.back();
  }

  void add_pyramids(const std::array<Index, 8>& corner, const Vec3& centre) {
    const Index apex = static_cast<Index>(shape_.positions.size());
    shape_.positions.push_back(centre);
    for (const auto& face : kFace) {
      std::vector<Index> vertices = pick(corner, face);
      std::reverse(vertices.begin(), vertices.end());  // the base is counter-clockwise as seen from the apex (VTK)
      vertices.push_back(apex);
      add(ElementType::pyramid, std::move(vertices));
    }
  }

  void add_polytope(const std::array<Index, 8>& corner) {
    ElementSpec& spec = add(ElementType::polytope, {corner.begin(), corner.end()});
    for (const auto& face : kFace) {
      spec.faces.push_back(4);
      for (const Index v : pick(corner, face)) spec.faces.push_back(v);
    }
  }

  int nx_, ny_;
  Shape shape_;
};

}  // namespace

Shape& Shape::append(const Shape& other, std::int32_t object) {
  const Index first_vertex = static_cast<Index>(positions.size());
  std::int64_t next_id = 0;
  for (const ElementSpec& spec : elements) next_id = std::max(next_id, spec.id + 1);
  positions.insert(positions.end(), other.positions.begin(), other.positions.end());
  for (ElementSpec spec : other.elements) {
    spec.renumber([&](Index v) { return v + first_vertex; });
    spec.object = object;
    spec.id += next_id;
    elements.push_back(std::move(spec));
  }
  return *this;
}

Shape& Shape::translate(const Vec3& by) {
  for (Vec3& p : positions) p += by;
  return *this;
}

Mesh Shape::mesh() const {
  Mesh mesh;
  mesh.add_vertices(static_cast<Index>(positions.size()));
  for (const ElementSpec& spec : elements) mesh.add_element(spec);
  return mesh;
}

Shape block(ElementType type, int nx, int ny, int nz) {
  const bool sheet = is_shell(type);
  BlockBuilder builder(nx, ny, sheet ? 0 : nz);
  for (int z = 0; z < (sheet ? 1 : nz); ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) sheet ? builder.add_shell(type, x, y, 0) : builder.add_cell(type, x, y, z);
  return builder.build();
}

Shape mixed_block(int ny, int nz) {
  constexpr ElementType kColumns[5] = {ElementType::hexahedron, ElementType::wedge, ElementType::pyramid,
                                       ElementType::polytope, ElementType::tetrahedron};
  BlockBuilder builder(5, ny, nz);
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < 5; ++x) builder.add_cell(kColumns[x], x, y, z);
  for (int y = 0; y < ny; ++y) {
    builder.add_shell(ElementType::triangle, 0, y, nz);
    builder.add_shell(ElementType::quad, 1, y, nz);
  }
  return builder.build();
}

Shape permuted(const Shape& shape, std::uint64_t seed) {
  Random random(seed);
  std::vector<Index> to(shape.positions.size());
  std::iota(to.begin(), to.end(), Index{0});
  random.shuffle(to);
  Shape result;
  result.positions.resize(shape.positions.size());
  for (std::size_t v = 0; v < to.size(); ++v) result.positions[to[v]] = shape.positions[v];
  result.elements = shape.elements;
  for (ElementSpec& spec : result.elements) spec.renumber([&](Index v) { return to[v]; });
  random.shuffle(result.elements);
  return result;
}

std::vector<Vec3> jittered(std::span<const Vec3> positions, double amount, std::uint64_t seed) {
  Random random(seed);
  std::vector<Vec3> result(positions.begin(), positions.end());
  for (Vec3& p : result)
    for (int axis = 0; axis < 3; ++axis) p[axis] += random.uniform(-amount, amount);
  return result;
}

}  // namespace volccd
