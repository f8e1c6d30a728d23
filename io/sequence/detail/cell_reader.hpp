// Reads and checks the cells of a frame.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <volccd/io/sequence/cells.hpp>
#include <volccd/io/sequence/detail/layout.hpp>
#include <volccd/io/sequence/detail/point_order.hpp>
#include <volccd/mesh/collapse_element.hpp>

namespace volccd::detail {

class CellReader {
 public:
  /// Both arguments must outlive the reader.
  CellReader(const SequenceLayout& layout, const PointOrder& order) : layout_(layout), order_(order) {}

  /// Whether both frames read all their cell arrays (except thickness) from the same rows.
  bool have_same_cells(std::size_t frame, std::size_t other) const;

  /// Replaces `cells` by the cells of a frame. Throws InputError with dataset and row; the text contains the cell's id
  /// and the frame.
  void read(std::size_t frame, SequenceCells& cells) { read_part(frame, 0, layout_.cells_of(frame), cells); }
  /// The same for `count` cells after the first `first` ones; ids are distinct among these. For part of a frame, the
  /// layout must be without polyhedra.
  void read_part(std::size_t frame, std::int64_t first, std::int64_t count, SequenceCells& cells);

  /// Numbers of cells with repeated nodes in the last read(), by type in the file and type of the element read.
  using CollapsedCounts = std::map<std::pair<ElementType, ElementType>, std::uint64_t>;
  const CollapsedCounts& collapsed() const { return collapsed_counts_; }

  /// Text such as " (cell id 7, frame 2)" for cell i of a frame. Reads one id from the file.
  std::string place(std::size_t frame, std::size_t i) const;

 private:
  /// A cell in which a node occurs twice, and the row of the second occurrence.
  struct Repeated {
    std::size_t cell, row;
  };

  void read_types(SequenceCells& cells);
  void read_offsets(SequenceCells& cells);
  void read_connectivity(SequenceCells& cells);
  void read_objects(SequenceCells& cells);
  void read_ids(SequenceCells& cells);
  void read_polyhedra(SequenceCells& cells);
  void append_polyhedron(std::size_t cell, SequenceCells& cells);
  /// Replaces the cells listed in repeated_ by the elements that they represent.
  void collapse(SequenceCells& cells);
  /// Throws an InputError for a row of an array, counted from the first row of the part, which belongs to a cell of it.
  [[noreturn]] void fail(const FrameArray& array, std::size_t row, std::size_t cell, const SequenceCells& cells,
                         const std::string& problem) const;

  /// Reads `count` + 1 non-descending offsets after the first `first` ones, of `all` + 1 that begin with 0 and end with
  /// `length`.
  void read_monotone(const FrameArray& array, std::int64_t first, std::int64_t count, std::int64_t all,
                     std::int64_t length, std::vector<std::int64_t>& out) const;
  /// The number of a cell of the part in the frame.
  std::size_t number(std::size_t i) const { return static_cast<std::size_t>(first_) + i; }
  /// The vertex slot of a point of the file, which row `row` of the array has for a cell.
  Index slot(const FrameArray& array, std::size_t row, std::int64_t point, std::size_t cell,
             const SequenceCells& cells) const;

  std::size_t frame_ = 0;                ///< the frame that is being read
  std::int64_t first_ = 0, count_ = 0;   ///< the part of its cells
  std::int64_t first_connectivity_ = 0;  ///< row of the connectivity of the first cell in that of the frame
  const SequenceLayout& layout_;
  const PointOrder& order_;
  std::vector<std::int64_t> numbers_, face_connectivity_, face_offsets_, to_faces_, cell_faces_;
  std::vector<Index> used_;
  std::vector<Repeated> repeated_;  ///< in ascending order of cells
  CollapsedCounts collapsed_counts_;
  std::vector<std::uint8_t> face_uses_;
};

}  // namespace volccd::detail
