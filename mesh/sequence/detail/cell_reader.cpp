#include <volccd/mesh/sequence/detail/cell_reader.hpp>

#include <algorithm>
#include <limits>
#include <numeric>
#include <string>

#include <volccd/mesh/detail/check_element.hpp>

namespace volccd::detail {

namespace {

using std::to_string;

std::string in_step(std::size_t step) { return " (step " + to_string(step) + ")"; }

}  // namespace

std::string CellReader::place(std::size_t step, std::size_t i, const SequenceCells& cells) {
  return " (cell id " + to_string(cells.ids[i]) + ", step " + to_string(step) + ")";
}

std::string CellReader::place(std::size_t step, std::size_t i) const {
  std::vector<std::int64_t> id{static_cast<std::int64_t>(i)};
  if (layout_.cell_ids) layout_.cell_ids->data.read(layout_.cell_ids->first[step] + id[0], 1, id);
  return " (cell id " + to_string(id[0]) + ", step " + to_string(step) + ")";
}

bool CellReader::same(std::size_t step, std::size_t other) const {
  const auto same_rows = [&](const StepArray& array) { return array.first[step] == array.first[other]; };
  const auto same_data = [&](const std::optional<StepArray>& array) { return !array || same_rows(*array); };
  if (layout_.topology[step] != layout_.topology[other] || !same_rows(layout_.types) ||
      !same_rows(layout_.connectivity) || !same_data(layout_.cell_ids) || !same_data(layout_.part_ids))
    return false;
  return !layout_.polyhedra || (same_rows(layout_.polyhedra->face_connectivity) &&
                                same_rows(layout_.polyhedra->face_offsets) && same_rows(layout_.polyhedra->to_faces));
}

void CellReader::read(std::size_t step, SequenceCells& cells) {
  cells.clear();
  read_ids(step, cells);  // first, so that the errors of the other arrays can name the cell
  read_types(step, cells);
  read_offsets(step, cells);
  read_connectivity(step, cells);
  read_parts(step, cells);
  read_polyhedra(step, cells);
  collapse(step, cells);
}

void CellReader::read_types(std::size_t step, SequenceCells& cells) {
  const StepArray& array = layout_.types;
  const std::int64_t first = array.first[step];
  array.data.read(first, layout_.cells[static_cast<std::size_t>(layout_.topology[step])], numbers_);
  cells.types.resize(numbers_.size());
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    const std::int64_t type = numbers_[i];
    if (type < 0 || type > 255 || !is_element_type(static_cast<int>(type)))
      array.data.fail(first + static_cast<std::int64_t>(i),
                      "the cell type " + to_string(type) + " is not known" + place(step, i, cells));
    cells.types[i] = static_cast<ElementType>(type);
  }
}

void CellReader::read_monotone(const StepArray& array, std::size_t step, std::int64_t count, std::int64_t length,
                               std::vector<std::int64_t>& out) {
  const std::int64_t first = array.first[step];
  array.data.read(first, count + 1, out);
  if (out[0] != 0)
    array.data.fail(first, "the offsets of a topology start at " + to_string(out[0]) + ", not at 0" + in_step(step));
  for (std::size_t i = 1; i < out.size(); ++i)
    if (out[i] < out[i - 1] || out[i] > length)
      array.data.fail(first + static_cast<std::int64_t>(i), "the offset " + to_string(out[i]) +
                                                                " is less than the one before, or more than " +
                                                                to_string(length) + in_step(step));
  if (out.back() != length)
    array.data.fail(first + count,
                    "the last offset is " + to_string(out.back()) + ", not " + to_string(length) + in_step(step));
}

void CellReader::read_offsets(std::size_t step, SequenceCells& cells) {
  const StepArray& array = layout_.offsets;
  const std::size_t b = static_cast<std::size_t>(layout_.topology[step]);
  read_monotone(array, step, layout_.cells[b], layout_.connectivity_ids[b], numbers_);
  cells.offsets.assign(numbers_.begin(), numbers_.end());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::int64_t length = numbers_[i + 1] - numbers_[i];
    const ElementType type = cells.types[i];
    const bool right = type == ElementType::polytope ? length >= 4 : length == vertex_count(type);
    if (!right)
      array.data.fail(array.first[step] + static_cast<std::int64_t>(i) + 1,
                      "cell " + to_string(i) + " is a " + to_string(type) + " with " + to_string(length) + " points" +
                          place(step, i, cells));
  }
}

