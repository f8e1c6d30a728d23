#include <volccd/io/contacts_csv.hpp>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>
#include <tuple>
#include <utility>

#include <volccd/core/error.hpp>

namespace volccd {

namespace {

constexpr std::string_view kHeader =
    "step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz,at_start,object_1,object_2,element_1,element_2";

/// A header that can be read, and which columns after toi it has.
struct HeaderInfo {
  std::string_view text;
  bool geometry, at_start, sides;
};

constexpr HeaderInfo kHeaders[] = {
    {kHeader, true, true, true},
    {"step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz,at_start,part_1,part_2,element_1,element_2", true, true, true},
    {"step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz,at_start", true, true, false},
    {"step,kind,a,b,c,d,toi,nx,ny,nz,px,py,pz", true, false, false},
    {"step,kind,a,b,c,d,toi", false, false, false}};

const HeaderInfo* find_header(std::string_view text) {
  for (const HeaderInfo& header : kHeaders)
    if (header.text == text) return &header;
  return nullptr;
}

}  // namespace

bool canonical_less(const ContactRow& x, const ContactRow& y) {
  return std::tie(x.step, x.kind, x.ids) < std::tie(y.step, y.kind, y.ids);
}

ContactRow contact_row(int step, const Contact& contact, const Mesh& mesh) {
  ContactRow row{step,        contact.kind,     {},
                 contact.toi, contact.normal,   contact.point,
                 true,        contact.at_start, contact_sides(contact, mesh)};
  for (std::size_t i = 0; i < 4; ++i) row.ids[i] = mesh.vertex_id(contact.vertices[i]);
  return row;
}

struct ContactsCsvWriter::Impl {
  explicit Impl(const std::string& name) : lines(name, kHeader) {}

  StepTextWriter lines;
  std::vector<ContactRow> rows;
  std::string text;  ///< of a step
};

std::string contacts_csv_header() {
  std::string header(kHeader);
  header.push_back('\n');
  return header;
}

void append_csv_row(const ContactRow& row, const std::string& file, std::string& text) {
  const Vec3 &n = row.normal, &p = row.point;
  if (!std::isfinite(row.toi) || !n.allFinite() || !p.allFinite())
    throw InputError(file, "", "a contact of step " + std::to_string(row.step) + " is not finite");
  text += std::to_string(row.step) + (row.kind == FeatureKind::vf ? ",VF" : ",EE");
  for (const std::int64_t id : row.ids) text += "," + std::to_string(id);
  for (const double value : {row.toi, n.x(), n.y(), n.z(), p.x(), p.y(), p.z()}) {
    // As printf's %.17g, but with a point in every locale.
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value, std::chars_format::general, 17).ptr;
    text.append(",").append(digits, end);
  }
  text += row.at_start ? ",1" : ",0";
  for (const ContactSide& side : row.sides) text += "," + std::to_string(side.object);
  for (const ContactSide& side : row.sides) text += "," + std::to_string(side.element);
  text += "\n";
}

ContactsCsvWriter::ContactsCsvWriter(const std::string& file) : impl_(std::make_unique<Impl>(file)) {}
ContactsCsvWriter::ContactsCsvWriter(ContactsCsvWriter&&) noexcept = default;
ContactsCsvWriter::~ContactsCsvWriter() = default;

void ContactsCsvWriter::write_step(int step, std::span<const Contact> contacts, const Mesh& mesh) {
  Impl& o = *impl_;
  o.rows.clear();
  for (const Contact& contact : contacts) o.rows.push_back(contact_row(step, contact, mesh));
  std::sort(o.rows.begin(), o.rows.end(),
            [](const ContactRow& x, const ContactRow& y) { return canonical_less(x, y); });
  o.text.clear();
  for (const ContactRow& row : o.rows) append_csv_row(row, o.lines.file(), o.text);
  o.lines.write_step(step, o.text);
}

void ContactsCsvWriter::finish() { impl_->lines.finish(); }

StepsDone ContactsCsvWriter::finish_incomplete(const StepsDone& steps) { return impl_->lines.finish_incomplete(steps); }

namespace {

/// Parses and checks a line.
class RowParser {
 public:
  RowParser(const std::string& file, std::int64_t line, std::string_view text)
      : file_(file), line_(line), rest_(text) {}

