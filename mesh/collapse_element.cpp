#include <volccd/mesh/collapse_element.hpp>

#include <algorithm>
#include <array>
#include <cassert>
#include <map>
#include <utility>

#include <volccd/core/sort_unique.hpp>

namespace volccd::detail {

namespace {

using Face = std::vector<Index>;
using Faces = std::vector<Face>;

std::vector<Index> distinct(std::span<const Index> nodes) {
  std::vector<Index> result(nodes.begin(), nodes.end());
  sort_unique(result);
  return result;
}

/// The cyclic sequence without repeated neighbours, beginning with its smallest node.
Face reduced(Face face) {
  face.erase(std::unique(face.begin(), face.end()), face.end());
  while (face.size() > 1 && face.front() == face.back()) face.pop_back();
  if (!face.empty()) std::rotate(face.begin(), std::min_element(face.begin(), face.end()), face.end());
  return face;
}

/// The reduced faces of an element, without those with fewer than three nodes, in ascending order.
Faces faces_of(ElementType type, std::span<const Index> nodes) {
  Faces faces;
  visit_faces(face_stream(type), [&](std::span<const std::uint8_t> numbers) {
    Face face;
    for (const std::uint8_t i : numbers) face.push_back(nodes[i]);
    face = reduced(std::move(face));
    if (face.size() >= 3) faces.push_back(std::move(face));
  });
  std::sort(faces.begin(), faces.end());
  return faces;
}

Face opposite(const Face& face) { return reduced({face.rbegin(), face.rend()}); }

void cancel_coincident(Faces& faces) {
  for (std::size_t i = 0; i < faces.size();) {
    const auto other = std::find(faces.begin() + static_cast<std::ptrdiff_t>(i) + 1, faces.end(), opposite(faces[i]));
    if (other == faces.end()) {
      ++i;
      continue;
    }
    faces.erase(other);
    faces.erase(faces.begin() + static_cast<std::ptrdiff_t>(i));
  }
}

/// The node that follows `v` in the face.
Index next(const Face& face, Index v) {
  const auto at = std::find(face.begin(), face.end(), v);
  return at + 1 == face.end() ? face.front() : *(at + 1);
}

/// Describes why a surface is not the boundary of a polyhedron with these vertices; empty if it is. The surface is a
/// sphere if each edge is in two faces, once in each direction, all faces are connected by edges, and Euler's formula
/// holds.
std::string surface_problem(const Faces& faces, const std::vector<Index>& vertices) {
  std::map<std::array<Index, 2>, std::size_t> edges;  // the face of each directed edge
  std::vector<Index> used;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Face& face = faces[f];
    if (distinct(face).size() != face.size()) return "a face touches itself";
    used.insert(used.end(), face.begin(), face.end());
    for (const Index v : face)
      if (!edges.insert({{v, next(face, v)}, f}).second) return "more than two faces meet at an edge";
  }
  for (const auto& [edge, face] : edges)
    if (!edges.contains({edge[1], edge[0]})) return "the faces do not close up";
  if (distinct(used) != vertices) return "some nodes are in no face";
  for (const Index v : vertices)
    if (std::count(used.begin(), used.end(), v) < 3) return "fewer than three faces meet at a node";
  // Faces that are connected with the first face by common edges.
  std::vector<std::size_t> reached{0};
  std::vector<char> seen(faces.size(), 0);
  seen[0] = 1;
  for (std::size_t at = 0; at < reached.size(); ++at)
    for (const Index v : faces[reached[at]]) {
      const std::size_t other = edges.at({next(faces[reached[at]], v), v});
      if (!std::exchange(seen[other], 1)) reached.push_back(other);
    }
  if (reached.size() != faces.size() || vertices.size() + faces.size() != edges.size() / 2 + 2)
    return "it is pinched at a node";
  return {};
}

bool has(const Face& face, Index v) { return std::find(face.begin(), face.end(), v) != face.end(); }

/// The base and the apex. VTK's tetrahedron and pyramid begin with their base, in the order seen from inside.
CollapsedElement on_base(ElementType type, const Face& base, const std::vector<Index>& vertices) {
  CollapsedElement guess{type, opposite(base), {}, {}};
  guess.vertices.push_back(*std::find_if(vertices.begin(), vertices.end(), [&](Index v) { return !has(base, v); }));
  return guess;
}

/// VTK's wedge begins with a triangle, in the order seen from outside. Each of its corners corresponds to the other end
/// of the third edge at that corner.
CollapsedElement wedge_on(const Face& triangle, const Faces& faces) {
  CollapsedElement guess{ElementType::wedge, triangle, {}, {}};
  for (const Index corner : triangle)
    for (const Face& face : faces)
      // Of the two quads at the corner, selects the one in which the edge leads away from the triangle.
      if (face.size() == 4 && has(face, corner) && !has(triangle, next(face, corner)))
        guess.vertices.push_back(next(face, corner));
  return guess;
}

/// A fixed type and a node order that may have these faces; no type if there is none.
CollapsedElement guess_of(const Faces& faces, const std::vector<Index>& vertices) {
  const auto triangles = std::count_if(faces.begin(), faces.end(), [](const Face& f) { return f.size() == 3; });
  const auto quads = static_cast<std::ptrdiff_t>(faces.size()) - triangles;
  const auto first_of = [&](std::size_t n) {
    return *std::find_if(faces.begin(), faces.end(), [&](const Face& f) { return f.size() == n; });
  };
  if (vertices.size() == 4 && triangles == 4 && quads == 0)
    return on_base(ElementType::tetrahedron, faces.front(), vertices);
  if (vertices.size() == 5 && triangles == 4 && quads == 1) return on_base(ElementType::pyramid, first_of(4), vertices);
  if (vertices.size() == 6 && triangles == 2 && quads == 3) return wedge_on(first_of(3), faces);
  return {};
}

CollapsedElement collapse_solid(ElementType type, std::span<const Index> nodes) {
  const std::vector<Index> vertices = distinct(nodes);
  if (type == ElementType::hexahedron && vertices.size() == 4 && distinct(nodes.subspan(3)).size() == 1)
    return {ElementType::tetrahedron, {nodes.begin(), nodes.begin() + 4}, {}, {}};
  Faces faces = faces_of(type, nodes);
  cancel_coincident(faces);
  if (faces.empty()) return {ElementType::none, {}, {}, "it has no volume"};
  if (std::string problem = surface_problem(faces, vertices); !problem.empty())
    return {ElementType::none, {}, {}, std::move(problem)};
  CollapsedElement guess = guess_of(faces, vertices);
  if (guess.type != ElementType::none && guess.vertices.size() == vertices.size() &&
      faces_of(guess.type, guess.vertices) == faces)
    return guess;
  CollapsedElement polytope{ElementType::polytope, vertices, {}, {}};
  for (const Face& face : faces) {
    polytope.faces.push_back(static_cast<Index>(face.size()));
    polytope.faces.insert(polytope.faces.end(), face.begin(), face.end());
  }
  return polytope;
}

}  // namespace

CollapsedElement collapse_element(ElementType type, std::span<const Index> nodes) {
  assert(type != ElementType::polytope && nodes.size() == static_cast<std::size_t>(vertex_count(type)));
  if (!is_shell(type)) return collapse_solid(type, nodes);
  Face face = reduced({nodes.begin(), nodes.end()});
  if (face.size() < 3 || distinct(face).size() != face.size()) return {ElementType::none, {}, {}, "it has no area"};
  return {ElementType::triangle, std::move(face), {}, {}};
}

}  // namespace volccd::detail
