// The features in contact, over time, for ParaView: a series (.pvd) of VTK XML PolyData.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <volccd/io/output_file.hpp>
#include <volccd/io/step_text.hpp>
#include <volccd/mesh/mesh.hpp>
#include <volccd/query/contact.hpp>
#include <volccd/query/motion.hpp>

namespace volccd {

/// run.pvd lists run_0000.vtp, run_0001.vtp, ... in the same folder, of one time each. The file of a step's end has
/// each vertex, edge and triangle that is in contact in the step, once, where it is at that end; the first file, of the
/// time before all steps, is empty. Cell data: Feature (0: vertex, 1: edge, 2: triangle), Contacts (how many of the
/// step have it), TimeOfImpact (the earliest, in [0, 1] of the step), Time (the same, of the sequence), AtStart,
/// Object, Element (ContactSide). Point data: VertexIds. The files of the steps are complete as soon as they are there;
/// the .pvd is written at the end, by the rules of OutputFile. O(n log n) a step for n contacts.
class ContactFeaturesWriter {
 public:
  /// Why the .pvd has to be a regular file.
  static constexpr const char* kOnlyFiles = "a series has a file for each step beside it; give the name of a file";
  /// Whether the name ends with .pvd.
  static bool is_series(const std::string& file);

  /// Throws InputError if the file cannot be written, or is no regular file.
  explicit ContactFeaturesWriter(const std::string& file);

  /// Contacts of this step, from `begin_time` to `end_time`, in any order. `step` is greater than before. Throws
  /// InputError if the file of the step cannot be written; the steps before are kept.
  void write_step(int step, double begin_time, double end_time, std::span<const Contact> contacts, const Mesh& mesh,
                  const Motion& motion);
  void finish();
  /// Keeps the complete steps and a comment with steps.text() in the second line.
  StepsDone finish_incomplete(const StepsDone& steps);

 private:
  struct Entry {
    int step;  ///< that ends at the time; of the first entry, the step that begins
    double time;
    std::string file;  ///< without the folder
  };
  void write_frame(int step, double begin_time, double end_time, std::span<const Contact> contacts, const Mesh& mesh,
                   const Motion& motion);
  void write(const std::string& comment);
  std::string file_of(int number) const;

  OutputFile output_;
  std::string stem_;
  std::vector<Entry> entries_;
};

}  // namespace volccd
