#include <volccd/io/sequence/detail/cell_reader.hpp>

#include <algorithm>
#include <cassert>
#include <numeric>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <volccd/io/sequence/detail/frame_check.hpp>
#include <volccd/mesh/check_element.hpp>

namespace volccd::detail {

void CellReader::fail(const FrameArray& array, std::size_t row, std::size_t cell, const SequenceCells& cells,
                      const std::string& problem) const {
  const std::int64_t skipped = &array == &layout_.connectivity ? first_connectivity_ : first_;
  array.fail(frame_, static_cast<std::size_t>(skipped) + row,
             fmt::format("{} (cell id {}, frame {})", problem, cells.ids[cell], frame_));
}

std::string CellReader::place(std::size_t frame, std::size_t i) const {
  std::vector<std::int64_t> id{static_cast<std::int64_t>(i)};
  if (layout_.cell_ids) layout_.cell_ids->data.read(layout_.cell_ids->first[frame] + id[0], 1, id);
  return fmt::format(" (cell id {}, frame {})", id[0], frame);
}

bool CellReader::have_same_cells(std::size_t frame, std::size_t other) const {
  const auto same_rows = [&](const FrameArray& array) { return array.first[frame] == array.first[other]; };
  const auto same_data = [&](const std::optional<FrameArray>& array) { return !array || same_rows(*array); };
  if (layout_.topology[frame] != layout_.topology[other] || !same_rows(layout_.types) ||
      !same_rows(layout_.connectivity) || !same_data(layout_.cell_ids) || !same_data(layout_.part_ids))
    return false;
  return !layout_.polyhedra || (same_rows(layout_.polyhedra->face_connectivity) &&
                                same_rows(layout_.polyhedra->face_offsets) && same_rows(layout_.polyhedra->to_faces));
}

void CellReader::read_part(std::size_t frame, std::int64_t first, std::int64_t count, SequenceCells& cells) {
  assert(count == layout_.cells_of(frame) || !layout_.polyhedra);
  frame_ = frame;
  first_ = first;
  count_ = count;
  cells.clear();
  read_ids(cells);  // first, so that the errors of the other arrays can name the cell
  read_types(cells);
  read_offsets(cells);
  read_connectivity(cells);
  read_objects(cells);
  read_polyhedra(cells);
  collapse(cells);
}

void CellReader::read_types(SequenceCells& cells) {
  layout_.types.read_part(frame_, first_, count_, numbers_);
  cells.types.resize(numbers_.size());
  for (std::size_t i = 0; i < numbers_.size(); ++i) {
    if (!is_element_type(numbers_[i]))
      fail(layout_.types, i, i, cells, fmt::format("the cell type {} is not known", numbers_[i]));
    cells.types[i] = static_cast<ElementType>(numbers_[i]);
  }
}

void CellReader::read_monotone(const FrameArray& array, std::int64_t first, std::int64_t count, std::int64_t all,
                               std::int64_t length, std::vector<std::int64_t>& out) const {
  const auto refuse = [&](std::size_t i, const std::string& problem) {
    array.fail(frame_, static_cast<std::size_t>(first) + i, fmt::format("{} (frame {})", problem, frame_));
  };
  array.read_part(frame_, first, count + 1, out);
  if (first == 0 && out[0] != 0) refuse(0, fmt::format("the offsets of a topology start at {}, not at 0", out[0]));
  if (out[0] < 0 || out[0] > length)
    refuse(0, fmt::format("the offset {} is negative, or more than {}", out[0], length));
  for (std::size_t i = 1; i < out.size(); ++i)
    if (out[i] < out[i - 1] || out[i] > length)
      refuse(i, fmt::format("the offset {} is less than the one before, or more than {}", out[i], length));
  if (first + count == all && out.back() != length)
    refuse(out.size() - 1, fmt::format("the last offset is {}, not {}", out.back(), length));
}

void CellReader::read_offsets(SequenceCells& cells) {
  const std::size_t b = layout_.topology_of(frame_);
  read_monotone(layout_.offsets, first_, count_, layout_.cells[b], layout_.connectivity_ids[b], numbers_);
  first_connectivity_ = numbers_.front();
  cells.offsets.clear();
  for (const std::int64_t offset : numbers_)
    cells.offsets.push_back(static_cast<std::size_t>(offset - first_connectivity_));
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::int64_t length = numbers_[i + 1] - numbers_[i];
    const ElementType type = cells.types[i];
    if (type == ElementType::polytope ? length < 4 : length != vertex_count(type))
      fail(layout_.offsets, i + 1, i, cells,
           fmt::format("cell {} is a {} with {} points", number(i), to_string(type), length));
  }
}

