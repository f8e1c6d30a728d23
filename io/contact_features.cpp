#include <volccd/io/contact_features.hpp>

#include <algorithm>
#include <array>
#include <filesystem>

#include <fmt/format.h>

#include <volccd/io/contact_sides.hpp>
#include <volccd/io/detail/appended_arrays.hpp>

namespace volccd {

namespace {

/// A vertex, edge or triangle with what its contacts say.
struct Feature {
  int corners = 1;
  std::array<Index, 3> vertices = {kNone, kNone, kNone};
  std::uint64_t contacts = 1;
  double toi = 0;
  bool at_start = false;
  ContactSide side = {};

  bool same(const Feature& other) const { return corners == other.corners && vertices == other.vertices; }
};

/// The features of all contacts, each once, vertices first.
std::vector<Feature> features_of(std::span<const Contact> contacts, const Mesh& mesh) {
  std::vector<Feature> all;
  all.reserve(2 * contacts.size());
  for (const Contact& contact : contacts) {
    const int first = contact.kind == FeatureKind::vf ? 1 : 2;
    const std::array<ContactSide, 2> sides = contact_sides(contact, mesh);
    for (const int side : {0, 1}) {
      Feature feature{.corners = side == 0 ? first : 4 - first,
                      .toi = contact.toi,
                      .at_start = contact.at_start,
                      .side = sides[static_cast<std::size_t>(side)]};
      std::copy_n(contact.vertices.begin() + (side == 0 ? 0 : first), feature.corners, feature.vertices.begin());
      all.push_back(feature);
    }
  }
  std::sort(all.begin(), all.end(), [](const Feature& a, const Feature& b) {
    return a.corners != b.corners ? a.corners < b.corners : a.vertices < b.vertices;
  });
  std::vector<Feature> once;
  for (const Feature& feature : all) {
    if (once.empty() || !once.back().same(feature)) {
      once.push_back(feature);
      continue;
    }
    ++once.back().contacts;
    once.back().toi = std::min(once.back().toi, feature.toi);
    once.back().at_start = once.back().at_start || feature.at_start;
  }
  return once;
}

std::vector<Index> vertices_of(const std::vector<Feature>& features) {
  std::vector<Index> vertices;
  for (const Feature& feature : features)
    vertices.insert(vertices.end(), feature.vertices.begin(), feature.vertices.begin() + feature.corners);
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

/// The cells with `corners` corners, as the element `name`.
std::string cells(const char* name, int corners, const std::vector<Feature>& features,
                  const std::vector<Index>& vertices, detail::AppendedArrays& arrays) {
  const auto begin =
      std::find_if(features.begin(), features.end(), [&](const Feature& f) { return f.corners == corners; });
  const auto n = static_cast<std::size_t>(
      std::count_if(begin, features.end(), [&](const Feature& f) { return f.corners == corners; }));
  const auto width = static_cast<std::size_t>(corners);
  std::string text = fmt::format("<{}>\n", name);
  text += arrays.add<std::int64_t>("Int64", "connectivity", n * width, 1, [&](std::size_t i, std::size_t) {
    const Index v = begin[static_cast<std::ptrdiff_t>(i / width)].vertices[i % width];
    return std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin();
  });
  text +=
      arrays.add<std::int64_t>("Int64", "offsets", n, 1, [&](std::size_t i, std::size_t) { return (i + 1) * width; });
  return text + fmt::format("</{}>\n", name);
}

std::string cell_data(const std::vector<Feature>& features, double begin, double length,
                      detail::AppendedArrays& arrays) {
  const std::size_t n = features.size();
  std::string text = "<CellData>\n";
  const auto add = [&]<class T>(T, const char* type, const char* name, auto value) {
    text += arrays.add<T>(type, name, n, 1, [&](std::size_t i, std::size_t) { return value(features[i]); });
  };
  add(std::uint8_t{}, "UInt8", "Feature", [](const Feature& f) { return f.corners - 1; });
  add(std::int64_t{}, "Int64", "Contacts", [](const Feature& f) { return f.contacts; });
  add(double{}, "Float64", "TimeOfImpact", [](const Feature& f) { return f.toi; });
  add(double{}, "Float64", "Time", [&](const Feature& f) { return begin + f.toi * length; });
  add(std::uint8_t{}, "UInt8", "AtStart", [](const Feature& f) { return f.at_start ? 1 : 0; });
  add(std::int64_t{}, "Int64", "Object", [](const Feature& f) { return f.side.object; });
  add(std::int64_t{}, "Int64", "Element", [](const Feature& f) { return f.side.element; });
  return text + "</CellData>\n";
}

/// As XML has it in an attribute.
std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '"' ? "&quot;" : std::string(1, c);
  return result;
}

}  // namespace

bool ContactFeaturesWriter::is_series(const std::string& file) { return file.ends_with(".pvd"); }

ContactFeaturesWriter::ContactFeaturesWriter(const std::string& file)
    : output_(file, kOnlyFiles), stem_(file.substr(0, file.size() - (is_series(file) ? 4 : 0))) {}

std::string ContactFeaturesWriter::file_of(int number) const { return fmt::format("{}_{:04}.vtp", stem_, number); }

void ContactFeaturesWriter::write_step(int step, double begin_time, double end_time, std::span<const Contact> contacts,
                                       const Mesh& mesh, const Motion& motion) {
  if (entries_.empty()) write_frame(step - 1, begin_time, begin_time, {}, mesh, motion);
  write_frame(step, begin_time, end_time, contacts, mesh, motion);
}

/// The file of the end of a step.
void ContactFeaturesWriter::write_frame(int step, double begin_time, double end_time, std::span<const Contact> contacts,
                                        const Mesh& mesh, const Motion& motion) {
  const std::vector<Feature> features = features_of(contacts, mesh);
  const std::vector<Index> vertices = vertices_of(features);
  const auto count = [&](int corners) {
    return std::count_if(features.begin(), features.end(), [&](const Feature& f) { return f.corners == corners; });
  };
  detail::AppendedArrays arrays;
  std::string text =
      detail::polydata_head("") + fmt::format(
                                      "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"{}\" "
                                      "NumberOfStrips=\"0\" NumberOfPolys=\"{}\">\n",
                                      vertices.size(), count(1), count(2), count(3));
  text += "<PointData>\n" +
          arrays.add<std::int64_t>("Int64", "VertexIds", vertices.size(), 1,
                                   [&](std::size_t i, std::size_t) { return mesh.vertex_id(vertices[i]); }) +
          "</PointData>\n";
  text += cell_data(features, begin_time, end_time - begin_time, arrays);
  text += "<Points>\n" + arrays.add<double>("Float64", "Points", vertices.size(), 3, [&](std::size_t i, std::size_t c) {
    return motion.at(vertices[i])[3 * static_cast<std::size_t>(motion.degree()) + c];
  }) + "</Points>\n";
  text += cells("Verts", 1, features, vertices, arrays) + cells("Lines", 2, features, vertices, arrays) +
          cells("Polys", 3, features, vertices, arrays);
  const std::string file = file_of(step + 1);
  OutputFile output(file);
  output.write(text + detail::kPolydataArrays);
  output.write(arrays.bytes());
  output.write(detail::kPolydataEnd);
  output.commit();
  entries_.push_back({step, end_time, std::filesystem::path(file).filename().string()});
}

void ContactFeaturesWriter::write(const std::string& comment) {
  std::string text =
      "<?xml version=\"1.0\"?>\n" + comment + "<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  for (const Entry& entry : entries_)
    text += fmt::format("<DataSet timestep=\"{:.17g}\" part=\"0\" file=\"{}\"/>\n", entry.time, escaped(entry.file));
  output_.write(text + "</Collection>\n</VTKFile>\n");
  output_.commit();
}

void ContactFeaturesWriter::finish() { write(""); }

StepsDone ContactFeaturesWriter::finish_incomplete(const StepsDone& steps) {
  std::erase_if(entries_, [&](const Entry& entry) { return entry.step >= steps.done; });
  write(detail::incomplete_comment(steps.text()));
  return steps;
}

}  // namespace volccd
