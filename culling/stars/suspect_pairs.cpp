#include <volccd/culling/stars/suspect_pairs.hpp>

#include <algorithm>

namespace volccd::detail {

namespace {

/// The common vertices of two elements if all of them are suspect; otherwise none.
struct CommonVertices {
  std::size_t count = 0;
  Index first = kNone, last = kNone;  ///< in the order of the first element

  CommonVertices(const Mesh& mesh, const VertexStars& stars, Index a, Index b) {
    const std::span<const Index> of_b = mesh.vertices(b);
    for (const Index v : mesh.vertices(a)) {
      if (std::find(of_b.begin(), of_b.end(), v) == of_b.end()) continue;
      if (!stars.suspect(v)) {
        count = 0;
        return;
      }
      if (count++ == 0) first = v;
      last = v;
    }
  }
};

/// Whether the elements are one tetrahedron whose volume has a sign, or two on different sides of a common face.
bool apart_by_signs(const Mesh& mesh, const VertexStars& stars, Index a, Index b) {
  if (mesh.type(a) != ElementType::tetrahedron || mesh.type(b) != ElementType::tetrahedron) return false;
  const int sign = stars.volume_sign(a);
  return sign != 0 && sign == stars.volume_sign(b) && (a == b || stars.table().share_inner_face(mesh, a, b));
}

}  // namespace

void SuspectPairs::update(const Step& step, const VertexStars& stars, Executor& executor,
                          FunctionRef<bool(Index, Index)> pays) {
  const Mesh& mesh = step.mesh();
  list_.update(step, stars.suspects(), executor, [&](Index a, Index b, Index v) -> ListedPair {
    const CommonVertices common(mesh, stars, a, b);
    // A pair with several suspect vertices is visited at each of them, and listed at the first.
    if (common.count == 0 || common.first != v) return {};
    if (common.count >= 3 && apart_by_signs(mesh, stars, a, b)) return {};
    return {.listed = true,
            .tested = common.count == 1 || (common.count == 2 && pays(a, b)),
            .other = common.count == 2 ? common.last : kNone};
  });
}

}  // namespace volccd::detail
