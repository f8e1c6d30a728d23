// The cells of a step, read and checked.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <volccd/mesh/detail/collapse_element.hpp>
#include <volccd/mesh/sequence/cells.hpp>
#include <volccd/mesh/sequence/detail/layout.hpp>
#include <volccd/mesh/sequence/detail/point_order.hpp>

namespace volccd::detail {

class CellReader {
 public:
  /// Both outlive it.
  CellReader(const SequenceLayout& layout, const PointOrder& order) : layout_(layout), order_(order) {}

  /// Whether both steps read all their cell arrays (but for the thickness) from the same rows.
  bool same(std::size_t step, std::size_t other) const;

  /// Replaces `cells`. Throws InputError with dataset and row; the text names the cell's id and the step.
  void read(std::size_t step, SequenceCells& cells);

  /// Cells of the last read() whose nodes repeat in the file: how many, by type in the file and type read.
  using CollapsedCounts = std::map<std::pair<ElementType, ElementType>, std::uint64_t>;
  const CollapsedCounts& collapsed() const { return collapsed_counts_; }

  /// " (cell id 7, step 2)" for cell i of a step; reads one id.
  std::string place(std::size_t step, std::size_t i) const;

 private:
  /// A cell in which a node occurs twice, and the row of its second occurrence.
  struct Repeated {
    std::size_t cell;
    std::int64_t row;
  };

  void read_types(std::size_t step, SequenceCells& cells);
  void read_offsets(std::size_t step, SequenceCells& cells);
  void read_connectivity(std::size_t step, SequenceCells& cells);
  void read_parts(std::size_t step, SequenceCells& cells);
  void read_ids(std::size_t step, SequenceCells& cells);
  void read_polyhedra(std::size_t step, SequenceCells& cells);
  void append_polyhedron(std::size_t step, std::size_t cell, SequenceCells& cells);
  /// Replaces the cells of repeated_ by the elements that they are.
  void collapse(std::size_t step, SequenceCells& cells);
  CollapsedElement collapsed_element(std::size_t step, const Repeated& repeated, const SequenceCells& cells) const;
  /// place(), with the ids at hand.
  static std::string place(std::size_t step, std::size_t i, const SequenceCells& cells);

  /// Reads `count` + 1 offsets into [0, length] that start at 0, never fall and end at `length`.
  void read_monotone(const StepArray& array, std::size_t step, std::int64_t count, std::int64_t length,
                     std::vector<std::int64_t>& out);
  /// The vertex slot of point `value` of the file, which stands in row `row`; `place()` names the cell in an error.
  template <class Place>
  Index slot(const StepArray& array, std::int64_t row, std::int64_t value, const Place& place) const;

  const SequenceLayout& layout_;
  const PointOrder& order_;
  std::vector<std::int64_t> numbers_;
  std::vector<std::int64_t> sorted_ids_;
  std::vector<std::int64_t> face_connectivity_, face_offsets_, to_faces_, cell_faces_;
  std::vector<Index> used_;
  std::vector<Repeated> repeated_;  ///< by ascending cell
  CollapsedCounts collapsed_counts_;
  std::vector<std::uint8_t> face_uses_;
};

}  // namespace volccd::detail
