#include <volccd/oracle/cases/hostile_parts.hpp>

#include <algorithm>
#include <numeric>

#include <Eigen/Dense>

namespace volccd::cases {
namespace {

constexpr int kCorner[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
/// Faces of a cell, outward.
constexpr int kFace[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
constexpr int kSix[6][4] = {{0, 1, 2, 6}, {0, 2, 3, 6}, {0, 3, 7, 6}, {0, 7, 4, 6}, {0, 4, 5, 6}, {0, 5, 1, 6}};
constexpr int kFive[5][4] = {{0, 1, 3, 4}, {2, 3, 1, 6}, {5, 4, 6, 1}, {7, 6, 4, 3}, {1, 3, 4, 6}};
constexpr int kWedges[2][6] = {{0, 2, 1, 4, 6, 5}, {0, 3, 2, 4, 7, 6}};

using Cell = std::array<Index, 8>;

int corner_at(int x, int y, int z) {
  for (int c = 0; c < 8; ++c)
    if (kCorner[c][0] == x && kCorner[c][1] == y && kCorner[c][2] == z) return c;
  return 0;
}

/// Corner c of the cube after a rotation; the rotations from 24 on are composed with a reflection.
std::array<int, 8> rotated_corners(int rotation) {
  constexpr int kCyclic[3][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}};
  // Half turns, and the reflection at a diagonal plane together with one axis, which is a quarter turn.
  const auto& axes = kCyclic[rotation % 3];
  const int half_turn = rotation / 3 % 4;
  const bool quarter = rotation / 12 % 2 != 0, mirror = rotation >= 24;
  std::array<int, 8> result{};
  for (std::size_t c = 0; c < 8; ++c) {
    int p[3];
    for (int k = 0; k < 3; ++k) p[k] = kCorner[c][axes[k]];
    if (half_turn & 1) p[0] = 1 - p[0], p[1] = 1 - p[1];
    if (half_turn & 2) p[1] = 1 - p[1], p[2] = 1 - p[2];
    if (quarter) std::swap(p[0], p[1]), p[2] = 1 - p[2];
    if (mirror) p[0] = 1 - p[0];
    result[c] = corner_at(p[0], p[1], p[2]);
  }
  return result;
}

template <std::size_t N>
std::vector<Index> pick(const Cell& corners, const int (&local)[N]) {
  std::vector<Index> vertices;
  for (const int c : local) vertices.push_back(corners[static_cast<std::size_t>(c)]);
  return vertices;
}

ElementSpec polytope(const Cell& corners) {
  ElementSpec spec{.type = ElementType::polytope, .vertices = {corners.begin(), corners.end()}};
  for (const auto& face : kFace) {
    spec.faces.push_back(4);
    for (const Index v : pick(corners, face)) spec.faces.push_back(v);
  }
  return spec;
}

ElementSpec pyramid(const Cell& corners, const int (&face)[4], Index apex) {
  std::vector<Index> vertices = pick(corners, face);
  std::reverse(vertices.begin(), vertices.end());  // the base is counter-clockwise as seen from the apex (VTK)
  vertices.push_back(apex);
  return {.type = ElementType::pyramid, .vertices = std::move(vertices)};
}

void for_each_pose(HostileMesh& mesh, const auto& visit) {
  visit(mesh.shape.positions);
  for (auto& pose : mesh.poses) visit(pose);
}

std::int64_t next_id(const std::vector<ElementSpec>& elements) {
  std::int64_t id = 0;
  for (const ElementSpec& spec : elements) id = std::max(id, spec.id + 1);
  return id;
}

/// Adds a vertex to the shape and to every pose.
Index add_vertex(HostileMesh& mesh, const Vec3& position) {
  for_each_pose(mesh, [&](std::vector<Vec3>& x) { x.push_back(position); });
  mesh.moving = static_cast<Index>(mesh.shape.positions.size());
  return mesh.moving - 1;
}

}  // namespace

Vec3 lattice_point(Choices& c, int range) {
  const double x = c.lattice(range), y = c.lattice(range), z = c.lattice(range);
  return {x, y, z};
}

Index add_vertex(Shape& shape, const Vec3& position) {
  shape.positions.push_back(position);
  return static_cast<Index>(shape.positions.size() - 1);
}

void add_element(std::vector<ElementSpec>& elements, ElementType type, std::vector<Index> vertices,
                 std::int32_t object) {
  elements.push_back({.type = type, .vertices = std::move(vertices), .object = object, .id = next_id(elements)});
}

std::vector<ElementSpec> fill_cell(const Cell& corners, CellFilling filling, int rotation, Index centre) {
  const std::array<int, 8> to = rotated_corners(rotation);
  Cell cell{};
  for (std::size_t c = 0; c < 8; ++c) cell[c] = corners[static_cast<std::size_t>(to[c])];
  std::vector<ElementSpec> made;
  const auto add = [&](ElementType type, std::vector<Index> vertices) {
    made.push_back({.type = type, .vertices = std::move(vertices)});
  };
  switch (filling) {
    case CellFilling::hexahedron: add(ElementType::hexahedron, {cell.begin(), cell.end()}); break;
    case CellFilling::polytope: made.push_back(polytope(cell)); break;
    case CellFilling::wedges:
      for (const auto& wedge : kWedges) add(ElementType::wedge, pick(cell, wedge));
      break;
    case CellFilling::five_tetrahedra:
      for (const auto& tet : kFive) add(ElementType::tetrahedron, pick(cell, tet));
      break;
    case CellFilling::six_tetrahedra:
      for (const auto& tet : kSix) add(ElementType::tetrahedron, pick(cell, tet));
      break;
    case CellFilling::pyramids:
      for (const auto& face : kFace) made.push_back(pyramid(cell, face, centre));
      break;
  }
  return made;
}

namespace {

/// Lattice positions, and the cells; no elements yet.
HostileMesh empty_block(int nx, int ny, int nz, int width) {
  HostileMesh mesh;
  for (int z = 0; z <= nz; ++z)
    for (int y = 0; y <= ny; ++y)
      for (int x = 0; x <= nx; ++x) mesh.shape.positions.push_back(width * Vec3(x, y, z));
  for (int z = 0; z < nz; ++z)
    for (int y = 0; y < ny; ++y)
      for (int x = 0; x < nx; ++x) {
        Cell& cell = mesh.cells.emplace_back();
        for (std::size_t c = 0; c < 8; ++c)
          cell[c] =
              static_cast<Index>(((z + kCorner[c][2]) * (ny + 1) + y + kCorner[c][1]) * (nx + 1) + x + kCorner[c][0]);
      }
  mesh.moving = static_cast<Index>(mesh.shape.positions.size());
  return mesh;
}

void fill(HostileMesh& mesh, const Cell& cell, CellFilling filling, int rotation) {
  Index centre = 0;
  if (filling == CellFilling::pyramids) {
    Vec3 sum = Vec3::Zero();
    for (const Index v : cell) sum += mesh.shape.positions[v];
    centre = add_vertex(mesh, rounded(sum / 8));
  }
  std::int64_t id = next_id(mesh.shape.elements);
  for (ElementSpec& spec : fill_cell(cell, filling, rotation, centre)) {
    spec.id = id++;
    mesh.shape.elements.push_back(std::move(spec));
  }
}

}  // namespace

HostileMesh cell_block(Choices& c, int size) {
  const int nx = between(c, 1, size), ny = between(c, 1, size), nz = between(c, 1, size);
  HostileMesh mesh = empty_block(nx, ny, nz, kCellWidth);
  const bool mixed = c.one_in(3), rotate = c.one_in(2);
  const int common = c.one_in(2) ? c.below(6) : static_cast<int>(CellFilling::six_tetrahedra);
  for (const Cell& cell : std::vector<Cell>(mesh.cells))
    fill(mesh, cell, static_cast<CellFilling>(mixed ? c.below(6) : common),
         rotate || mixed ? c.below(c.one_in(20) ? 48 : 24) : 0);
  mesh.what = mixed ? "mixed cells" : "cells";
  return mesh;
}

HostileMesh tetrahedron_block(int nx, int ny, int nz, int width) {
  HostileMesh mesh = empty_block(nx, ny, nz, width);
  for (const Cell& cell : std::vector<Cell>(mesh.cells)) fill(mesh, cell, CellFilling::six_tetrahedra, 0);
  return mesh;
}

HostileMesh apart(ElementType type, int count) {
  const int corners = volccd::vertex_count(type);
  HostileMesh mesh;
  for (int i = 0; i < count; ++i) {
    const Vec3 at = 2 * kCellWidth * Vec3(i % 20, i / 20, 0);
    std::vector<Index> vertices;
    for (int k = 0; k < corners; ++k) {
      const bool apex = k + 1 == corners;
      const Vec3 corner(kCorner[k][0], kCorner[k][1], apex ? 1 : 0);
      vertices.push_back(add_vertex(mesh.shape, at + kCellWidth * corner));
    }
    mesh.shape.elements.push_back({.type = type, .vertices = std::move(vertices), .id = i});
  }
  mesh.moving = static_cast<Index>(mesh.shape.positions.size());
  mesh.what = "elements apart";
  return mesh;
}

void append(HostileMesh& mesh, const HostileMesh& other, const Vec3& offset, std::int32_t object) {
  const auto first = static_cast<Index>(mesh.shape.positions.size());
  const std::size_t count = std::max(mesh.poses.size(), other.poses.size());
  std::vector<std::vector<Vec3>> poses;
  for (std::size_t i = 0; i < count; ++i) {
    std::vector<Vec3> pose = i < mesh.poses.size() ? mesh.poses[i] : mesh.shape.positions;
    for (const Vec3& p : i < other.poses.size() ? other.poses[i] : other.shape.positions) pose.push_back(p + offset);
    poses.push_back(std::move(pose));
  }
  mesh.poses = std::move(poses);
  Shape moved = other.shape;
  mesh.shape.append(moved.translate(offset), object);
  for (const Index v : other.pulled) mesh.pulled.push_back(first + v);
  for (Cell cell : other.cells) {
    for (Index& v : cell) v += first;
    mesh.cells.push_back(cell);
  }
  mesh.moving = static_cast<Index>(mesh.shape.positions.size());
}

bool join(HostileMesh& mesh, Index a, Index b) {
  if (a == b) return false;
  for (const ElementSpec& e : mesh.shape.elements) {
    const auto has = [&](Index v) { return std::find(e.vertices.begin(), e.vertices.end(), v) != e.vertices.end(); };
    if (has(a) && has(b)) return false;
  }
  for (ElementSpec& e : mesh.shape.elements) e.renumber([&](Index v) { return v == b ? a : v; });
  for (Cell& cell : mesh.cells)
    for (Index& v : cell) v = v == b ? a : v;
  std::erase_if(mesh.cells, [](Cell cell) {
    std::sort(cell.begin(), cell.end());
    return std::adjacent_find(cell.begin(), cell.end()) != cell.end();
  });
  return true;
}

void remove_unused_vertices(HostileMesh& mesh) {
  std::vector<Index> to(mesh.shape.positions.size(), kNone);
  for (const ElementSpec& e : mesh.shape.elements)
    for (const Index v : e.vertices) to[v] = 0;
  Index next = 0, moving = 0;
  for (Index v = 0; v < to.size(); ++v) {
    if (v == mesh.moving) moving = next;
    if (to[v] != kNone) to[v] = next++;
  }
  mesh.moving = mesh.moving < to.size() ? moving : next;
  for_each_pose(mesh, [&](std::vector<Vec3>& x) {
    for (std::size_t v = 0; v < x.size(); ++v)
      if (to[v] != kNone) x[to[v]] = x[v];
    x.resize(next);
  });
  for (ElementSpec& e : mesh.shape.elements) e.renumber([&](Index v) { return to[v]; });
  std::erase_if(mesh.cells, [&](const Cell& cell) {
    return std::any_of(cell.begin(), cell.end(), [&](Index v) { return to[v] == kNone; });
  });
  for (Cell& cell : mesh.cells)
    for (Index& v : cell) v = to[v];
  std::erase_if(mesh.pulled, [&](Index v) { return to[v] == kNone; });
  for (Index& v : mesh.pulled) v = to[v];
}

void append_calm_block(HostileMesh& mesh, int size) {
  const Index moving = mesh.moving;
  HostileMesh calm = tetrahedron_block(size, size, size);
  calm.cells.clear();
  append(mesh, calm, Vec3(4096, 0, 0), 0);
  mesh.moving = moving;
}

namespace {

/// Adds `n` vertices near another one.
void add_near(Choices& c, HostileMesh& mesh, Index root, int n, int range, std::vector<Index>& out) {
  for (int i = 0; i < n; ++i) out.push_back(add_vertex(mesh, mesh.shape.positions[root] + lattice_point(c, range)));
}

}  // namespace

void add_strip(Choices& c, HostileMesh& mesh, std::vector<Index> root, int length) {
  constexpr ElementType kTypes[] = {ElementType::triangle, ElementType::tetrahedron, ElementType::quad,
                                    ElementType::hexahedron};
  constexpr int kShared[] = {2, 3, 2, 4};  // vertices that consecutive elements have in common
  const int which = c.below(4), shared = kShared[which];
  const int range = c.below(4) ? kCellWidth : 3 * kCellWidth;
  std::vector<Index> last = std::move(root);
  for (int i = 0; i < length; ++i) {
    const int missing = volccd::vertex_count(kTypes[which]) - static_cast<int>(last.size());
    add_near(c, mesh, last.back(), missing, range, last);
    add_element(mesh.shape.elements, kTypes[which], last, 1);
    mesh.pulled.push_back(last.back());
    last.erase(last.begin(), last.end() - shared);
    if (c.one_in(4)) last.erase(last.begin(), last.end() - 1);  // the next element is pinned at one vertex
  }
}

void add_membrane(Choices& c, HostileMesh& mesh) {
  const std::size_t count = mesh.shape.elements.size();
  const int share = between(c, 2, 8);
  for (std::size_t i = 0; i < count; ++i) {
    if (mesh.shape.elements[i].type != ElementType::tetrahedron || c.below(share)) continue;
    std::vector<Index> face = mesh.shape.elements[i].vertices;
    face.erase(face.begin() + c.below(4));
    add_element(mesh.shape.elements, ElementType::triangle, face, 1);
  }
}

void add_leaves(Choices& c, HostileMesh& mesh) {
  std::vector<ElementSpec> tetrahedra;
  for (const ElementSpec& e : mesh.shape.elements)
    if (e.type == ElementType::tetrahedron) tetrahedra.push_back(e);
  if (tetrahedra.empty()) return;
  for (int i = between(c, 1, 4); i > 0; --i) {
    std::vector<Index> leaf = one_of(c, tetrahedra).vertices;
    Index& corner = leaf[static_cast<std::size_t>(c.below(4))];
    corner = add_vertex(mesh, mesh.shape.positions[corner] + lattice_point(c, kCellWidth));
    add_element(mesh.shape.elements, ElementType::tetrahedron, leaf, 1);
  }
}

void tear(Choices& c, HostileMesh& mesh) {
  const int share = between(c, 2, 12);
  std::vector<ElementSpec> kept;
  for (const ElementSpec& e : mesh.shape.elements)
    if (c.below(share) != share - 1) kept.push_back(e);
  if (kept.size() > 3) mesh.shape.elements = std::move(kept);
}

void reverse_some(Choices& c, HostileMesh& mesh) {
  const int share = between(c, 1, 12);
  for (ElementSpec& e : mesh.shape.elements) {
    if (c.below(share)) continue;
    if (e.type == ElementType::tetrahedron) std::swap(e.vertices[0], e.vertices[1]);
    if (is_shell(e.type)) std::reverse(e.vertices.begin(), e.vertices.end());
    if (e.type == ElementType::hexahedron)
      std::swap_ranges(e.vertices.begin(), e.vertices.begin() + 4, e.vertices.begin() + 4);
  }
}

void assign_objects(Choices& c, HostileMesh& mesh) {
  const int objects = between(c, 1, 4);
  for (ElementSpec& e : mesh.shape.elements) e.object = c.below(objects);
}

void permute(Choices& c, HostileMesh& mesh) {
  const auto shuffle = [&](auto begin, int n) {
    for (int i = n; i > 1; --i) std::swap(begin[i - 1], begin[c.below(i)]);
  };
  std::vector<Index> to(mesh.shape.positions.size());
  std::iota(to.begin(), to.end(), Index{0});
  shuffle(to.begin(), static_cast<int>(mesh.moving));
  for_each_pose(mesh, [&](std::vector<Vec3>& x) {
    const std::vector<Vec3> from = x;
    for (std::size_t v = 0; v < from.size(); ++v) x[to[v]] = from[v];
  });
  for (ElementSpec& e : mesh.shape.elements) e.renumber([&](Index v) { return to[v]; });
  for (Cell& cell : mesh.cells)
    for (Index& v : cell) v = to[v];
  for (Index& v : mesh.pulled) v = to[v];
  shuffle(mesh.shape.elements.begin(), static_cast<int>(mesh.shape.elements.size()));
}

}  // namespace volccd::cases
