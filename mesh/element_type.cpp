#include <volccd/mesh/element_type.hpp>

#include <volccd/mesh/detail/element_tables.hpp>

namespace volccd {

namespace {

constexpr int kMaxStream = 30;  // length of a hexahedron's stream: 6 * (1 + 4)

struct FaceStream {
  std::array<std::uint8_t, kMaxStream> data{};
  std::size_t length = 0;
};

constexpr FaceStream make_stream(const detail::ElementTable& table) {
  FaceStream stream;
  for (std::size_t f = 0; f < table.triangles; ++f) {
    stream.data[stream.length++] = 3;
    for (std::uint8_t v : table.triangle[f]) stream.data[stream.length++] = v;
  }
  for (std::size_t f = 0; f < table.quads; ++f) {
    stream.data[stream.length++] = 4;
    for (std::uint8_t v : table.quad[f]) stream.data[stream.length++] = v;
  }
  return stream;
}

constexpr FaceStream kTriangleFaces = make_stream(detail::kTriangleTable);
constexpr FaceStream kQuadFaces = make_stream(detail::kQuadTable);
constexpr FaceStream kTetrahedronFaces = make_stream(detail::kTetrahedronTable);
constexpr FaceStream kHexahedronFaces = make_stream(detail::kHexahedronTable);
constexpr FaceStream kWedgeFaces = make_stream(detail::kWedgeTable);
constexpr FaceStream kPyramidFaces = make_stream(detail::kPyramidTable);

constexpr std::span<const std::uint8_t> view(const FaceStream& stream) { return {stream.data.data(), stream.length}; }

}  // namespace

const char* to_string(ElementType type) {
  switch (type) {
    case ElementType::none: return "none";
    case ElementType::triangle: return "triangle";
    case ElementType::quad: return "quad";
    case ElementType::tetrahedron: return "tetrahedron";
    case ElementType::hexahedron: return "hexahedron";
    case ElementType::wedge: return "wedge";
    case ElementType::pyramid: return "pyramid";
    case ElementType::polytope: return "polytope";
  }
  return "unknown";
}

bool is_element_type(int vtk_type) {
  switch (vtk_type) {
    case static_cast<int>(ElementType::triangle):
    case static_cast<int>(ElementType::quad):
    case static_cast<int>(ElementType::tetrahedron):
    case static_cast<int>(ElementType::hexahedron):
    case static_cast<int>(ElementType::wedge):
    case static_cast<int>(ElementType::pyramid):
    case static_cast<int>(ElementType::polytope): return true;
    default: return false;
  }
}

int vertex_count(ElementType type) { return detail::element_table(type).vertices; }

bool is_shell(ElementType type) { return type == ElementType::triangle || type == ElementType::quad; }

std::span<const std::uint8_t> face_stream(ElementType type) {
  switch (type) {
    case ElementType::triangle: return view(kTriangleFaces);
    case ElementType::quad: return view(kQuadFaces);
    case ElementType::tetrahedron: return view(kTetrahedronFaces);
    case ElementType::hexahedron: return view(kHexahedronFaces);
    case ElementType::wedge: return view(kWedgeFaces);
    case ElementType::pyramid: return view(kPyramidFaces);
    case ElementType::none:
    case ElementType::polytope: break;
  }
  return {};
}

}  // namespace volccd