Index CellReader::slot(const FrameArray& array, std::size_t row, std::int64_t point, std::size_t cell,
                       const SequenceCells& cells) const {
  if (point < 0 || point >= layout_.points)
    fail(array, row, cell, cells, fmt::format("the point {} is out of range, there are {}", point, layout_.points));
  return order_.slots()[static_cast<std::size_t>(point)];
}

void CellReader::read_connectivity(SequenceCells& cells) {
  const FrameArray& array = layout_.connectivity;
  array.read_part(frame_, first_connectivity_, static_cast<std::int64_t>(cells.offsets.back()), numbers_);
  cells.connectivity.resize(numbers_.size());
  repeated_.clear();
  // used_[v] == i + 1 means that vertex v occurs in cell i.
  used_.assign(order_.slots().size(), 0);
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (std::size_t j = cells.offsets[i]; j < cells.offsets[i + 1]; ++j) {
      const Index v = slot(array, j, numbers_[j], i, cells);
      if (used_[v] == i + 1) {
        if (cells.types[i] == ElementType::polytope)
          fail(array, j, i, cells,
               fmt::format("cell {} is a polyhedron that has the point id {} twice", number(i), order_.ids()[v]));
        if (repeated_.empty() || repeated_.back().cell != i) repeated_.push_back({i, j});
      }
      used_[v] = static_cast<Index>(i + 1);
      cells.connectivity[j] = v;
    }
}

void CellReader::collapse(SequenceCells& cells) {
  collapsed_counts_.clear();
  if (repeated_.empty()) return;
  SequenceCells result;
  auto next = repeated_.begin();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    ElementSpec spec = cells.spec(i);
    if (next != repeated_.end() && next->cell == i) {
      CollapsedElement element = collapse_element(spec.type, spec.vertices);
      if (element.type == ElementType::none) {
        std::string ids;
        for (const Index v : spec.vertices) ids += fmt::format(" {}", order_.ids()[v]);
        fail(layout_.connectivity, next->row, i, cells,
             fmt::format("cell {} is a {} whose points repeat, and no element is left: {}; its point ids are{}",
                         number(i), to_string(spec.type), element.problem, ids));
      }
      ++next;
      ++collapsed_counts_[{spec.type, element.type}];
      spec.type = element.type;
      spec.vertices = std::move(element.vertices);
      spec.faces = std::move(element.faces);
    }
    result.add(spec);
  }
  cells = std::move(result);
}

void CellReader::read_objects(SequenceCells& cells) {
  cells.objects.assign(cells.size(), 0);
  if (!layout_.part_ids) return;
  layout_.part_ids->read_part(frame_, first_, count_, numbers_);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    cells.objects[i] = static_cast<std::int32_t>(numbers_[i]);
    if (cells.objects[i] != numbers_[i])
      fail(*layout_.part_ids, i, i, cells, fmt::format("the object {} exceeds 32 bits", numbers_[i]));
  }
}

