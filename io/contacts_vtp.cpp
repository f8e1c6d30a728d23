#include <volccd/io/contacts_vtp.hpp>

#include <algorithm>
#include <bit>
#include <cstring>

#include <fmt/format.h>

namespace volccd {

namespace {

/// Arrays in the file's appended section, and their descriptions.
class AppendedArrays {
 public:
  /// `values(row, component)` of each of `rows`.
  template <class T, class Values>
  std::string add(const char* type, const char* name, std::size_t rows, std::size_t components, Values&& values) {
    const std::string tag = fmt::format(
        "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n", type,
        name, components, bytes_.size());
    append(static_cast<std::uint64_t>(rows * components * sizeof(T)));
    for (std::size_t row = 0; row < rows; ++row)
      for (std::size_t c = 0; c < components; ++c) append(static_cast<T>(values(row, c)));
    return tag;
  }
  const std::string& bytes() const { return bytes_; }

 private:
  template <class T>
  void append(T value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes_.append(raw, sizeof value);
  }

  std::string bytes_;
};

/// The description of all point data; the arrays themselves go to `arrays`.
std::string point_data(const std::vector<ContactRow>& rows, const std::vector<double>& times, AppendedArrays& arrays) {
  const std::size_t n = rows.size();
  std::string text = "<PointData Normals=\"Normal\">\n";
  text += arrays.add<double>("Float64", "Normal", n, 3,
                             [&](std::size_t i, std::size_t c) { return rows[i].normal[static_cast<int>(c)]; });
  text += arrays.add<std::int32_t>("Int32", "Step", n, 1, [&](std::size_t i, std::size_t) { return rows[i].step; });
  text += arrays.add<double>("Float64", "TimeOfImpact", n, 1, [&](std::size_t i, std::size_t) { return rows[i].toi; });
  text += arrays.add<double>("Float64", "Time", n, 1, [&](std::size_t i, std::size_t) { return times[i]; });
  text += arrays.add<std::uint8_t>("UInt8", "Kind", n, 1,
                                   [&](std::size_t i, std::size_t) { return rows[i].kind == FeatureKind::vf ? 0 : 1; });
  text += arrays.add<std::uint8_t>("UInt8", "AtStart", n, 1,
                                   [&](std::size_t i, std::size_t) { return rows[i].at_start ? 1 : 0; });
  for (const std::size_t side : {0, 1}) {
    const std::string number = std::to_string(side + 1);
    text += arrays.add<std::int64_t>("Int64", ("Part" + number).c_str(), n, 1,
                                     [&](std::size_t i, std::size_t) { return rows[i].sides[side].part; });
    text += arrays.add<std::int64_t>("Int64", ("Element" + number).c_str(), n, 1,
                                     [&](std::size_t i, std::size_t) { return rows[i].sides[side].element; });
  }
  text += arrays.add<std::int64_t>("Int64", "VertexIds", n, 4,
                                   [&](std::size_t i, std::size_t c) { return rows[i].ids[c]; });
  return text + "</PointData>\n";
}

}  // namespace

ContactsVtpWriter::ContactsVtpWriter(const std::string& file) : output_(file) {}

void ContactsVtpWriter::write_step(int step, double begin_time, double end_time, std::span<const Contact> contacts,
                                   const Mesh& mesh) {
  const std::size_t first = rows_.size();
  for (const Contact& contact : contacts) rows_.push_back(contact_row(step, contact, mesh));
  std::sort(rows_.begin() + static_cast<std::ptrdiff_t>(first), rows_.end(),
            [](const ContactRow& x, const ContactRow& y) { return canonical_less(x, y); });
  for (std::size_t i = first; i < rows_.size(); ++i)
    times_.push_back(begin_time + rows_[i].toi * (end_time - begin_time));
}

void ContactsVtpWriter::write(const std::string& comment) {
  const std::size_t n = rows_.size();
  AppendedArrays arrays;
  std::string text = "<?xml version=\"1.0\"?>\n" + comment;
  text += fmt::format(
      "<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"{}\" header_type=\"UInt64\">\n<PolyData>\n"
      "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
      "NumberOfPolys=\"0\">\n",
      std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian", n, n);
  text += point_data(rows_, times_, arrays);
  text += "<Points>\n" + arrays.add<double>("Float64", "Points", n, 3, [&](std::size_t i, std::size_t c) {
    return rows_[i].point[static_cast<int>(c)];
  }) + "</Points>\n<Verts>\n";
  text += arrays.add<std::int64_t>("Int64", "connectivity", n, 1, [](std::size_t i, std::size_t) { return i; });
  text += arrays.add<std::int64_t>("Int64", "offsets", n, 1, [](std::size_t i, std::size_t) { return i + 1; });
  text += "</Verts>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
  output_.write(text);
  output_.write(arrays.bytes());
  output_.write("\n</AppendedData>\n</VTKFile>\n");
  output_.commit();
}

void ContactsVtpWriter::finish() { write(""); }

StepsDone ContactsVtpWriter::finish_incomplete(const StepsDone& steps) {
  // The contacts of an incomplete step are removed.
  const auto begun =
      std::find_if(rows_.begin(), rows_.end(), [&](const ContactRow& row) { return row.step >= steps.done; });
  rows_.erase(begun, rows_.end());
  times_.resize(rows_.size());
  std::string text = steps.text();
  for (std::size_t at = 0; (at = text.find("--", at)) != std::string::npos;)
    text.replace(at, 2, "- ");  // "--" may not occur in a comment
  write("<!-- incomplete: " + text + " -->\n");
  return steps;
}

}  // namespace volccd
