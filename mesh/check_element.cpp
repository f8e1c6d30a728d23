#include <volccd/mesh/check_element.hpp>

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include <volccd/core/sort_unique.hpp>

namespace volccd::detail {

namespace {

constexpr std::size_t kFewVertices = 16;  // up to this number all pairs are compared

using Ids = std::span<const std::int64_t>;

/// The name of a vertex in messages: its id, or its slot if there are no ids.
std::string name(Ids ids, Index v) {
  return v < ids.size() ? fmt::format("point id {}", ids[v]) : fmt::format("vertex slot {}", v);
}

std::string vertices_problem(const std::vector<Index>& vertices, Index vertex_count, Ids ids) {
  for (Index v : vertices)
    if (v >= vertex_count) return fmt::format("vertex slot {} is out of range, there are {} vertices", v, vertex_count);
  for (std::size_t i = vertices.size() > kFewVertices ? find_repeated<Index>(vertices) : 1; i < vertices.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (vertices[i] == vertices[j]) return name(ids, vertices[i]) + " occurs twice in the element";
  return {};
}

/// Splits the stream into faces, and collects the edges of all faces and the used vertices.
std::string read_faces(const std::vector<Index>& faces, Ids ids, std::vector<std::array<Index, 2>>& edges,
                       std::vector<Index>& used) {
  std::vector<Index> face;
  for (std::size_t at = 0; at < faces.size();) {
    const std::size_t n = faces[at++];
    if (n < 3) return fmt::format("a face of the polytope has {} vertices", n);
    if (n > faces.size() - at) return "the face stream of the polytope is cut short";
    face.assign(faces.begin() + static_cast<std::ptrdiff_t>(at), faces.begin() + static_cast<std::ptrdiff_t>(at + n));
    for (std::size_t i = 0; i < n; ++i) {
      const auto [low, high] = std::minmax(face[i], face[(i + 1) % n]);
      edges.push_back({low, high});
    }
    used.insert(used.end(), face.begin(), face.end());
    std::sort(face.begin(), face.end());
    const auto twice = std::adjacent_find(face.begin(), face.end());
    if (twice != face.end()) return name(ids, *twice) + " occurs twice in a face of the polytope";
    at += n;
  }
  return {};
}

std::string polytope_problem(const ElementSpec& element, Ids ids) {
  std::vector<std::array<Index, 2>> edges;
  std::vector<Index> used, vertices = element.vertices;
  std::string problem = read_faces(element.faces, ids, edges, used);
  if (!problem.empty()) return problem;
  sort_unique(used);
  std::sort(vertices.begin(), vertices.end());
  if (used != vertices) return "the faces of the polytope do not use exactly its vertices";
  std::sort(edges.begin(), edges.end());
  for (std::size_t i = 0, next; i < edges.size(); i = next) {
    for (next = i; next < edges.size() && edges[next] == edges[i];) ++next;
    if (next - i != 2)
      return fmt::format("the faces of the polytope do not close up: the edge from {} to {} is in {} of them",
                         name(ids, edges[i][0]), name(ids, edges[i][1]), next - i);
  }
  return {};
}

}  // namespace

std::string element_problem(const ElementSpec& element, Index vertex_count, Ids ids) {
  if (!is_element_type(static_cast<int>(element.type)))
    return fmt::format("unknown element type {}", static_cast<int>(element.type));
  const bool polytope = element.type == ElementType::polytope;
  const auto n = static_cast<std::size_t>(volccd::vertex_count(element.type));
  if (!polytope && element.vertices.size() != n)
    return fmt::format("a {} has {} vertices, not {}", to_string(element.type), n, element.vertices.size());
  if (!polytope && !element.faces.empty()) return fmt::format("a {} takes no faces", to_string(element.type));
  if (polytope && element.vertices.size() < 4)
    return fmt::format("a polytope has at least 4 vertices, not {}", element.vertices.size());
  std::string problem = vertices_problem(element.vertices, vertex_count, ids);
  if (problem.empty() && polytope) problem = polytope_problem(element, ids);
  return problem;
}

}  // namespace volccd::detail