void CellReader::read_ids(SequenceCells& cells) {
  if (!layout_.cell_ids) {
    cells.ids.resize(static_cast<std::size_t>(count_));
    std::iota(cells.ids.begin(), cells.ids.end(), first_);
    return;
  }
  layout_.cell_ids->read_part(frame_, first_, count_, cells.ids);
  if (const std::optional<WrongId> wrong = find_wrong_id(cells.ids))
    layout_.cell_ids->fail(frame_, static_cast<std::size_t>(first_) + wrong->index,
                           fmt::format("{} (frame {})", wrong->problem, frame_));
}

void CellReader::read_polyhedra(SequenceCells& cells) {
  const std::size_t b = layout_.topology_of(frame_);
  const auto first = static_cast<std::size_t>(std::find(cells.types.begin(), cells.types.end(), ElementType::polytope) -
                                              cells.types.begin());
  // Faces are also checked if there should be none.
  if (first == cells.size() && (!layout_.polyhedra || layout_.polyhedra->to_face_ids[b] == 0)) return;
  if (!layout_.polyhedra)
    fail(layout_.types, first, first, cells,
         "is a polyhedron, but VTKHDF/FaceConnectivity and the other arrays of faces are missing");
  const PolyhedronLayout& polyhedra = *layout_.polyhedra;
  read_monotone(polyhedra.face_offsets, 0, polyhedra.faces[b], polyhedra.faces[b], polyhedra.face_connectivity_ids[b],
                face_offsets_);
  read_monotone(polyhedra.offsets, 0, layout_.cells[b], layout_.cells[b], polyhedra.to_face_ids[b], cell_faces_);
  polyhedra.face_connectivity.read(frame_, polyhedra.face_connectivity_ids[b], face_connectivity_);
  polyhedra.to_faces.read(frame_, polyhedra.to_face_ids[b], to_faces_);
  cells.face_offsets.assign(1, 0);
  face_uses_.assign(face_offsets_.size() - 1, 0);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool polytope = cells.types[i] == ElementType::polytope;
    if (polytope) append_polyhedron(i, cells);
    if (!polytope && cell_faces_[i] != cell_faces_[i + 1])
      fail(polyhedra.offsets, i + 1, i, cells, fmt::format("cell {} is no polyhedron but has faces", i));
    cells.face_offsets.push_back(cells.faces.size());
    if (!polytope) continue;
    const std::string problem = element_problem(cells.spec(i), static_cast<Index>(layout_.points), order_.ids());
    if (!problem.empty()) fail(polyhedra.offsets, i, i, cells, fmt::format("cell {}: {}", i, problem));
  }
}

void CellReader::append_polyhedron(std::size_t cell, SequenceCells& cells) {
  const PolyhedronLayout& polyhedra = *layout_.polyhedra;
  for (auto j = static_cast<std::size_t>(cell_faces_[cell]); std::cmp_less(j, cell_faces_[cell + 1]); ++j) {
    const auto face = static_cast<std::size_t>(to_faces_[j]);  // negative numbers are out of range, too
    if (face >= face_uses_.size())
      fail(polyhedra.to_faces, j, cell, cells,
           fmt::format("the face {} is out of range, there are {}", to_faces_[j], face_uses_.size()));
    // This check also limits the memory: faces that are referenced many times could expand without bound.
    if (++face_uses_[face] > 2)
      fail(polyhedra.to_faces, j, cell, cells, fmt::format("the face {} belongs to more than two polyhedra", face));
    const auto begin = static_cast<std::size_t>(face_offsets_[face]);
    const auto end = static_cast<std::size_t>(face_offsets_[face + 1]);
    if (end - begin > order_.slots().size())
      fail(polyhedra.face_offsets, face + 1, cell, cells, "a face has more points than there are");
    cells.faces.push_back(static_cast<Index>(end - begin));
    for (std::size_t i = begin; i < end; ++i)
      cells.faces.push_back(slot(polyhedra.face_connectivity, i, face_connectivity_[i], cell, cells));
  }
}

}  // namespace volccd::detail
