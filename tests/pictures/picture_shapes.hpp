// Shapes as surfaces, and plain pictures of them.
#pragma once

#include <string>
#include <vector>

#include <volccd/oracle/cases/shapes.hpp>
#include <volccd/pictures/renderer.hpp>
#include <volccd/pictures/surface.hpp>

namespace volccd::test {

inline constexpr Colour kWhite{255, 255, 255};

inline SequenceCells cells_of_shape(const Shape& shape) {
  SequenceCells cells;
  for (const ElementSpec& element : shape.elements) cells.add(element);
  return cells;
}

inline Surface surface_of_shape(const Shape& shape) {
  const SequenceCells cells = cells_of_shape(shape);
  const std::vector<std::uint16_t> colours(cells.size(), 0);
  return surface_of(cells, shape.positions, colours);
}

inline RenderOptions plain() {
  RenderOptions options;
  options.samples = 1;
  options.lines = options.occlusion = false;
  return options;
}

inline View front() {
  View view;
  parse_view("front", view);
  view.orthographic = true;
  return view;
}

inline std::vector<Vec3> box_corners(const Vec3& low, const Vec3& high) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(), i & 4 ? high.z() : low.z());
  return corners;
}

}  // namespace volccd::test