template <class Place>
Index CellReader::slot(const StepArray& array, std::int64_t row, std::int64_t value, const Place& place) const {
  if (value < 0 || value >= layout_.points)
    array.data.fail(
        row, "the point " + to_string(value) + " is out of range, there are " + to_string(layout_.points) + place());
  return order_.slots()[static_cast<std::size_t>(value)];
}

void CellReader::read_connectivity(std::size_t step, SequenceCells& cells) {
  const StepArray& array = layout_.connectivity;
  const std::int64_t first = array.first[step];
  array.data.read(first, static_cast<std::int64_t>(cells.offsets.back()), numbers_);
  cells.connectivity.resize(numbers_.size());
  repeated_.clear();
  // used_[v] == i + 1 means that vertex v occurs in cell i.
  used_.assign(order_.slots().size(), 0);
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (std::size_t j = cells.offsets[i]; j < cells.offsets[i + 1]; ++j) {
      const std::int64_t row = first + static_cast<std::int64_t>(j);
      const Index v = slot(array, row, numbers_[j], [&] { return place(step, i, cells); });
      if (used_[v] == i + 1) {
        if (cells.types[i] == ElementType::polytope)
          array.data.fail(row, "cell " + to_string(i) + " is a polyhedron that has the point id " +
                                   to_string(order_.ids()[v]) + " twice" + place(step, i, cells));
        if (repeated_.empty() || repeated_.back().cell != i) repeated_.push_back({i, row});
      }
      used_[v] = static_cast<Index>(i + 1);
      cells.connectivity[j] = v;
    }
}

CollapsedElement CellReader::collapsed_element(std::size_t step, const Repeated& repeated,
                                               const SequenceCells& cells) const {
  const std::size_t i = repeated.cell;
  CollapsedElement element = collapse_element(cells.types[i], cells.vertices(i));
  if (element.type != ElementType::none) return element;
  std::string ids;
  for (const Index v : cells.vertices(i)) ids += " " + to_string(order_.ids()[v]);
  layout_.connectivity.data.fail(repeated.row, "cell " + to_string(i) + " is a " + to_string(cells.types[i]) +
                                                   " whose points repeat, and no element is left: " + element.problem +
                                                   "; its point ids are" + ids + place(step, i, cells));
}

void CellReader::collapse(std::size_t step, SequenceCells& cells) {
  collapsed_counts_.clear();
  if (repeated_.empty()) return;
  SequenceCells result;
  auto next = repeated_.begin();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    ElementSpec spec = cells.spec(i);
    if (next != repeated_.end() && next->cell == i) {
      CollapsedElement element = collapsed_element(step, *next++, cells);
      ++collapsed_counts_[{spec.type, element.type}];
      spec.type = element.type;
      spec.vertices = std::move(element.vertices);
      spec.faces = std::move(element.faces);
    }
    result.add(spec);
  }
  cells = std::move(result);
}

void CellReader::read_parts(std::size_t step, SequenceCells& cells) {
  cells.parts.assign(cells.size(), 0);
  if (!layout_.part_ids) return;
  const StepArray& array = *layout_.part_ids;
  const std::int64_t first = array.first[step];
  array.data.read(first, static_cast<std::int64_t>(cells.size()), numbers_);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (numbers_[i] < std::numeric_limits<std::int32_t>::min() ||
        numbers_[i] > std::numeric_limits<std::int32_t>::max())
      array.data.fail(first + static_cast<std::int64_t>(i),
                      "the part id " + to_string(numbers_[i]) + " exceeds 32 bits" + place(step, i, cells));
    cells.parts[i] = static_cast<std::int32_t>(numbers_[i]);
  }
}

void CellReader::read_ids(std::size_t step, SequenceCells& cells) {
  const std::int64_t count = layout_.cells[static_cast<std::size_t>(layout_.topology[step])];
  cells.ids.resize(static_cast<std::size_t>(count));
  if (!layout_.cell_ids) {
    std::iota(cells.ids.begin(), cells.ids.end(), std::int64_t{0});
    return;
  }
  const StepArray& array = *layout_.cell_ids;
  const std::int64_t first = array.first[step];
  array.data.read(first, count, cells.ids);
  for (std::size_t i = 0; i < cells.ids.size(); ++i)
    if (cells.ids[i] < 0)
      array.data.fail(first + static_cast<std::int64_t>(i),
                      "the id is negative: " + to_string(cells.ids[i]) + in_step(step));
  sorted_ids_ = cells.ids;
  std::sort(sorted_ids_.begin(), sorted_ids_.end());
  const auto twice = std::adjacent_find(sorted_ids_.begin(), sorted_ids_.end());
  if (twice == sorted_ids_.end()) return;
  const auto one = std::find(cells.ids.begin(), cells.ids.end(), *twice);
  const auto other = std::find(one + 1, cells.ids.end(), *twice);
  array.data.fail(first + (other - cells.ids.begin()),
                  "the id " + to_string(*twice) + " is there twice" + in_step(step));
}

