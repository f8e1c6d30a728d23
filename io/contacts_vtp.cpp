#include <volccd/io/contacts_vtp.hpp>

#include <algorithm>

#include <fmt/format.h>

#include <volccd/io/detail/appended_arrays.hpp>

namespace volccd {

namespace {

using detail::AppendedArrays;

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
    text += arrays.add<std::int64_t>("Int64", ("Object" + number).c_str(), n, 1,
                                     [&](std::size_t i, std::size_t) { return rows[i].sides[side].object; });
    text += arrays.add<std::int64_t>("Int64", ("Element" + number).c_str(), n, 1,
                                     [&](std::size_t i, std::size_t) { return rows[i].sides[side].element; });
  }
  text += arrays.add<std::int64_t>("Int64", "VertexIds", n, 4,
                                   [&](std::size_t i, std::size_t c) { return rows[i].ids[c]; });
  return text + "</PointData>\n";
}

}  // namespace

std::string detail::incomplete_comment(std::string text) {
  for (std::size_t at = 0; (at = text.find("--", at)) != std::string::npos;) text.replace(at, 2, "- ");
  return "<!-- incomplete: " + text + " -->\n";
}

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
  std::string text = detail::polydata_head(comment);
  text += fmt::format(
      "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" "
      "NumberOfPolys=\"0\">\n",
      n, n);
  text += point_data(rows_, times_, arrays);
  text += "<Points>\n" + arrays.add<double>("Float64", "Points", n, 3, [&](std::size_t i, std::size_t c) {
    return rows_[i].point[static_cast<int>(c)];
  }) + "</Points>\n<Verts>\n";
  text += arrays.add<std::int64_t>("Int64", "connectivity", n, 1, [](std::size_t i, std::size_t) { return i; });
  text += arrays.add<std::int64_t>("Int64", "offsets", n, 1, [](std::size_t i, std::size_t) { return i + 1; });
  output_.write(text + "</Verts>\n" + detail::kPolydataArrays);
  output_.write(arrays.bytes());
  output_.write(detail::kPolydataEnd);
  output_.commit();
}

void ContactsVtpWriter::finish() { write(""); }

StepsDone ContactsVtpWriter::finish_incomplete(const StepsDone& steps) {
  // The contacts of an incomplete step are removed.
  const auto begun =
      std::find_if(rows_.begin(), rows_.end(), [&](const ContactRow& row) { return row.step >= steps.done; });
  rows_.erase(begun, rows_.end());
  times_.resize(rows_.size());
  write(detail::incomplete_comment(steps.text()));
  return steps;
}

}  // namespace volccd