  ContactRow parse(const HeaderInfo& header) {
    ContactRow row;
    row.step = integer("step");
    if (row.step < 0) fail("the step is negative");
    const std::string_view kind = field();
    if (kind != "VF" && kind != "EE") fail("the kind is neither VF nor EE");
    row.kind = kind == "VF" ? FeatureKind::vf : FeatureKind::ee;
    for (std::int64_t& id : row.ids) id = integer("vertex id");
    check_ids(row);
    row.toi = number("toi");
    if (row.toi < 0 || row.toi > 1) fail("the toi is outside [0, 1]");
    row.has_geometry = header.geometry;
    if (header.geometry) {
      for (int i = 0; i < 3; ++i) row.normal[i] = number("normal");
      for (int i = 0; i < 3; ++i) row.point[i] = number("point");
    }
    if (header.at_start) {
      const std::string_view flag = field();
      if (flag != "0" && flag != "1") fail("at_start is neither 0 nor 1");
      row.at_start = flag == "1";
    }
    if (header.sides) {
      for (ContactSide& side : row.sides) side.object = integer("object");
      for (ContactSide& side : row.sides) side.element = element();
    }
    if (!at_end_) fail("has too many fields");
    return row;
  }

 private:
  [[noreturn]] void fail(const std::string& problem) const { throw InputError(file_, "line", line_, problem); }

  std::string_view field() {
    if (at_end_) fail("has too few fields");
    const std::size_t comma = rest_.find(',');
    const std::string_view text = rest_.substr(0, comma);
    at_end_ = comma == std::string_view::npos;
    if (!at_end_) rest_.remove_prefix(comma + 1);
    return text;
  }

  template <class T>
  T value(const char* what) {
    const std::string_view text = field();
    T result{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), result);
    if (error != std::errc{} || end != text.data() + text.size())
      fail(std::string("the ") + what + " \"" + std::string(text) + "\" is not a number");
    return result;
  }
  std::int64_t integer(const char* what) { return value<std::int64_t>(what); }
  std::int64_t element() {
    const std::int64_t id = integer("element");
    if (id < -1) fail("the element is below -1");
    return id;
  }
  double number(const char* what) {
    const double result = value<double>(what);
    if (!std::isfinite(result)) fail(std::string("the ") + what + " is not finite");
    return result;
  }

  void check_ids(const ContactRow& row) const {
    const auto [a, b, c, d] = row.ids;
    const bool ordered = row.kind == FeatureKind::vf ? b < c && c < d : a < b && c < d && (a < c || (a == c && b < d));
    if (!ordered) fail("the vertex ids are not in canonical order");
    if (a == b || a == c || a == d || b == c || b == d) fail("the two features have a common vertex");
    if (a < 0 || b < 0 || c < 0) fail("a vertex id is negative");
  }

  const std::string& file_;
  std::int64_t line_;
  std::string_view rest_;
  bool at_end_ = false;
};

}  // namespace

std::vector<ContactRow> read_contacts_csv(const std::string& file, std::string* incomplete) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored))
    throw InputError(file, "", "cannot be opened: it is not there, or not a file");
  std::ifstream stream(file);
  if (!stream) throw InputError(file, "", std::string("cannot be opened: ") + std::strerror(errno));
  if (incomplete) incomplete->clear();
  std::vector<ContactRow> rows;
  std::string text;
  const HeaderInfo* header = nullptr;
  bool marked = false;
  std::int64_t line = 1;
  for (; std::getline(stream, text); ++line) {
    if (stream.eof()) throw InputError(file, "line", line, "is cut short: it has no end");
    if (!text.empty() && text.back() == '\r') text.pop_back();
    if (marked) throw InputError(file, "line", line, "follows the line that marks the file as incomplete");
    if (line == 1) {
      header = find_header(text);
      if (!header) throw InputError(file, "line", line, "is not the header \"" + std::string(kHeader) + "\"");
    } else if (text.starts_with(kIncompleteMark)) {
      marked = true;
      const std::string mark = text.substr(kIncompleteMark.size());
      if (!incomplete)
        throw InputError(file, "line", line,
                         "marks the file as incomplete (" + mark +
                             "): compute the contacts again, or "
                             "remove the line to use the steps that there are");
      *incomplete = mark;
    } else {
      rows.push_back(RowParser(file, line, text).parse(*header));
    }
  }
  if (stream.bad()) throw InputError(file, "", std::string("cannot be read: ") + std::strerror(errno));
  if (line == 1) throw InputError(file, "line", 1, "is missing: the file is empty");
  return rows;
}

}  // namespace volccd