void CellReader::read_polyhedra(std::size_t step, SequenceCells& cells) {
  const std::size_t b = static_cast<std::size_t>(layout_.topology[step]);
  const auto first_polytope = std::find(cells.types.begin(), cells.types.end(), ElementType::polytope);
  const bool any = first_polytope != cells.types.end();
  // Faces are also checked if there should be none.
  if (!any && (!layout_.polyhedra || layout_.polyhedra->to_face_ids[b] == 0)) return;
  if (!layout_.polyhedra)
    layout_.types.data.fail(layout_.types.first[step] + (first_polytope - cells.types.begin()),
                            "is a polyhedron, but VTKHDF/FaceConnectivity and the other arrays of faces are missing" +
                                place(step, static_cast<std::size_t>(first_polytope - cells.types.begin()), cells));
  const PolyhedronLayout& polyhedra = *layout_.polyhedra;
  read_monotone(polyhedra.face_offsets, step, polyhedra.faces[b], polyhedra.face_connectivity_ids[b], face_offsets_);
  read_monotone(polyhedra.offsets, step, layout_.cells[b], polyhedra.to_face_ids[b], cell_faces_);
  polyhedra.face_connectivity.data.read(polyhedra.face_connectivity.first[step], polyhedra.face_connectivity_ids[b],
                                        face_connectivity_);
  polyhedra.to_faces.data.read(polyhedra.to_faces.first[step], polyhedra.to_face_ids[b], to_faces_);
  cells.face_offsets.assign(1, 0);
  face_uses_.assign(face_offsets_.size() - 1, 0);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (cells.types[i] == ElementType::polytope) {
      append_polyhedron(step, i, cells);
    } else if (cell_faces_[i] != cell_faces_[i + 1]) {
      polyhedra.offsets.data.fail(polyhedra.offsets.first[step] + static_cast<std::int64_t>(i) + 1,
                                  "cell " + to_string(i) + " is no polyhedron but has faces" + place(step, i, cells));
    }
    cells.face_offsets.push_back(cells.faces.size());
    if (cells.types[i] != ElementType::polytope) continue;
    if (const std::string problem = element_problem(cells.spec(i), static_cast<Index>(layout_.points), order_.ids());
        !problem.empty())
      polyhedra.offsets.data.fail(polyhedra.offsets.first[step] + static_cast<std::int64_t>(i),
                                  "cell " + to_string(i) + ": " + problem + place(step, i, cells));
  }
}

void CellReader::append_polyhedron(std::size_t step, std::size_t cell, SequenceCells& cells) {
  const PolyhedronLayout& polyhedra = *layout_.polyhedra;
  const std::int64_t face_count = static_cast<std::int64_t>(face_offsets_.size()) - 1;
  for (std::int64_t j = cell_faces_[cell]; j < cell_faces_[cell + 1]; ++j) {
    const std::int64_t face = to_faces_[static_cast<std::size_t>(j)];
    if (face < 0 || face >= face_count)
      polyhedra.to_faces.data.fail(polyhedra.to_faces.first[step] + j,
                                   "the face " + to_string(face) + " is out of range, there are " +
                                       to_string(face_count) + place(step, cell, cells));
    // This check also limits the memory: faces that are referenced many times could expand without bound.
    if (++face_uses_[static_cast<std::size_t>(face)] > 2)
      polyhedra.to_faces.data.fail(
          polyhedra.to_faces.first[step] + j,
          "the face " + to_string(face) + " belongs to more than two polyhedra" + place(step, cell, cells));
    const std::int64_t begin = face_offsets_[static_cast<std::size_t>(face)];
    const std::int64_t end = face_offsets_[static_cast<std::size_t>(face) + 1];
    if (end - begin > layout_.points)
      polyhedra.face_offsets.data.fail(polyhedra.face_offsets.first[step] + face + 1,
                                       "a face has more points than there are" + place(step, cell, cells));
    cells.faces.push_back(static_cast<Index>(end - begin));
    for (std::int64_t i = begin; i < end; ++i)
      cells.faces.push_back(slot(polyhedra.face_connectivity, polyhedra.face_connectivity.first[step] + i,
                                 face_connectivity_[static_cast<std::size_t>(i)],
                                 [&] { return place(step, cell, cells); }));
  }
}

}  // namespace volccd::detail
