// The families of hostile meshes.
#include <algorithm>

#include <volccd/oracle/cases/hostile_covers.hpp>

namespace volccd::cases {
namespace {

Index any_vertex(Choices& c, const HostileMesh& mesh, Index from = 0) {
  return from + static_cast<Index>(c.below(static_cast<int>(mesh.shape.positions.size() - from)));
}

std::int32_t other_object(Choices& c) { return c.below(2) ? 1 : 0; }

/// Puts the star into a body: the body's vertex in its middle becomes the centre of the star as well.
void place_in_body(Choices& c, HostileMesh& star) {
  HostileMesh body = tetrahedron_block(2, 2, 2, 64);
  const auto first = static_cast<Index>(star.shape.positions.size());
  append(star, body, Vec3(-64, -64, -64), other_object(c));
  join(star, 0, first + (c.below(2) ? 13 : static_cast<Index>(c.below(27))));
  remove_unused_vertices(star);
}

HostileMesh covered_star(Choices& c) {
  const Surface base = sphere(c);
  Surface link = branched_cover(c, base, c.one_in(4) ? 3 : 2, c.one_in(4) ? 16 : c.below(6));
  const int opened = c.below(4);
  if (opened == 1) open_rings(c, link);
  if (opened > 1) open_over_sheet(c, link, base.triangles.size());
  HostileMesh star = star_over(link);
  star.what = "branched cover";
  if (c.one_in(6)) place_in_body(c, star);
  return star;
}

/// A link without cuts, open or folded, for stars that are clear or nearly so.
HostileMesh plain_star(Choices& c) {
  Surface link = sphere(c);
  for (Vec3& p : link.points) p = between(c, 3, 8) * p + lattice_point(c, c.one_in(3) ? 60 : 6);
  if (c.below(2)) open_rings(c, link);
  HostileMesh star = star_over(link);
  for (int i = c.below(4); i > 0; --i) {
    const Index u = any_vertex(c, star), w = any_vertex(c, star);
    if (u != 0 && w != 0 && u != w) add_element(star.shape.elements, ElementType::triangle, {0, u, w}, 1);
  }
  star.pulled = {0};
  star.what = "star";
  if (c.one_in(4)) place_in_body(c, star);
  return star;
}

HostileMesh winding(Choices& c) {
  HostileMesh star = winding_star(c, static_cast<Winding>(c.below(3)));
  star.what = "winding star";
  if (c.one_in(6)) place_in_body(c, star);
  return star;
}

/// The star whose link has a handle: two sheets, of which the second has a cap, and four branch points.
HostileMesh star_with_handle(Choices& c) {
  HostileMesh star;
  for (const Vec3& p :
       {Vec3(0, 0, 0), Vec3(4, 0, 0), Vec3(-2, 4, 0), Vec3(-2, -4, 0), Vec3(6, 1, 0), Vec3(-4, 6, 0), Vec3(-2, -6, 0),
        Vec3(2, 0, -4), Vec3(-2, 0, -4), Vec3(0, 0, -4), Vec3(0, 0, -5), Vec3(0, 0, 5)})
    star.shape.positions.push_back(16 * p + lattice_point(c, c.below(3) ? 0 : 4));
  constexpr Index r1 = 1, r2 = 2, r3 = 3, s1 = 4, s2 = 5, s3 = 6, P = 7, Q = 8, M = 9, N = 10, T = 11;
  constexpr Index kLink[][3] = {{s1, s2, T}, {s2, s3, T}, {s3, s1, T}, {r1, r2, P}, {r1, P, r3}, {Q, r2, r3},
                                {s1, s2, P}, {s1, P, s3}, {Q, s2, s3}, {P, r2, M},  {M, r2, Q},  {P, M, s3},
                                {M, Q, s3},  {P, s2, N},  {N, s2, Q},  {P, N, r3},  {N, Q, r3}};
  for (const auto& [a, b, d] : kLink) {
    const auto& x = star.shape.positions;
    const bool positive = x[a].cross(x[b]).dot(x[d]) > 0;
    add_element(star.shape.elements, ElementType::tetrahedron, {0, a, positive ? b : d, positive ? d : b});
  }
  star.moving = 12;
  star.what = "star whose link has a handle";
  return star;
}

/// Of some vertices, the one with most elements, which is often an interior one.
Index inner_vertex(Choices& c, const HostileMesh& mesh) {
  Index best = 0;
  std::ptrdiff_t max = -1;
  for (int i = between(c, 1, 8); i > 0; --i) {
    const Index v = any_vertex(c, mesh);
    const auto has = [v](const ElementSpec& e) {
      return std::find(e.vertices.begin(), e.vertices.end(), v) != e.vertices.end();
    };
    const auto count = std::count_if(mesh.shape.elements.begin(), mesh.shape.elements.end(), has);
    if (count > max) best = v, max = count;
  }
  return best;
}

HostileMesh pinned_strips(Choices& c) {
  HostileMesh mesh =
      c.below(3) ? tetrahedron_block(between(c, 2, 4), between(c, 2, 3), between(c, 2, 3)) : cell_block(c, 3);
  for (int strips = 1 + c.below(3) / 2; strips > 0; --strips) {
    std::vector<Index> root = {inner_vertex(c, mesh)};
    if (c.one_in(4)) {
      const std::vector<Index> vertices = one_of(c, mesh.shape.elements).vertices;
      const std::size_t i = static_cast<std::size_t>(c.below(static_cast<int>(vertices.size())));
      root = {vertices[i], vertices[(i + 1) % vertices.size()]};
    }
    add_strip(c, mesh, root, between(c, 1, 3));
  }
  if (c.one_in(6)) add_membrane(c, mesh);
  mesh.what += ", pinned strips";
  return mesh;
}

/// A strip that begins at a vertex in the middle of a body, and ends between its boundary and the elements at that
/// vertex.
HostileMesh strip_in_the_middle(Choices& c) {
  const int nx = between(c, 4, 5), ny = 4, nz = 4;
  const Index pin = 4 + static_cast<Index>((2 * (ny + 1) + 2) * (nx + 1) + 2);
  HostileMesh body = tetrahedron_block(nx, ny, nz), mesh;
  body.cells.clear();
  const Vec3 out = Vec3(between(c, 18, 28), c.lattice(12), c.lattice(12));
  const Vec3 at = body.shape.positions[pin - 4] + (c.below(2) ? out : Vec3(out.z(), out.x(), out.y()));
  for (int i = 0; i < 4; ++i) add_vertex(mesh.shape, at + lattice_point(c, 8));
  append(mesh, body, Vec3::Zero(), 0);
  if (!c.one_in(6)) mesh.moving = 4;  // otherwise the body moves as well
  auto& elements = mesh.shape.elements;
  if (c.below(2)) {
    add_element(elements, ElementType::triangle, {pin, 0, 1}, other_object(c));
    add_element(elements, ElementType::triangle, {0, 1, 2}, other_object(c));
  } else {
    add_element(elements, ElementType::tetrahedron, {pin, 0, 1, 2}, other_object(c));
  }
  add_element(elements, ElementType::triangle, {1, 2, 3}, other_object(c));
  mesh.pulled = {0, 2, 3};
  mesh.what = "strip in the middle";
  return mesh;
}

/// A body of one or two blocks, the second of which has a vertex in common with the first.
HostileMesh joined_blocks(Choices& c, int size) {
  HostileMesh mesh = cell_block(c, size);
  if (c.below(2)) return mesh;
  const auto first = static_cast<Index>(mesh.shape.positions.size());
  append(mesh, cell_block(c, size), lattice_point(c, 2 * kCellWidth), other_object(c));
  const Index a = static_cast<Index>(c.below(static_cast<int>(first)));
  join(mesh, a, any_vertex(c, mesh, first));
  if (c.one_in(3)) join(mesh, static_cast<Index>(c.below(static_cast<int>(first))), any_vertex(c, mesh, first));
  return mesh;
}

HostileMesh nested_bodies(Choices& c) {
  HostileMesh mesh = cell_block(c, 3);
  for (Vec3& p : mesh.shape.positions) p *= 3;
  HostileMesh inner = joined_blocks(c, 2);
  const auto first = static_cast<Index>(mesh.shape.positions.size());
  append(mesh, inner, lattice_point(c, 3 * kCellWidth) + Vec3(30, 30, 30), other_object(c));
  for (int joints = c.below(3); joints > 0; --joints)
    join(mesh, static_cast<Index>(c.below(static_cast<int>(first))), any_vertex(c, mesh, first));
  remove_unused_vertices(mesh);
  mesh.what += ", nested";
  return mesh;
}

/// Two blocks with a common vertex or apart, of which single vertices are pulled far.
HostileMesh pulled_vertices(Choices& c) {
  HostileMesh mesh = c.below(2) ? tetrahedron_block(between(c, 2, 3), 2, between(c, 2, 3)) : cell_block(c, 3);
  if (c.below(2)) append(mesh, cell_block(c, 2), Vec3(between(c, 2, 4) * kCellWidth, c.below(9), c.below(9)), 1);
  for (int i = between(c, 1, 2); i > 0; --i) mesh.pulled.push_back(any_vertex(c, mesh));
  if (mesh.shape.positions.size() > 13) mesh.pulled.push_back(13);  // interior in a block of 2^3 cells
  mesh.what += ", pulled vertices";
  return mesh;
}

/// Elements of all types at one vertex, of several objects.
HostileMesh rubble(Choices& c) {
  HostileMesh mesh = cell_block(c, 2);
  for (int i = between(c, 1, 4); i > 0; --i) {
    const auto first = static_cast<Index>(mesh.shape.positions.size());
    append(mesh, cell_block(c, c.one_in(4) ? 2 : 1), lattice_point(c, kCellWidth), i);
    if (c.below(2)) join(mesh, static_cast<Index>(c.below(static_cast<int>(first))), any_vertex(c, mesh, first));
  }
  for (int i = c.below(6); i > 0; --i) {
    const Index u = any_vertex(c, mesh), v = any_vertex(c, mesh), w = any_vertex(c, mesh);
    if (u != v && v != w && u != w) add_element(mesh.shape.elements, ElementType::triangle, {u, v, w}, 2);
  }
  remove_unused_vertices(mesh);
  mesh.what += ", rubble";
  return mesh;
}

HostileMesh torn_block(Choices& c) {
  HostileMesh mesh = cell_block(c, 3);
  tear(c, mesh);
  if (c.below(2)) add_leaves(c, mesh);
  if (c.one_in(3)) add_membrane(c, mesh);
  mesh.cells.clear();
  mesh.what += ", torn";
  return mesh;
}

/// A sheet that folds and collides with itself, with leaves of other elements.
HostileMesh sheet(Choices& c) {
  HostileMesh mesh;
  mesh.shape = block(c.below(2) ? ElementType::quad : ElementType::triangle, between(c, 2, 5), between(c, 2, 5), 1);
  for (Vec3& p : mesh.shape.positions) p *= kCellWidth;
  mesh.moving = static_cast<Index>(mesh.shape.positions.size());
  if (c.below(2)) append(mesh, cell_block(c, 2), lattice_point(c, kCellWidth), 1);
  if (c.below(2)) join(mesh, 0, any_vertex(c, mesh, 1));
  if (c.below(2)) add_strip(c, mesh, {any_vertex(c, mesh)}, 2);
  remove_unused_vertices(mesh);
  mesh.what = "sheet";
  return mesh;
}

/// Meshes of very different sizes, of which several make a case.
HostileMesh any_size(Choices& c) {
  const int which = c.below(4);
  if (which == 0) return cell_block(c, 1);
  if (which == 1) return apart(c.below(2) ? ElementType::pyramid : ElementType::tetrahedron, between(c, 1, 60));
  HostileMesh mesh;
  mesh.shape = block(c.below(2) ? ElementType::pyramid : ElementType::tetrahedron, between(c, 1, 4), 2, 2);
  for (Vec3& p : mesh.shape.positions) p *= kCellWidth;
  mesh.moving = static_cast<Index>(mesh.shape.positions.size());
  mesh.what = "block";
  return mesh;
}

constexpr HostileFamily kFamilies[] = {{"CoveredStar", covered_star},
                                       {"PlainStar", plain_star},
                                       {"Winding", winding},
                                       {"StarWithHandle", star_with_handle},
                                       {"PinnedStrips", pinned_strips},
                                       {"StripInTheMiddle", strip_in_the_middle},
                                       {"NestedBodies", nested_bodies},
                                       {"PulledVertices", pulled_vertices},
                                       {"Rubble", rubble},
                                       {"TornBlock", torn_block},
                                       {"Sheet", sheet},
                                       {"AnySize", any_size}};

}  // namespace

std::span<const HostileFamily> hostile_families() { return kFamilies; }

}  // namespace volccd::cases
