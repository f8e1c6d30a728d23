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

/// The face streams of the types with a fixed number of vertices, by the value of the type; others are empty.
constexpr auto kStreams = [] {
  std::array<FaceStream, static_cast<std::size_t>(ElementType::pyramid) + 1> streams;
  for (std::size_t type = 0; type < streams.size(); ++type)
    streams[type] = make_stream(detail::element_table(static_cast<ElementType>(type)));
  return streams;
}();

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

bool is_element_type(std::int64_t vtk_type) {
  return vtk_type == static_cast<int>(ElementType::polytope) ||
         (vtk_type > 0 && vtk_type < 256 && vertex_count(static_cast<ElementType>(vtk_type)) != 0);
}

int vertex_count(ElementType type) { return detail::element_table(type).vertices; }

bool is_shell(ElementType type) { return type == ElementType::triangle || type == ElementType::quad; }

std::span<const std::uint8_t> face_stream(ElementType type) {
  const auto at = static_cast<std::size_t>(type);
  if (at >= kStreams.size()) return {};
  return {kStreams[at].data.data(), kStreams[at].length};
}

}  // namespace volccd
