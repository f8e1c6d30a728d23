#include <volccd/distributed/detail/home.hpp>

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <volccd/core/sort_unique.hpp>
#include <volccd/distributed/agreement.hpp>
#include <volccd/mesh/check_element.hpp>

namespace volccd::distributed::detail {

namespace {

/// Elements or vertices whose boxes a worker computes in one go.
constexpr std::size_t kBoxes = 1024;

/// Throws InputError if the arrays do not belong to the same elements.
void check_shape(const Elements& elements) {
  const std::size_t n = elements.types.size();
  const auto good = [n](const std::vector<std::size_t>& offsets, std::size_t values) {
    return offsets.size() == n + 1 && offsets.front() == 0 && offsets.back() == values &&
           std::ranges::is_sorted(offsets);
  };
  if (elements.objects.size() != n || elements.ids.size() != n || !good(elements.offsets, elements.vertices.size()) ||
      !good(elements.face_offsets, elements.faces.size()))
    throw InputError("mesh", "elements", "the arrays of types, objects, ids and offsets do not have the same length");
}

}  // namespace

Home::Home(Exchange& exchange, Elements elements, std::vector<std::int64_t> vertices, EdgeSet edge_set)
    : elements_(std::move(elements)), vertices_(std::move(vertices)), edge_set_(edge_set) {
  require_same(exchange, "edge set", name_of(edge_set));
  run_on_all(exchange, "mesh", [&] {
    check_shape(elements_);
    if (vertices_.size() >= kNone) throw InputError("mesh", "vertex ids", "more than 2^32 - 2 vertices");
    used_ = elements_.vertices;
    sort_unique(used_);
    own_ = IdTable(vertices_);
    corners_.reserve(elements_.vertices.size());
    for (const std::int64_t id : elements_.vertices)
      corners_.push_back(static_cast<Index>(std::ranges::lower_bound(used_, id) - used_.begin()));
  });
  owners_ = find_owners(exchange, "vertex", vertices_, used_);
  find_owners(exchange, "element", elements_.ids, {});
  check_elements(exchange);
  import_ = VertexImport(exchange, used_, owners_, own_);
}

void Home::check_elements(Exchange& exchange) const {
  run_on_all(exchange, "mesh", [&] {
    const auto slot_of = [&](std::int64_t id) {
      const auto at = std::ranges::lower_bound(used_, id);
      return at != used_.end() && *at == id ? static_cast<Index>(at - used_.begin()) : kNone;
    };
    for (std::size_t i = 0; i < elements_.size(); ++i) {
      const ElementSpec spec = elements_.spec(i, slot_of);
      const std::string problem = volccd::detail::element_problem(spec, static_cast<Index>(used_.size()), used_);
      if (!problem.empty()) throw InputError("mesh", "elements", spec.id, problem);
      for (const Index v : spec.vertices)
        if (owners_[v] == kNoRank)
          throw InputError("mesh", "elements", spec.id, fmt::format("no rank gives its vertex id {}", used_[v]));
    }
  });
}

void Home::make_boxes(double separation, Executor& executor) {
  const Motion& motion = import_.motion();
  vertex_boxes_.resize(used_.size());
  executor.parallel_for(used_.size(), kBoxes, [&](std::size_t begin, std::size_t end, unsigned) {
    for (auto v = static_cast<Index>(begin); v < end; ++v) {
      MotionBox box;
      extend(box, motion, {&v, 1}, motion.control_points());
      vertex_boxes_[v] = enlarged(box, separation);
    }
  });
}

/// Enlarged boxes are monotone, so that an element has the common box of its vertices' boxes.
MotionBox Home::element_box(std::size_t i) const {
  MotionBox box;
  for (std::size_t k = elements_.offsets[i]; k < elements_.offsets[i + 1]; ++k) {
    const MotionBox& corner = corner_box(k);
    box = {box.low.cwiseMin(corner.low), box.high.cwiseMax(corner.high)};
  }
  return box;
}

std::vector<MotionBox> Home::element_boxes(Executor& executor) const {
  std::vector<MotionBox> boxes(elements_.size());
  executor.parallel_for(boxes.size(), kBoxes, [&](std::size_t begin, std::size_t end, unsigned) {
    for (std::size_t i = begin; i < end; ++i) boxes[i] = element_box(i);
  });
  return boxes;
}

}  // namespace volccd::distributed::detail
